//! What a calibration does not know of a lens: a smooth field of displacements that stays with the camera.
//!
//! Real lenses have one. On real images of EuRoC (pack `motion`), a field fitted to how the first half's tracks miss their epipolar lines takes an
//! eighth off the median distance of the second half's, and nothing off that of images rendered without a field; the crate's README has the figures.

use dpn_core::random::Stream;
use nalgebra::Vector2;
use rand::Rng;
use std::f64::consts::TAU;

/// Waves that an axis is the sum of.
const WAVES: usize = 6;
/// Shortest and longest wave \[px\] of an image with [`SIDE`] columns.
const LENGTHS: [f64; 2] = [250.0, 600.0];
/// Columns of the image that the lengths are of \[px\].
const SIDE: f64 = 752.0;

/// The field.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Uncalibrated {
    amplitude: f64,
    /// Of each axis: phase per pixel, and the phase \[rad\].
    waves: [[(Vector2<f64>, f64); WAVES]; 2],
}

impl Uncalibrated {
    /// A field of a camera `width` pixels wide with this standard deviation \[px\] an axis.
    pub(crate) fn new(std_px: f64, width: u32, stream: &Stream) -> Self {
        let mut rng = stream.named("uncalibrated").rng();
        let [shortest, longest] = LENGTHS.map(|length| length * f64::from(width) / SIDE);
        let mut wave = || {
            let length = shortest * (longest / shortest).powf(rng.random::<f64>());
            let (sin, cos) = (TAU * rng.random::<f64>()).sin_cos();
            (Vector2::new(cos, sin) * (TAU / length), TAU * rng.random::<f64>())
        };
        let waves = std::array::from_fn(|_| std::array::from_fn(|_| wave()));
        Self { amplitude: std_px * (2.0 / WAVES as f64).sqrt(), waves }
    }

    /// The pixel that the calibration would have for what `px` sees.
    pub(crate) fn calibrated(&self, px: Vector2<f64>) -> Vector2<f64> {
        if self.amplitude == 0.0 {
            return px;
        }
        let at = |waves: &[(Vector2<f64>, f64); WAVES]| -> f64 {
            waves.iter().map(|(per_px, phase)| (per_px.dot(&px) + phase).sin()).sum()
        };
        px + self.amplitude * Vector2::new(at(&self.waves[0]), at(&self.waves[1]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_is_smooth_as_large_as_asked_and_the_same_twice() {
        let (mut squares, mut steepest, mut count) = (0.0, 0.0_f64, 0.0);
        for seed in 0..20 {
            let field = Uncalibrated::new(0.3, 752, &Stream::new(seed));
            assert_eq!(field, Uncalibrated::new(0.3, 752, &Stream::new(seed)));
            for place in 0..400 {
                let px = Vector2::new(f64::from(place % 25 * 30), f64::from(place / 25 * 30));
                let off = |px: Vector2<f64>| field.calibrated(px) - px;
                squares += off(px).norm_squared() / 2.0;
                steepest = steepest.max((off(px + Vector2::new(1.0, 0.0)) - off(px)).norm());
                count += 1.0;
            }
        }
        let std_px = f64::sqrt(squares / count);
        assert!((std_px / 0.3 - 1.0).abs() < 0.15, "{std_px}");
        assert!(steepest < 0.03, "{steepest}");
        let none = Uncalibrated::new(0.0, 752, &Stream::new(1));
        assert_eq!(none.calibrated(Vector2::new(3.0, 4.0)), Vector2::new(3.0, 4.0));
    }
}
