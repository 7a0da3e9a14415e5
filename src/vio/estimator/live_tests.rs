//! Samples and images as they come live: late, in bursts, out of order, in front of a wall whose picture is known.

use super::{Estimator, EstimatorConfig, FeedError, Update};
use crate::frontend::Status;
use crate::frontend::tests::wall::{Wall, stamp};
use crate::preint::NoisySample;
use dpn_core::geometry::so3;
use dpn_core::{GrayImage, ImuNoise, ImuSample, Stamp};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

/// Seconds of flight.
const SECONDS: f64 = 4.0;
/// Images at 20 Hz.
const IMAGES: usize = 80;

/// At rest for half a second, then a lively path in front of the wall (z forward, y down).
fn pose_at(t: f64) -> Isometry3<f64> {
    let t = t - 0.5;
    let begin = if t > 0.0 { t * t * t / (0.2 + t * t * t) } else { 0.0 };
    let place = Vector3::new(0.6 * (2.1 * t).sin(), 0.4 * (2.7 * t).sin(), 0.3 * (1.9 * t).sin());
    let turn = Vector3::new(0.10 * (2.3 * t).sin(), 0.15 * (1.8 * t).sin(), 0.2 * (1.7 * t).sin());
    Isometry3::from_parts((place * begin).into(), UnitQuaternion::from_scaled_axis(turn * begin))
}

/// What an IMU in the camera's place measures, by differences.
fn sample(i: usize) -> NoisySample {
    const STEP: f64 = 1e-4;
    let t = 0.005 * i as f64;
    let [before, now, after] = [pose_at(t - STEP), pose_at(t), pose_at(t + STEP)];
    let rate = so3::log(&(before.rotation.inverse() * after.rotation)) / (2.0 * STEP);
    let at = |pose: &Isometry3<f64>| pose.translation.vector;
    let accel = (at(&before) - 2.0 * at(&now) + at(&after)) / (STEP * STEP);
    let force = now.rotation.inverse() * (accel - Vector3::y() * 9.81);
    let stamp = Stamp::from_ns(stamp(0).ns() + 5_000_000 * i as i64);
    NoisySample {
        sample: ImuSample { t: stamp, gyro: rate.into(), accel: force.into() },
        noise: ImuNoise::from_values([0.05; 3], [0.003; 3]).unwrap(),
    }
}

struct Case {
    samples: Vec<NoisySample>,
    images: Vec<GrayImage>,
    estimator: Estimator,
}

impl Case {
    fn new() -> Self {
        let wall = Wall::new(12);
        let mut config = EstimatorConfig::default();
        config.front_end.corners.distance_px = 20.0;
        let estimator = Estimator::new(config, wall.camera, Isometry3::identity(), 1).unwrap();
        Self {
            samples: (0..(200.0 * SECONDS) as usize + 20).map(sample).collect(),
            images: (0..IMAGES).map(|i| wall.image(&pose_at(0.05 * i as f64), i as u64)).collect(),
            estimator,
        }
    }

    /// Feeds all, the images `late` samples after their own (before it, where negative), and takes updates after every `burst` samples.
    fn run(&self, late: isize, burst: usize) -> Vec<Update> {
        let mut estimator = self.estimator.clone();
        let mut updates = Vec::new();
        let mut images = self.images.iter().enumerate().peekable();
        for (i, sample) in self.samples.iter().enumerate() {
            while let Some((k, image)) = images.next_if(|(k, _)| 10 * *k as isize + late <= i as isize) {
                estimator.feed_image(image.view(), stamp(k)).unwrap();
            }
            estimator.feed_imu(*sample).unwrap();
            if i % burst == 0 {
                updates.extend(std::iter::from_fn(|| estimator.next_update()));
            }
        }
        for (k, image) in images {
            estimator.feed_image(image.view(), stamp(k)).unwrap();
        }
        updates.extend(std::iter::from_fn(|| estimator.next_update()));
        updates
    }
}

/// Updates without the time they took.
fn timeless(updates: Vec<Update>) -> Vec<Update> {
    updates.into_iter().map(|update| Update { seconds: 0.0, ..update }).collect()
}

#[test]
fn late_and_early_images_and_bursts_of_samples_change_no_bit() {
    let case = Case::new();
    let once = timeless(case.run(0, 1));
    assert_eq!(once.len(), IMAGES / 2, "every second image is handed over");
    let last = once.last().unwrap().state.expect("it has initialised");
    // The world of the estimate has its own heading: what both agree on is the way from the first pose.
    let first = once.iter().find_map(|u| Some((u.t, u.state?))).unwrap();
    let place = |t: Stamp| pose_at(t.seconds_since(stamp(0))).translation.vector;
    let truth = (place(once.last().unwrap().t) - place(first.0)).norm();
    let way = (last.world_from_body.translation.vector - first.1.world_from_body.translation.vector).norm();
    assert!((way - truth).abs() < 0.03 + 0.03 * truth, "{way} m, {truth} m in truth");
    for (late, burst) in [(-200, 1), (120, 1), (0, 90), (-30, 37)] {
        assert_eq!(timeless(case.run(late, burst)), once, "images {late} samples late, bursts of {burst}");
    }
}

#[test]
fn what_comes_out_of_order_is_refused_by_name_and_changes_nothing() {
    let case = Case::new();
    let once = timeless(case.run(0, 1));
    let mut estimator = case.estimator.clone();
    let mut updates = Vec::new();
    for (i, sample) in case.samples.iter().enumerate() {
        if i % 10 == 0 && i / 10 < IMAGES {
            let k = i / 10;
            estimator.feed_image(case.images[k].view(), stamp(k)).unwrap();
            for (again, t) in [(k, stamp(k)), (0, stamp(0)), (0, Stamp::from_ns(i64::MIN))] {
                let refused = estimator.feed_image(case.images[again].view(), t);
                assert_eq!(refused, Err(FeedError::ImageOutOfOrder { t, last: stamp(k) }));
            }
            let small = GrayImage::from_fn(8, 8, |x, y| (x * y) as u8).unwrap();
            let refused = estimator.feed_image(small.view(), stamp(k).plus_seconds(0.01)).unwrap_err();
            assert!(refused.to_string().contains("8 x 8 px") && refused.to_string().contains("376 x 240"));
        }
        estimator.feed_imu(*sample).unwrap();
        assert!(matches!(estimator.feed_imu(case.samples[i / 2]), Err(FeedError::SampleOutOfOrder { .. })));
        updates.extend(std::iter::from_fn(|| estimator.next_update()));
    }
    assert_eq!(timeless(updates), once);
    assert_eq!(estimator.last_image().map(|report| report.status), Some(Status::Tracked));
}

#[test]
fn a_silent_imu_is_said_and_costs_no_more_memory() {
    let case = Case::new();
    let mut estimator = case.estimator.clone();
    for (k, image) in case.images.iter().enumerate() {
        let fed = estimator.feed_image(image.view(), stamp(k));
        if k < super::eye::MOST_WAITING {
            assert_eq!(fed, Ok(()));
        } else {
            let error = fed.unwrap_err();
            assert!(matches!(error, FeedError::ImuBehind { waiting: 40, .. }), "{error}");
        }
        assert!(estimator.next_update().is_none());
    }
    // When samples come after all, what waited is worked off.
    case.samples.iter().for_each(|sample| estimator.feed_imu(*sample).unwrap());
    let updates = std::iter::from_fn(|| estimator.next_update()).count();
    assert_eq!(updates, super::eye::MOST_WAITING / 2);
}
