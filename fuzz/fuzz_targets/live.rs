//! Messages of running sensors: sixteen bytes are one, with a stamp and values of its own.
#![no_main]

use dpn_core::{GrayImage, ImuSample, Stamp};
use dpn_io::calibration::{Calibration, parse};
use dpn_live::{Fed, Listener, LiveError, LiveRun, Seen, Watched};
use dpn_vio::EstimatorConfig;
use libfuzzer_sys::fuzz_target;
use std::path::Path;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

const CAMERA: &str = "resolution: [48, 32]\nrate_hz: 20\ncamera_model: pinhole\nintrinsics: [30.0, 30.0, 24.0, 16.0]\n\
                      distortion_model: radial-tangential\ndistortion_coefficients: [0.0, 0.0, 0.0, 0.0]\n\
                      T_BS:\n  rows: 4\n  cols: 4\n  data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n";

static CALIBRATION: LazyLock<Calibration> =
    LazyLock::new(|| parse(CAMERA.as_bytes(), Path::new("sensor.yaml")).expect("a camera"));

/// The last pose's stamp.
#[derive(Default)]
struct Poses(Option<Stamp>);

impl Listener for Poses {
    type Error = LiveError;

    fn update(&mut self, Seen { update, .. }: &Seen<'_>) -> Result<(), LiveError> {
        let Some(state) = update.state else { return Ok(()) };
        let pose = state.world_from_body;
        assert!(pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|v| v.is_finite()));
        assert!(self.0.replace(update.t).is_none_or(|last| update.t > last));
        Ok(())
    }

    fn say(&mut self, words: &str) {
        assert!(!words.is_empty() && words.len() < 1000);
    }

    fn gives_up(&self) -> bool {
        false
    }
}

/// Four bytes as a number: small as they are, or any at all.
fn number(bytes: [u8; 4], wild: bool) -> f64 {
    let bits = u32::from_le_bytes(bytes);
    if wild { f64::from(f32::from_bits(bits)) } else { f64::from(bits as i32) * 1e-8 }
}

fuzz_target!(|bytes: &[u8]| {
    let mut config = EstimatorConfig::default();
    config.window.key_frames = 3;
    config.front_end.corners.most = 20;
    config.front_end.corners.distance_px = 4.0;
    let noise = "x1".parse().expect("a noise");
    let made = LiveRun::new(&config, noise, Vec::new(), &CALIBRATION.camera, Fed::Images, 0);
    let mut watched = Watched::new(made.expect("settings in their bounds"), &CALIBRATION, Poses::default());
    let (mut now, mut stamps) = (Instant::now(), [1_000_000_000_i64; 2]);
    for message in bytes.chunks_exact(16) {
        let [kind, many, rest @ ..] = message else { continue };
        let four = |at: usize| [rest[at], rest[at + 1], rest[at + 2], rest[at + 3]];
        now += Duration::from_millis(u64::from(kind >> 4));
        // A message goes on by a step of its sensor, or by any time at all.
        let is_image = kind & 1 != 0;
        let step = if is_image { 50_000_000 } else { 5_000_000 };
        let by = i64::from(i32::from_le_bytes(four(0)));
        let t = &mut stamps[usize::from(is_image)];
        *t = match kind & 6 {
            0 | 2 => t.saturating_add(step),
            4 => t.saturating_add(by),
            _ => by.saturating_mul(1 << (many & 31)),
        };
        let wild = kind & 8 != 0;
        let taken = if is_image {
            let [dx, dy, grey, _] = four(4);
            let seen = |x: usize, y: usize| {
                let (x, y) = (x + usize::from(dx % 16), y + usize::from(dy % 16));
                grey.wrapping_mul((x / 4 * 7 + y / 4 * 13) as u8)
            };
            watched.take_image(Stamp::from_ns(*t), Ok(GrayImage::from_fn(48, 32, seen).expect("48 x 32")), now)
        } else {
            let [x, y] = [number(four(4), wild), number(four(8), wild)];
            let sample = |t| ImuSample { t, gyro: [x, y, 0.1], accel: [y, x, 9.81] };
            // Samples that go on by themselves, so that few bytes are seconds.
            (0..many % 64).try_for_each(|_| {
                *t = t.saturating_add(step);
                watched.take_sample(sample(Stamp::from_ns(*t)), now)
            })
        };
        taken.expect("whatever comes, the run goes on");
        watched.silences((kind & 128 != 0).then_some(now));
    }
    watched.end().expect("an end");
});
