//! From light to bytes: vignetting, exposure, noise, rounding.
//!
//! The noise of a row of pixels is the sum of two runs through a table of 65536 normal numbers, each begun at a place drawn from the
//! stream of the image's stamp: white, within a thousandth of the deviation asked for, and no dearer than reading memory.

use super::config::{LensConfig, SensorConfig};
use dpn_core::Stamp;
use dpn_core::camera::CameraModel;
use dpn_core::random::Stream;
use nalgebra::Vector2;
use pulp::{Arch, Simd, WithSimd};
use rand::{Rng, RngCore};
use rand_distr::StandardNormal;

/// Places where a run through the table may begin.
const STARTS: usize = 1 << 16;

/// How a frame was exposed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Exposed {
    /// Grey values a unit of light.
    pub(super) factor: f32,
    /// Gain beyond what the exposure gives.
    pub(super) gain: f32,
}

/// A sensor: what it makes of light is a function of the light, its exposure and the image's stamp.
#[derive(Debug, Clone)]
pub(super) struct Sensor {
    config: SensorConfig,
    width: usize,
    /// Share of the light that reaches each pixel.
    share: Vec<f32>,
    /// Normal numbers; behind the last start there is a whole row more.
    table: Vec<f32>,
    stream: Stream,
}

impl Sensor {
    pub(super) fn new(
        config: SensorConfig,
        lens: &LensConfig,
        camera: &CameraModel,
        stream: &Stream,
    ) -> Self {
        let [width, height] = camera.size().map(|side| side as usize);
        let far = |at: f64, side: usize| at.max(side as f64 - 1.0 - at);
        let corner2 =
            Vector2::new(far(camera.principal().x, width), far(camera.principal().y, height)).norm_squared();
        let sees_all = camera.sees_all();
        let share = (0..width * height).map(|i| {
            let place = Vector2::new((i % width) as f64, (i / width) as f64);
            // Outside a fish-eye's circle it is dark.
            if !sees_all && camera.sight(&place).is_none() {
                return 0.0;
            }
            // Halfway between a parabola and cos^4: little happens near the axis.
            let r2 = (place - camera.principal()).norm_squared() / corner2;
            (1.0 - lens.vignetting * r2 * (0.5 + 0.5 * r2)) as f32
        });
        let mut rng = stream.named("noise-table").rng();
        let mut table: Vec<f32> =
            (0..STARTS).map(|_| rng.sample::<f32, _>(StandardNormal) * 0.5_f32.sqrt()).collect();
        table.extend_from_within(..width.min(STARTS));
        Self { config, width, share: share.collect(), table, stream: stream.named("shot") }
    }

    /// The bytes of `light`, an image as large as the camera's, taken at `t`.
    pub(super) fn take(&self, light: &[f32], exposed: Exposed, t: Stamp, pixels: &mut Vec<u8>) {
        pixels.resize(light.len(), 0);
        let mut rng = self.stream.index(t.ns() as u64).rng();
        let starts: Vec<[usize; 2]> = (0..light.len() / self.width)
            .map(|_| {
                let draw = rng.next_u32();
                [(draw & 0xffff) as usize, (draw >> 16) as usize]
            })
            .collect();
        Arch::new().dispatch(Take { sensor: self, light, exposed, starts: &starts, pixels });
    }
}

struct Take<'a> {
    sensor: &'a Sensor,
    light: &'a [f32],
    exposed: Exposed,
    starts: &'a [[usize; 2]],
    pixels: &'a mut [u8],
}

