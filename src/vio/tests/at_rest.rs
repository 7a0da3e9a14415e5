//! Real images of a vehicle at rest, with its real IMU: the estimate stays where it was put, within two millimetres. Idle rotors shake the
//! vehicle by a milliradian and its accelerometer by .8 m/s^2.

use dpn_core::ImuNoise;
use dpn_core::camera::CameraModel;
use dpn_io::ImageFolder;
use dpn_io::asl::Sequence;
use dpn_testing::pack;
use dpn_vio::estimator::{ImageTracker, StartFrame};
use dpn_vio::preint::{NoisySample, Preintegration};
use dpn_vio::{Estimator, EstimatorConfig, ImuBias, NavState};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

/// Frames at rest that the window begins with.
const KNOWN: usize = 4;

fn sequence() -> Option<Sequence> {
    Some(Sequence::open(&pack("images")?.join("V1_01_easy_static")).unwrap())
}

#[test]
fn the_estimate_stays_within_two_millimetres() {
    let Some(sequence) = sequence() else { return };
    let calibration = sequence.camera_config().unwrap().unwrap();
    let camera = CameraModel::try_from(&calibration).unwrap();
    let body_from_cam = calibration.body_from_cam;
    let imu = sequence.imu().unwrap();
    // ADIS16448 at rest: twice its data sheet.
    let noise = ImuNoise::from_values([0.06; 3], [0.005; 3]).unwrap();
    let samples: Vec<NoisySample> =
        imu.samples().iter().map(|sample| NoisySample { sample: *sample, noise }).collect();

    let config = EstimatorConfig::default();
    let mut tracker = ImageTracker::new(config.front_end, camera, body_from_cam.rotation, 1).unwrap();
    imu.samples().iter().for_each(|sample| tracker.feed_imu(sample).unwrap());
    tracker.end_imu();
    let mut frames = Vec::new();
    for image in ImageFolder::open(&sequence).unwrap().prefetch(2) {
        let image = image.unwrap();
        tracker.feed_image(image.image.view(), image.t).unwrap();
        frames.extend(tracker.next_frame(&mut ()));
    }
    assert_eq!(frames.len(), 20);

    // Level and with the biases that rest shows, as an initialisation at rest has them. The ground truth's orientation is no start: a
    // fifth of a degree of tilt moves a body by 3 cm in 1.4 s.
    let mean = |of: &dyn Fn(&NoisySample) -> [f64; 3]| {
        samples.iter().map(|s| Vector3::from(of(s))).sum::<Vector3<f64>>() / samples.len() as f64
    };
    let (force, rate) = (mean(&|s| s.sample.accel), mean(&|s| s.sample.gyro));
    let up = Vector3::z() * 9.81;
    let level = UnitQuaternion::rotation_between(&force, &up).unwrap();
    let bias = ImuBias { accel: force - level.inverse() * up, gyro: rate };
    let state = NavState {
        world_from_body: Isometry3::from_parts(Vector3::zeros().into(), level),
        vel_in_world: Vector3::zeros(),
        bias,
    };
    let mut estimator = Estimator::new(config.clone(), camera, body_from_cam, 1).unwrap();
    let mut start = Vec::new();
    for (i, frame) in frames[..KNOWN].iter().enumerate() {
        let between: Vec<&NoisySample> =
            samples.iter().filter(|s| i > 0 && (frames[i - 1].t..=frame.t).contains(&s.sample.t)).collect();
        let preint = between.split_first().map(|(first, rest)| {
            let mut preint = Preintegration::new(config.imu, bias, **first);
            rest.iter().for_each(|sample| preint.push(**sample));
            preint
        });
        start.push(StartFrame { t: frame.t, state, preint, seen: estimator.sightings(frame) });
    }
    let begin = start[KNOWN - 1].t;
    let first = estimator.start(start).unwrap();
    samples.iter().filter(|s| s.sample.t >= begin).for_each(|s| estimator.feed_imu(*s).unwrap());
    frames[KNOWN..].iter().for_each(|frame| estimator.feed_frame(frame.clone()).unwrap());

    let mut ways = Vec::new();
    while let Some(update) = estimator.next_update() {
        let state = update.state.unwrap_or_else(|| panic!("{update:?}"));
        let way = state.world_from_body.translation.vector - first.world_from_body.translation.vector;
        ways.push(1e3 * way.norm());
    }
    let (last, worst) = (ways[ways.len() - 1], ways.iter().copied().fold(0.0, f64::max));
    eprintln!(
        "at rest for {:.1} s: {last:.2} mm from the start in the end, {worst:.2} mm at most",
        0.1 * ways.len() as f64
    );
    assert_eq!(ways.len(), 20 - KNOWN);
    assert!(worst < 2.0, "{ways:?}");
}
