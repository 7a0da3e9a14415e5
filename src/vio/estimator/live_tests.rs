//! Samples and images as they come live: late, in bursts, out of order, spoilt, in front of a wall whose picture is known.

use super::{
    Doubt, Estimator, EstimatorConfig, FedTracks, FeedError, FrontEndObserver, ImageTracker, Phase, Update,
    doubts,
};
use crate::components::ComponentsConfig;
use crate::frontend::tests::wall::{Wall, half_camera, stamp};
use crate::frontend::{Fed, FrontEndConfig, Status};
use crate::init::WaitReason;
use crate::preint::NoisySample;
use dpn_core::camera::CameraModel;
use dpn_core::geometry::so3;
use dpn_core::{GrayImage, ImuNoise, ImuSample, Stamp, TrackFrame};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use std::sync::OnceLock;

/// Images at 20 Hz: a flight of four seconds, and of twelve.
const IMAGES: usize = 80;
const LONG: usize = 240;

/// At rest for half a second, then a lively path in front of the wall (z forward, y down).
pub(super) fn pose_at(t: f64) -> Isometry3<f64> {
    let t = t - 0.5;
    let begin = if t > 0.0 { t * t * t / (0.2 + t * t * t) } else { 0.0 };
    let place = Vector3::new(0.6 * (2.1 * t).sin(), 0.4 * (2.7 * t).sin(), 0.3 * (1.9 * t).sin());
    let turn = Vector3::new(0.10 * (2.3 * t).sin(), 0.15 * (1.8 * t).sin(), 0.2 * (1.7 * t).sin());
    Isometry3::from_parts((place * begin).into(), UnitQuaternion::from_scaled_axis(turn * begin))
}

/// What an IMU in the camera's place measures, by differences.
pub(super) fn sample(i: usize) -> NoisySample {
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

/// What the camera sees over the long flight.
fn images() -> &'static [GrayImage] {
    static IMAGES: OnceLock<Vec<GrayImage>> = OnceLock::new();
    IMAGES.get_or_init(|| {
        let wall = Wall::new(12);
        (0..LONG).map(|i| wall.image(&pose_at(0.05 * i as f64), i as u64)).collect()
    })
}

fn config() -> EstimatorConfig {
    let mut config = EstimatorConfig::default();
    config.front_end.corners.distance_px = 20.0;
    config
}

fn estimator(camera: CameraModel) -> Estimator {
    Estimator::new(config(), camera, Isometry3::identity(), 1).unwrap()
}

struct Case {
    samples: Vec<NoisySample>,
    images: &'static [GrayImage],
    estimator: Estimator,
}

impl Case {
    fn new() -> Self {
        Self {
            samples: (0..10 * IMAGES + 20).map(sample).collect(),
            images: &images()[..IMAGES],
            estimator: estimator(half_camera()),
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
        let mut spike = *sample;
        spike.sample.t = sample.sample.t.plus_seconds(0.001);
        spike.sample.gyro[0] = 1000.0;
        assert!(matches!(estimator.feed_imu(spike), Err(FeedError::Spike { .. })));
        updates.extend(std::iter::from_fn(|| estimator.next_update()));
    }
    assert_eq!(timeless(updates), once);
    assert_eq!(estimator.report().spikes, case.samples.len());
}

/// What became of the images, in their order.
#[derive(Default)]
struct Statuses {
    begun: Vec<Stamp>,
    ended: Vec<(Stamp, Status)>,
    /// Frames handed over.
    frames: Vec<TrackFrame>,
    /// What their stamps are late by \[s\].
    late_s: f64,
}

impl FrontEndObserver for Statuses {
    fn begin(&mut self, t: Stamp) {
        self.begun.push(t);
    }