impl WithSimd for Take<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { sensor, light, exposed: Exposed { factor, gain }, starts, pixels } = self;
        let (read, shot) = (sensor.config.read_grey as f32, sensor.config.shot_grey as f32);
        let (read2, shot) = (gain * gain * read * read, gain * shot);
        let width = sensor.width;
        let rows = light.chunks_exact(width).zip(sensor.share.chunks_exact(width));
        for ((to, (light, share)), [first, second]) in pixels.chunks_exact_mut(width).zip(rows).zip(starts) {
            let (first, second) = (&sensor.table[*first..][..width], &sensor.table[*second..][..width]);
            let normals = first.iter().zip(second);
            for (((to, light), share), (a, b)) in to.iter_mut().zip(light).zip(share).zip(normals) {
                let grey = factor * share * light;
                // A full well is full: what saturates has no more noise than the brightest grey.
                let deviation = (read2 + shot * grey.clamp(0.0, 255.0)).sqrt();
                // Adding 1.5 * 2^23 rounds to a whole number in the lowest bits.
                *to = ((grey + deviation * (a + b)).clamp(0.0, 255.0) + 12_582_912.0).to_bits() as u8;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sensor(config: SensorConfig, vignetting: f64) -> Sensor {
        let lens = LensConfig { vignetting, ..LensConfig::default() };
        Sensor::new(config, &lens, &CameraModel::euroc_cam0(), &Stream::new(1))
    }

    fn take(sensor: &Sensor, light: f32, exposed: Exposed, t: i64) -> Vec<u8> {
        let mut pixels = Vec::new();
        sensor.take(&vec![light; 752 * 480], exposed, Stamp::from_ns(t), &mut pixels);
        pixels
    }

    const PLAIN: Exposed = Exposed { factor: 1.0, gain: 1.0 };

    #[test]
    fn noise_has_the_variance_asked_for_and_is_white() {
        let config = SensorConfig { read_grey: 2.0, shot_grey: 0.1 };
        let sensor = sensor(config, 0.0);
        for (light, exposed, variance) in [
            (100.0, PLAIN, 4.0 + 10.0),
            (50.0, Exposed { factor: 2.0, gain: 1.0 }, 4.0 + 10.0),
            (50.0, Exposed { factor: 2.0, gain: 3.0 }, 36.0 + 30.0),
        ] {
            let noise: Vec<f64> =
                take(&sensor, light, exposed, 7).iter().map(|g| f64::from(*g) - 100.0).collect();
            let n = noise.len() as f64;
            let mean = noise.iter().sum::<f64>() / n;
            let found = noise.iter().map(|v| v * v).sum::<f64>() / n;
            // 360960 pixels: the deviation of the variance is .24 %, and rounding adds 1/12.
            assert!(mean.abs() < 0.05, "{mean}");
            assert!((found / (variance + 1.0 / 12.0) - 1.0).abs() < 0.015, "{found} {variance}");
            let tails = noise.iter().map(|v| v.powi(4)).sum::<f64>() / n / (found * found);
            assert!((tails - 3.0).abs() < 0.1, "{tails}");
            for lag in [1, 2, 751, 752, 753, 752 * 2] {
                let with = noise.iter().zip(&noise[lag..]).map(|(a, b)| a * b).sum::<f64>() / n / found;
                assert!(with.abs() < 0.01, "lag {lag}: {with}");
            }
        }
    }

    #[test]
    fn images_differ_by_their_stamp_alone_and_corners_are_darker() {
        let sensor = sensor(SensorConfig::default(), 0.3);
        let (a, b) = (take(&sensor, 120.0, PLAIN, 7), take(&sensor, 120.0, PLAIN, 7));
        assert!(a == b && a != take(&sensor, 120.0, PLAIN, 8));
        let mean = |x: usize, y: usize| {
            let block = (0..400).map(|i| f64::from(a[(y + i / 20) * 752 + x + i % 20]));
            block.sum::<f64>() / 400.0
        };
        assert!((mean(357, 238) - 120.0).abs() < 0.5, "{}", mean(357, 238));
        let corner = mean(732, 0);
        assert!((corner / 120.0 - 0.71).abs() < 0.03, "{corner}");
        // Full is full, dark is dark.
        assert!(take(&sensor, 1e4, PLAIN, 1).iter().all(|g| *g == 255));
        assert!(take(&sensor, 0.0, PLAIN, 1).iter().all(|g| *g <= 3));
    }
}
