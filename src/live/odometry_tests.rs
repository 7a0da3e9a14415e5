//! The odometry that other programs hold, fed a flight as it comes, and with what must not come.

use crate::{LiveError, Odometry, OdometryConfig, pass_over_spikes, settings_for};
use dpn_core::{GrayImage, ImuNoise, ImuSample, NoiseModel, SampleRate, Stamp, TrackFrame};
use dpn_sim::tracks::{AnalyticPath, camera_stamps};
use dpn_sim::{Flight, FlightConfig, TracksConfig, path, simulate, simulate_tracks};
use dpn_vio::estimator::Update;
use dpn_vio::preint::NoisySample;
use dpn_vio::{Estimator, EstimatorConfig};
use nalgebra::Vector2;

const CAMERA: &str = r#"
[calibration]
resolution = [752, 480]
rate_hz = 20
camera_model = "pinhole"
intrinsics = [458.654, 457.296, 367.215, 248.375]
distortion_model = "radial-tangential"
distortion_coefficients = [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]
T_BS = { rows = 4, cols = 4, data = [0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975, 0.999557249008, 0.0149672133247, 0.025715529948, -0.064676986768, -0.0257744366974, 0.00375618835797, 0.999660727178, 0.00981073058949, 0.0, 0.0, 0.0, 1.0] }
"#;

fn odometry(settings: &str) -> Result<Odometry, LiveError> {
    Odometry::new(&OdometryConfig::parse(&format!("{settings}\n{CAMERA}"))?, Vec::new())
}

/// Some seconds in the middle of a flight, with tracks of EuRoC's camera.
fn flight(from_s: f64, to_s: f64) -> (Vec<ImuSample>, Vec<TrackFrame>) {
    let config = FlightConfig::default();
    let flown = simulate(Flight::RoomMedium, 1, &config).unwrap().recording;
    let epoch = Stamp::from_ns(config.epoch_ns);
    let path = AnalyticPath::new(path(Flight::RoomMedium, 1, &config).unwrap(), epoch);
    let stamps = camera_stamps(&path, SampleRate::from_hz(20.0).unwrap());
    let inside = |t: Stamp| (from_s..to_s).contains(&t.seconds_since(epoch));
    let frames = simulate_tracks(&TracksConfig::default(), &path, &stamps, 1).unwrap();
    let samples = flown.samples().iter().filter(|sample| inside(sample.t)).copied().collect();
    (samples, frames.into_iter().filter(|frame| inside(frame.t)).collect())
}

fn points(frame: &TrackFrame) -> Vec<(u64, [f64; 2])> {
    frame.tracks.iter().map(|track| (track.id, track.px.into())).collect()
}

/// As far as results go: what it took is another matter.
fn bits(updates: &[Update]) -> Vec<(Stamp, String)> {
    updates.iter().map(|u| (u.t, format!("{:?} {:?} {:?}", u.state, u.covariance, u.levels))).collect()
}

#[test]
fn a_flight_as_it_comes_gives_what_it_gives_as_a_recording() {
    let (samples, frames) = flight(20.0, 32.0);
    let mut live = odometry("camera = \"tracks\"\nnoise = \"self\"\nestimator.covariance = true").unwrap();
    let (mut updates, mut next, mut waited) = (Vec::new(), frames.iter().peekable(), Vec::new());
    // Frames come 30 ms late.
    for sample in &samples {
        live.feed_sample(*sample).unwrap();
        waited.extend(live.waiting());
        while let Some(frame) = next.next_if(|frame| sample.t.seconds_since(frame.t) > 0.03) {
            live.feed_tracks(frame.t, points(frame), false).unwrap();
            updates.extend(std::iter::from_fn(|| live.next_update()));
        }
    }
    assert_eq!(live.waiting(), None);
    waited.dedup();
    assert_eq!(waited[0], "no frame of tracks has come");
    assert!(waited.iter().any(|words| words.starts_with("initialising: ")), "{waited:?}");

    let config = settings_for(
        &EstimatorConfig { covariance: true, ..EstimatorConfig::default() },
        &"self".parse().unwrap(),
    );
    let mounted = live.calibration.camera.body_from_cam;
    let mut recorded = Estimator::new(config, live.camera, mounted, 0).unwrap();
    let mut told = dpn_noise::live(&"self".parse().unwrap(), "", SampleRate::HZ_200, &[]).unwrap();
    for sample in samples {
        let noise = told.feed(&sample);
        pass_over_spikes(recorded.feed_imu(NoisySample { sample, noise })).unwrap();
    }
    frames.iter().for_each(|frame| recorded.feed_frame(frame.clone()).unwrap());
    let expected: Vec<Update> = std::iter::from_fn(|| recorded.next_update()).collect();
    // The last frame's samples had come, the frame had not.
    assert_eq!(bits(&updates), bits(&expected[..updates.len()]));
    let poses = updates.iter().filter(|update| update.state.is_some()).count();
    assert!(expected.len() - updates.len() < 2 && poses > 60, "{poses} of {}", updates.len());

    let (found, levels) = (live.noise().unwrap(), updates.last().unwrap().levels.as_deref().unwrap());
    assert_eq!(found.sample, levels.inertial.applied_to(&ImuNoise::baseline()).unwrap());
    assert!((found.rate.hz() - 200.0).abs() < 0.1 && found.unsure == Some(levels.unsure));
}

