//! Simulated tracks against the given ones of the hybrid benchmark: the same numbers, lives and noise, made by other code from other draws.

use super::reprojection::Reprojection;
use dpn_core::Stamp;
use dpn_io::{asl, read_tracks};
use dpn_sim::tracks::{
    CameraPath, CameraSettings, RecordedPath, TracksConfig, World, camera_stamps, simulate_tracks, summarise,
};
use dpn_testing::{pack, packs};

#[test]
fn simulated_tracks_are_like_the_given_ones_in_number_life_and_noise() {
    let Some([euroc, tracks]) = packs(["euroc", "tracks"]) else { return };
    let (config, camera) = (TracksConfig::default(), CameraSettings::default());
    for (name, world) in [("V1_03_difficult", World::Room), ("MH_04_difficult", World::Hall)] {
        let sequence = asl::Sequence::open(&euroc.join(name)).unwrap();
        let stamps: Vec<Stamp> = sequence.camera_frames().unwrap().iter().map(|frame| frame.t).collect();
        let given = read_tracks(&tracks.join(format!("{name}.txt"))).unwrap();
        let path = RecordedPath::new(&sequence.ground_truth().unwrap(), &config.path).unwrap();
        assert_eq!(World::Auto.settled(&path.bounds()), world);
        let ours = simulate_tracks(&config, &path, &stamps, 1).unwrap();

        let given_stamps: Vec<Stamp> = given.iter().map(|frame| frame.t).collect();
        let our_stamps: Vec<Stamp> = ours.iter().map(|frame| frame.t).collect();
        assert_eq!(our_stamps, given_stamps, "{name}");
        let (a, b) = (summarise(&given), summarise(&ours));
        // Another world and other draws: lives differ by the walls' texture, a few percent.
        assert!((b.mean_in_frame / a.mean_in_frame - 1.0).abs() < 0.02, "{name}: {a:?} {b:?}");
        assert!((b.mean_life / a.mean_life - 1.0).abs() < 0.06, "{name}: {a:?} {b:?}");
        let fit = |frames| Reprojection::of(frames, &path, &camera, 8).unwrap().unwrap();
        let (a, b) = (fit(&given), fit(&ours));
        assert!((b.sigma_px / a.sigma_px - 1.0).abs() < 0.02, "{name}: {a:?} {b:?}");
        assert!((b.outlier_share - a.outlier_share).abs() < 0.01, "{name}: {a:?} {b:?}");
    }
}

#[test]
fn the_gaps_of_a_motion_capture_have_no_frames() {
    let Some(tumvi) = pack("tumvi") else { return };
    let dir = tumvi.join("dataset-room2_512_16");
    let truth = asl::Sequence::open(&dir).unwrap().ground_truth().unwrap();
    let config = TracksConfig::default();
    let path = RecordedPath::new(&truth, &config.path).unwrap();
    let gaps = truth.states().windows(2).filter(|pair| pair[1].t.seconds_since(pair[0].t) > 0.1).count();
    // Three stretches between gaps hold fewer poses than a spline needs.
    assert_eq!((gaps, path.pieces().len()), (16, 14));
    let stamps = camera_stamps(&path, dpn_core::SampleRate::from_hz(20.0).unwrap());
    let frames = simulate_tracks(&config, &path, &stamps, 1).unwrap();
    let mut inside = 0;
    for pair in truth.states().windows(2) {
        let lost = pair[1].t.seconds_since(pair[0].t) > 0.1;
        inside += frames.iter().filter(|frame| lost && pair[0].t < frame.t && frame.t < pair[1].t).count();
    }
    assert_eq!(inside, 0);
    // Smoothed over .1 s the motion capture is moved by its own jitter and no more.
    let moved = truth.states().iter().filter_map(|state| {
        let pose = path.world_from_body(state.t)?;
        Some((pose.translation.vector - state.world_from_body.translation.vector).norm())
    });
    let worst = moved.fold(0.0, f64::max);
    assert!(worst < 0.02, "{worst} m");
}