    fn end(&mut self, image: &GrayImage, fed: &Fed) {
        let (k, _) = (0..LONG)
            .map(|k| (k, stamp(k).plus_seconds(self.late_s)))
            .find(|(_, t)| *t == fed.report.t)
            .unwrap();
        assert!(*image == images()[k], "image {k} is another");
        self.ended.push((fed.report.t, fed.report.status));
        self.frames.extend(fed.frame.clone());
    }
}

#[test]
fn who_looks_on_sees_every_image_once_and_changes_no_bit_nor_do_tracks_made_before() {
    let case = Case::new();
    let once = timeless(case.run(0, 1));

    let mut watched = case.estimator.clone();
    let mut seen = Statuses::default();
    let mut updates = Vec::new();
    for (i, sample) in case.samples.iter().enumerate() {
        if i % 10 == 0 && i / 10 < IMAGES {
            watched.feed_image(case.images[i / 10].view(), stamp(i / 10)).unwrap();
        }
        watched.feed_imu(*sample).unwrap();
        watched.track_images(&mut seen);
        updates.extend(std::iter::from_fn(|| watched.next_update()));
    }
    assert_eq!(timeless(updates), once);
    assert_eq!(seen.begun, (0..IMAGES).map(stamp).collect::<Vec<_>>());
    assert_eq!(seen.ended.iter().map(|(t, _)| *t).collect::<Vec<_>>(), seen.begun);
    assert_eq!(seen.ended.iter().filter(|(_, status)| *status == Status::HandedOver).count(), IMAGES / 2);

    // Tracks made by the same tracker alone, before any estimate and whatever the noise, then fed as frames.
    let config = config().front_end;
    let mut tracker = ImageTracker::new(config, half_camera(), UnitQuaternion::identity(), 1).unwrap();
    let mut alone = Statuses::default();
    for (k, image) in case.images.iter().enumerate() {
        tracker.feed_image(image.view(), stamp(k)).unwrap();
        let samples = (0..=10 * k + 10).map(|i| &case.samples[i]);
        samples.skip(if k == 0 { 0 } else { 10 * k + 1 }).for_each(|s| tracker.feed_imu(&s.sample).unwrap());
        while tracker.next_frame(&mut alone).is_some() {}
    }
    assert_eq!(alone.frames, seen.frames);
    // What a tracker that looks for the clock hands over where that is right is what one hands over that is told so.
    let told = FrontEndConfig { time_offset_s: Some(0.0), ..config };
    let mut told = ImageTracker::new(told, half_camera(), UnitQuaternion::identity(), 1).unwrap();
    case.samples.iter().for_each(|s| told.feed_imu(&s.sample).unwrap());
    let mut frames = Vec::new();
    for (k, image) in case.images.iter().enumerate() {
        told.feed_image(image.view(), stamp(k)).unwrap();
        frames.extend(std::iter::from_fn(|| told.next_frame(&mut ())));
    }
    assert_eq!(frames, alone.frames);
    let mut settings = self::config();
    settings.fed_tracks = FedTracks::Followed;
    let mut estimator = Estimator::new(settings, half_camera(), Isometry3::identity(), 1).unwrap();
    alone.frames.into_iter().for_each(|frame| estimator.feed_frame(frame).unwrap());
    case.samples.iter().for_each(|sample| estimator.feed_imu(*sample).unwrap());
    let updates = std::iter::from_fn(|| estimator.next_update()).collect();
    assert_eq!(timeless(updates), once);

    // Another seed is another chance: other tracks.
    let mut other = ImageTracker::new(config, half_camera(), UnitQuaternion::identity(), 2).unwrap();
    let mut alone = Statuses::default();
    case.samples.iter().for_each(|s| other.feed_imu(&s.sample).unwrap());
    for (k, image) in case.images.iter().enumerate() {
        other.feed_image(image.view(), stamp(k)).unwrap();
        while other.next_frame(&mut alone).is_some() {}
    }
    assert_ne!(alone.frames, seen.frames);
}

#[test]
fn pixels_of_followed_points_are_believed_less_than_those_of_tracks_that_are_fed() {
    let mut settings = config();
    let components = settings.components.insert(ComponentsConfig::default());
    assert!(components.followed_pixel_floor > components.pixel_floor);
    let floors = [components.pixel_floor, components.followed_pixel_floor];
    let new = |settings| Estimator::new(settings, half_camera(), Isometry3::identity(), 1).unwrap();
    let learned = |updates: &[Update]| {
        let levels =
            updates.iter().rev().find_map(|update| update.levels.as_deref()).expect("they are learned");
        levels.pixel * settings.window.pixel_std
    };

    let case = Case { estimator: new(settings.clone()), ..Case::new() };
    let from_images = timeless(case.run(0, 1));
    assert!((learned(&from_images) - floors[1]).abs() < 1e-9, "a wall is followed to less than a pixel");

    let mut followed = Statuses::default();
    let mut images = case.estimator.clone();
    for (k, image) in case.images.iter().enumerate() {
        images.feed_image(image.view(), stamp(k)).unwrap();
        case.samples[10 * k..10 * k + 10].iter().for_each(|sample| images.feed_imu(*sample).unwrap());
        images.track_images(&mut followed);
    }
    images.feed_imu(case.samples[10 * IMAGES]).unwrap();
    images.track_images(&mut followed);
    let fed = |settings| {
        let mut estimator = new(settings);
        followed.frames.iter().for_each(|frame| estimator.feed_frame(frame.clone()).unwrap());
        case.samples.iter().for_each(|sample| estimator.feed_imu(*sample).unwrap());
        timeless(std::iter::from_fn(|| estimator.next_update()).collect())
    };
    assert!(learned(&fed(settings.clone())) < 0.9 * floors[1]);
    let followed = EstimatorConfig { fed_tracks: FedTracks::Followed, ..settings.clone() };
    assert_eq!(fed(followed), from_images);
}

#[test]
fn the_first_images_of_a_late_camera_are_followed_again_by_its_clock() {
    const LATE_S: f64 = 0.06;
    // On its way at the first image.
    let (first, count) = (30, 80);
    let run = |estimator: &mut Estimator, late_s: f64, seen: &mut Statuses| {
        let mut next = 10 * first - 100;
        let mut updates = Vec::new();
        for k in first..first + count {
            estimator.feed_image(images()[k].view(), stamp(k).plus_seconds(late_s)).unwrap();
            (next..10 * k + 30).for_each(|i| estimator.feed_imu(sample(i)).unwrap());
            next = 10 * k + 30;
            estimator.track_images(seen);
            updates.extend(std::iter::from_fn(|| estimator.next_update()));
        }
        timeless(updates)
    };
    let start = |updates: &[Update]| updates.iter().position(|update| update.state.is_some()).unwrap();
    let on_time = run(&mut estimator(half_camera()), 0.0, &mut Statuses::default());
    let mut seen = Statuses { late_s: LATE_S, ..Statuses::default() };
    let late = run(&mut estimator(half_camera()), LATE_S, &mut seen);
    assert!((seen.frames[0].clock_s + LATE_S).abs() < 0.004, "{} s", seen.frames[0].clock_s);
    assert!(seen.frames.windows(2).all(|pair| pair[1].tracks.len() > 40), "points are lost");
    assert!(start(&late) <= start(&on_time) + 2, "{} {}", start(&late), start(&on_time));

    // Tracks that were made before know what was known when they were.
    let settings = EstimatorConfig { fed_tracks: FedTracks::Followed, ..config() };
    let mut fed = Estimator::new(settings, half_camera(), Isometry3::identity(), 1).unwrap();
    (10 * first - 100..10 * (first + count) + 20).for_each(|i| fed.feed_imu(sample(i)).unwrap());
    seen.frames.iter().for_each(|frame| fed.feed_frame(frame.clone()).unwrap());
    assert_eq!(timeless(std::iter::from_fn(|| fed.next_update()).collect()), late);
}

#[test]
fn a_late_camera_that_rests_first_is_followed_by_its_clock_when_it_begins_to_turn() {
    const LATE_S: f64 = 0.06;
    const REST: usize = 60;
    let wall = Wall::new(12);
    let rest = (0..REST).map(|i| wall.image(&pose_at(0.0), 1000 + i as u64));
    let settings = config().front_end;
    let mut tracker = ImageTracker::new(settings, half_camera(), UnitQuaternion::identity(), 1).unwrap();
    let (mut frames, mut next) = (Vec::new(), 0);
    for (k, image) in rest.chain(images()[..70].iter().cloned()).enumerate() {
        tracker.feed_image(image.view(), stamp(k).plus_seconds(LATE_S)).unwrap();
        for i in next..10 * k + 30 {
            let t = stamp(0).plus_seconds(0.005 * i as f64);
            tracker
                .feed_imu(&ImuSample { t, ..sample(usize::max(i, 10 * REST) - 10 * REST).sample })
                .unwrap();
        }
        next = 10 * k + 30;
        frames.extend(std::iter::from_fn(|| tracker.next_frame(&mut ())));
    }
    // A second after it began to move.
    let moves = stamp(REST + 20);
    let (still, moving): (Vec<_>, Vec<_>) = frames.iter().partition(|frame| frame.t < moves);
    assert!(still.len() > 30 && moving.len() > 20, "{} {}", still.len(), moving.len());
    assert!(still[..REST / 2].iter().all(|frame| frame.clock_s == 0.0));
    let off = |frame: &&TrackFrame| (frame.clock_s + LATE_S).abs();
    assert!(
        moving.iter().all(|frame| off(frame) < 0.004 && frame.tracks.len() > 40),
        "{:?}",
        tracker.clock()
    );
}

#[test]
fn images_after_the_last_sample_are_followed_when_no_more_come_and_have_no_pose() {
    let case = Case::new();
    let mut estimator = case.estimator.clone();
    case.samples[..10 * 60].iter().for_each(|sample| estimator.feed_imu(*sample).unwrap());
    let mut seen = Statuses::default();
    for (k, image) in case.images.iter().enumerate() {
        estimator.feed_image(image.view(), stamp(k)).unwrap();
        estimator.track_images(&mut seen);
    }
    assert_eq!(seen.ended.len(), 60);
    estimator.end_imu();
    estimator.track_images(&mut seen);
    assert_eq!(seen.ended.len(), IMAGES);
    let updates: Vec<Update> = std::iter::from_fn(|| estimator.next_update()).collect();
    assert_eq!(updates.len(), 30);
    assert!(updates.iter().all(|update| update.t <= case.samples[599].sample.t));
}

#[test]
fn every_fault_of_the_settings_is_named_at_once() {
    let mut config = EstimatorConfig::default();
    config.window.key_frames = 2;
    config.front_end.klt.window = 20;
    let faults = Estimator::new(config, half_camera(), Isometry3::identity(), 1).unwrap_err();
    let keys: Vec<&str> = faults.iter().map(|fault| fault.key.as_str()).collect();
    assert_eq!(keys, ["window.key_frames", "front_end.klt.window"]);
}

#[test]
fn a_start_without_frames_is_none_and_the_odometry_begins_by_itself() {
    let case = Case::new();
    let mut estimator = case.estimator.clone();
    assert_eq!(estimator.start(Vec::new()), None);
    for (k, image) in case.images.iter().enumerate() {
        case.samples[10 * k..10 * k + 10].iter().for_each(|sample| estimator.feed_imu(*sample).unwrap());
        estimator.feed_image(image.view(), stamp(k)).unwrap();
        while let Some(update) = estimator.next_update() {
            assert!(!matches!(update.phase, Phase::Restarted(_)), "{update:?}");
        }
        if k == 60 {
            // In the middle of a flight too: nothing is left that could run on.
            assert_eq!(estimator.start(Vec::new()), None);
        }
    }
}

#[test]
fn a_silent_imu_is_said_and_costs_no_more_memory() {
    let case = Case::new();
    let mut estimator = case.estimator.clone();
    for (k, image) in case.images.iter().enumerate() {
        let fed = estimator.feed_image(image.view(), stamp(k));
        if k < super::image_tracker::MOST_WAITING {
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
    assert_eq!(updates, super::image_tracker::MOST_WAITING / 2);
}

/// What a spoilt flight left: updates, and every pose's error where the first pose is taken for right \[m\].
struct Spoilt {
    updates: Vec<Update>,
    errors: Vec<(usize, f64)>,
    doubts: Vec<Doubt>,
    passed_over: usize,
}

/// Counts images that no point was followed into.
struct PassedOver(usize);

impl FrontEndObserver for PassedOver {
    fn end(&mut self, _: &GrayImage, fed: &Fed) {
        self.0 += usize::from(!matches!(fed.report.status, Status::Tracked | Status::HandedOver));
    }
}

/// The long flight, with each image changed, or lost, by `spoil`.
fn spoilt(camera: CameraModel, spoil: impl Fn(usize) -> Option<GrayImage>) -> Spoilt {
    let mut estimator = estimator(camera);
    let mut left = Spoilt { updates: Vec::new(), errors: Vec::new(), doubts: Vec::new(), passed_over: 0 };
    let mut over = PassedOver(0);
    for i in 0..10 * LONG {
        if i % 10 == 0
            && let Some(image) = spoil(i / 10)
        {
            // One of another size is refused by name; nothing else is.
            if let Err(error) = estimator.feed_image(image.view(), stamp(i / 10)) {
                assert!(matches!(error, FeedError::ImageSize { .. }), "{error}");
                left.passed_over += 1;
            }
        }
        estimator.feed_imu(sample(i)).unwrap();
        estimator.track_images(&mut over);
        left.updates.extend(std::iter::from_fn(|| estimator.next_update()));
    }
    left.passed_over += over.0;
    left.doubts = doubts(estimator.report(), None);
    let pose = |t: Stamp| pose_at(t.seconds_since(stamp(0)));
    let mut from_truth = None;
    for update in &left.updates {
        if let Phase::Restarted(_) = update.phase {
            from_truth = None;
        }
        let Some(state) = update.state else { continue };
        let from_truth = *from_truth.get_or_insert(state.world_from_body * pose(update.t).inverse());
        let expected = from_truth * pose(update.t);
        let error = (state.world_from_body.translation.vector - expected.translation.vector).norm();
        left.errors.push((((update.t.ns() - stamp(0).ns()) / 50_000_000) as usize, error));
    }
    left
}

fn even(grey: u8) -> GrayImage {
    GrayImage::from_fn(376, 240, |_, _| grey).unwrap()
}

/// Black with a sensor's last bit trembling.
fn dark(i: usize) -> GrayImage {
    GrayImage::from_fn(376, 240, |x, y| ((x * 31 + y * 17 + i * 7) % 3) as u8).unwrap()
}

#[test]
fn bad_images_cost_poses_and_invent_none() {
    type Spoil = Box<dyn Fn(usize) -> Option<GrayImage>>;
    let image = |i: usize| Some(images()[i].clone());
    let bright = |image: &GrayImage| {
        let pixels = image.pixels().iter().map(|v| (f32::from(*v) * 0.55 + 60.0) as u8).collect();
        GrayImage::new(376, 240, pixels).unwrap()
    };
    let cases: Vec<(&str, Spoil, usize, f64)> = vec![
        ("nothing", Box::new(image), 0, 0.04),
        ("one black", Box::new(move |i| if i == 100 { Some(even(0)) } else { image(i) }), 1, 0.04),
        (
            "three saturated",
            Box::new(move |i| if (100..103).contains(&i) { Some(even(255)) } else { image(i) }),
            3,
            0.04,
        ),
        (
            "frozen for a second",
            Box::new(move |i| image(if (100..120).contains(&i) { 100 } else { i })),
            19,
            0.3,
        ),
        ("every second repeated", Box::new(move |i| image(i / 2 * 2)), LONG / 2, 0.04),
        (
            "another size",
            Box::new(move |i| {
                if i == 120 { GrayImage::from_fn(752, 480, |x, y| (x ^ y) as u8).ok() } else { image(i) }
            }),
            1,
            0.04,
        ),
        (
            "a jump in exposure",
            Box::new(move |i| if i >= 120 { Some(bright(&images()[i])) } else { image(i) }),
            0,
            0.04,
        ),
        ("30 % lost", Box::new(move |i| if (i * 7919) % 10 < 3 { None } else { image(i) }), 0, 0.04),
    ];
    for (name, spoil, passed_over, most) in cases {
        let left = spoilt(half_camera(), spoil);
        let worst = left.errors.iter().map(|(_, error)| *error).fold(0.0, f64::max);
        let restarts = left.updates.iter().filter(|u| matches!(u.phase, Phase::Restarted(_))).count();
        eprintln!(
            "{name}: {} poses, worst {worst:.3} m, {restarts} restarts, {} passed over",
            left.errors.len(),
            left.passed_over
        );
        assert_eq!(left.passed_over, passed_over, "{name}");
        assert!(
            left.errors.len() > 60 && worst < most,
            "{name}: {} poses, worst {worst} m",
            left.errors.len()
        );
    }
}

#[test]
fn in_the_dark_there_is_no_pose_and_with_the_light_it_goes_on_or_begins_anew() {
    // Five seconds of darkness in flight.
    let left =
        spoilt(half_camera(), |i| Some(if (80..180).contains(&i) { dark(i) } else { images()[i].clone() }));
    assert_eq!(left.passed_over, 100);
    assert!(left.errors.iter().all(|(i, _)| !(80..180).contains(i)), "a pose in the dark");
    let before = left.errors.iter().filter(|(i, _)| *i < 80).count();
    let after: Vec<f64> = left.errors.iter().filter(|(i, _)| *i >= 180).map(|(_, error)| *error).collect();
    // It went on by the IMU alone: half a metre in five seconds is what samples of this noise allow.
    let worst = after.iter().copied().fold(0.0, f64::max);
    eprintln!("dark: {before} poses before, {} after, at most {worst:.3} m off", after.len());
    assert!(before > 20 && after.len() > 20 && worst < 0.5, "{before} {after:?}");

    // A cap on the lens at the start.
    let left = spoilt(half_camera(), |i| Some(if i < 100 { dark(i) } else { images()[i].clone() }));
    assert!(left.errors.iter().all(|(i, _)| *i >= 100), "a pose under the cap");
    let worst = left.errors.iter().map(|(_, error)| *error).fold(0.0, f64::max);
    assert!(left.errors.len() > 20 && worst < 0.05, "{} poses, {worst} m", left.errors.len());
}

#[test]
fn a_calibration_of_another_camera_gives_no_poses_or_poses_that_are_doubted() {
    let camera = half_camera();
    let focal = camera.focal() * 1.7;
    let other = CameraModel::radtan([376, 240], [focal.x, focal.y, 150.0, 160.0], [0.3, -0.2, 0.0, 0.0, 0.0])
        .unwrap();
    let left = spoilt(other, |i| Some(images()[i].clone()));
    assert!(left.errors.is_empty() || !left.doubts.is_empty(), "{:?}", left.errors);
    // It says why: what the camera saw and what the IMU felt do not go together.
    let reasons = left.updates[LONG / 4..].iter().filter(|update| {
        matches!(
            update.phase,
            Phase::Initialising(WaitReason::Implausible { .. } | WaitReason::ScaleUncertain { .. })
        )
    });
    assert!(reasons.count() + left.doubts.len() * LONG > LONG / 8);
}