#[test]
fn normalised_points_are_the_pixels_that_the_lens_makes_of_them() {
    let (samples, frames) = flight(20.0, 24.0);
    let run = |normalised: bool| {
        let mut live = odometry("camera = \"tracks\"\nnoise = \"x4\"").unwrap();
        for sample in &samples {
            live.feed_sample(*sample).unwrap();
        }
        for frame in &frames {
            let mut all = points(frame);
            if normalised {
                all.iter_mut().for_each(|(_, at)| {
                    *at = live.camera.normalise(&Vector2::from(*at)).unwrap().into();
                });
            }
            live.feed_tracks(frame.t, all, normalised).unwrap();
        }
        std::iter::from_fn(|| live.next_update()).filter_map(|u| u.state).last().expect("4 s are enough")
    };
    let [px, normalised] = [false, true].map(|kind| run(kind).world_from_body.translation.vector);
    assert!((px - normalised).norm() < 1e-4, "{px} {normalised}");
}

#[test]
fn what_cannot_be_taken_is_named_and_changes_nothing() {
    let (samples, frames) = flight(20.0, 22.0);
    let mut live = odometry("camera = \"tracks\"").unwrap();
    let said = |fed: Result<(), LiveError>| fed.unwrap_err().to_string();
    assert_eq!(live.waiting().unwrap(), "no IMU sample has come");
    live.feed_sample(samples[0]).unwrap();
    let nan = ImuSample { gyro: [f64::NAN; 3], ..samples[1] };
    assert!(said(live.feed_sample(nan)).contains("not finite"));
    assert!(said(live.feed_sample(samples[0])).contains("increasing time"));
    let t = frames[0].t;
    assert_eq!(
        said(live.feed_tracks(t, [(7, [1.0; 2]), (7, [2.0; 2])], false)),
        format!("id 7 twice in the frame at {t}; expected each point at most once")
    );
    assert!(
        said(live.feed_tracks(t, [(7, [1.0, f64::NAN])], false))
            .ends_with("expected two finite numbers, in pixels")
    );
    assert!(said(live.feed_tracks(t, [(7, [f64::INFINITY; 2])], true)).contains("that the lens can show"));
    live.feed_tracks(t, points(&frames[0]), false).unwrap();
    assert!(said(live.feed_tracks(t, [], false)).contains("frames must come in increasing time"));
    let image = GrayImage::from_fn(752, 480, |x, y| (x * y) as u8).unwrap();
    assert!(said(live.feed_image(t, image.view())).contains("made for tracks"));
    // An IMU that has fallen silent.
    let refused = (1..).find_map(|k| live.feed_tracks(t.plus_seconds(0.1 * f64::from(k)), [], false).err());
    assert!(refused.unwrap().to_string().contains("is the IMU silent"));
    assert!(live.waiting().unwrap().contains("1 IMU samples of 100"), "{:?}", live.waiting());
    samples[1..].iter().for_each(|sample| live.feed_sample(*sample).unwrap());
    assert!(live.waiting().unwrap().starts_with("no IMU sample since"), "{:?}", live.waiting());

    let mut live = odometry("").unwrap();
    samples.iter().for_each(|sample| live.feed_sample(*sample).unwrap());
    let small = GrayImage::from_fn(8, 8, |_, _| 0).unwrap();
    assert!(said(live.feed_image(t, small.view())).contains("8 x 8"));
    assert!(said(live.feed_encoded(t, b"none")).contains("no readable PNG or JPEG"));
    let refused =
        (0..).find_map(|k| live.feed_image(t.plus_seconds(0.01 * f64::from(k)), image.view()).err());
    assert!(refused.unwrap().to_string().ends_with("take the updates between images"));
}

#[test]
fn settings_that_are_none_say_where() {
    for (settings, words) in [
        ("noice = \"x1\"", "settings:1: unknown field `noice`"),
        ("noise = \"x\"", "settings:1: "),
        ("seed = -1", "settings:1: "),
        ("estimator.window.key_frames = 1", "`estimator.window.key_frames` is 1"),
        ("noise = \"oracle\"", ""),
    ] {
        let said = odometry(settings).map(|mut live| {
            let sample = |i| ImuSample {
                t: Stamp::from_ns(5_000_000 * i64::from(i)),
                gyro: [0.0; 3],
                accel: [0.0, 1e-3 * f64::from(i), 9.81],
            };
            // Noise that samples alone do not make is known as such with their rate.
            (0..100)
                .find_map(|i| live.feed_sample(sample(i)).err())
                .expect("no samples make the truth")
                .to_string()
        });
        let said = said.unwrap_or_else(|error| error.to_string());
        assert!(said.contains(words) && !said.is_empty(), "{settings}: {said}");
    }
    let of = |text: &str| Odometry::new(&OdometryConfig::parse(text)?, Vec::new()).map(|_| ());
    assert!(of("").unwrap_err().to_string().contains("missing field `calibration`"));
    assert!(of("calibration = \"none.yaml\"").unwrap_err().to_string().contains("none.yaml"));
    assert!(of("calibration = 3").unwrap_err().to_string().starts_with("calibration"));
}
