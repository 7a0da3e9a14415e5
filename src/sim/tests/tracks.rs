//! Camera tracks from outside: geometry, the laws of the tracker's errors, what one figure moves and what it does not.

use super::reprojection::Reprojection;
use dpn_core::{Stamp, TrackFrame};
use dpn_sim::tracks::{
    AnalyticPath, Bounds, CameraPath, CameraSettings, TracksConfig, TracksError, camera_stamps,
    simulate_tracks, summarise,
};
use dpn_sim::{Flight, FlightConfig, simulate};
use nalgebra::{Isometry3, Vector2, Vector3};
use std::collections::{BTreeMap, BTreeSet};

const CAMERA_HZ: f64 = 20.0;

fn flight_path(flight: Flight) -> AnalyticPath {
    AnalyticPath::of(&simulate(flight, 1, &FlightConfig::ideal()).unwrap())
}

fn stamps(path: &dyn CameraPath) -> Vec<Stamp> {
    camera_stamps(path, dpn_core::SampleRate::from_hz(CAMERA_HZ).unwrap())
}

fn tracks(config: &TracksConfig, path: &dyn CameraPath, seed: u64) -> Vec<TrackFrame> {
    simulate_tracks(config, path, &stamps(path), seed).unwrap()
}

/// A body that stands still for some stretches \[ms\] and is not known between.
struct Still(Vec<(i64, i64)>);

impl Still {
    fn at(ms: i64) -> Stamp {
        Stamp::from_ns(ms * 1_000_000)
    }
}

impl CameraPath for Still {
    fn world_from_body(&self, t: Stamp) -> Option<Isometry3<f64>> {
        let known = self.pieces().iter().any(|(from, to)| (*from..=*to).contains(&t));
        known.then(|| Isometry3::new(Vector3::new(1.0, 2.0, 1.0), Vector3::new(0.0, 1.3, 0.4)))
    }

    fn pieces(&self) -> Vec<(Stamp, Stamp)> {
        self.0.iter().map(|(from, to)| (Self::at(*from), Self::at(*to))).collect()
    }

    fn bounds(&self) -> Bounds {
        Bounds { low: Vector3::zeros(), high: Vector3::new(4.0, 4.0, 2.0) }
    }
}

/// Positions of every track, by id: place in the list of frames, pixel.
fn by_id(frames: &[TrackFrame]) -> BTreeMap<u64, Vec<(usize, Vector2<f64>)>> {
    let mut found: BTreeMap<u64, Vec<_>> = BTreeMap::new();
    for (place, frame) in frames.iter().enumerate() {
        for track in &frame.tracks {
            found.entry(track.id).or_default().push((place, track.px));
        }
    }
    found
}

#[test]
fn the_same_seed_gives_the_same_tracks_and_another_others() {
    let path = flight_path(Flight::RoomWild);
    let config = TracksConfig::default();
    let first = tracks(&config, &path, 1);
    assert_eq!(first, tracks(&config, &path, 1));
    assert_ne!(first, tracks(&config, &path, 2));
}

#[test]
fn an_ideal_trackers_pixels_are_projections_of_fixed_points() {
    let path = flight_path(Flight::RoomAggressive);
    let frames = tracks(&TracksConfig::ideal(), &path, 3);
    let found = Reprojection::of(&frames, &path, &CameraSettings::default(), 6).unwrap().unwrap();
    // Rounding to hundredths is all that is left: .01 / sqrt(12) = .0029 px, a little off a Gaussian's median.
    assert!(found.tracks > 500 && found.sigma_px < 0.0045, "{found:?}");
    assert!(found.outlier_share < 0.01, "{found:?}");
}

#[test]
fn the_white_noise_has_the_deviation_asked_for() {
    let path = flight_path(Flight::RoomMedium);
    for sigma in [0.5, 2.0] {
        let config = TracksConfig { pixel_noise_px: sigma, ..TracksConfig::ideal() };
        let found = Reprojection::of(&tracks(&config, &path, 3), &path, &CameraSettings::default(), 8)
            .unwrap()
            .unwrap();
        // Over 1e4 positions: the median's own deviation is about 1 % of sigma.
        assert!((found.sigma_px / sigma - 1.0).abs() < 0.03, "{sigma}: {found:?}");
    }
}

#[test]
fn tracks_are_spaced_at_birth_never_too_many_inside_the_image_and_ids_are_used_once() {
    let path = flight_path(Flight::HallLoops);
    let config = TracksConfig { max_tracks: 80, spacing_px: 45.0, ..TracksConfig::ideal() };
    let frames = tracks(&config, &path, 1);
    let mut known = BTreeSet::new();
    let mut lost = BTreeSet::new();
    for frame in &frames {
        assert!(frame.tracks.len() <= 80);
        let here: BTreeSet<u64> = frame.tracks.iter().map(|track| track.id).collect();
        assert_eq!(here.len(), frame.tracks.len());
        assert!(here.is_disjoint(&lost), "an id came back");
        for track in &frame.tracks {
            assert!(
                (10.0..=741.0).contains(&track.px.x) && (10.0..=469.0).contains(&track.px.y),
                "{track:?}"
            );
            if known.insert(track.id) {
                let others = frame.tracks.iter().filter(|other| other.id != track.id);
                // Pixels are rounded to hundredths.
                let nearest = others.map(|other| (other.px - track.px).norm()).fold(f64::INFINITY, f64::min);
                assert!(nearest >= 45.0 - 0.02, "{nearest}");
            }
        }
        lost.extend(known.difference(&here).copied());
    }
    assert!(known.len() > 300, "{}", known.len());
}

#[test]
fn lives_are_exponential_with_the_mean_asked_for() {
    // Nothing moves, so that tracks end at random alone.
    let path = Still(vec![(0, 400_000)]);
    for life_time_s in [2.5, 0.5] {
        let config = TracksConfig { life_time_s, rate_hz: 20.0, ..TracksConfig::ideal() };
        let frames = tracks(&config, &path, 1);
        let lives: Vec<usize> = by_id(&frames)
            .values()
            .filter(|track| track[track.len() - 1].0 + 1 < frames.len())
            .map(Vec::len)
            .collect();
        let mean = lives.iter().sum::<usize>() as f64 / lives.len() as f64;
        let expected = life_time_s * CAMERA_HZ;
        // The deviation of the mean of n geometric lives is its value over sqrt(n).
        let off = 4.0 * expected / (lives.len() as f64).sqrt();
        assert!((mean - expected).abs() < off, "{mean} {expected} of {}", lives.len());
        // A geometric law has the share (1 - p)^k beyond k frames.
        let beyond =
            lives.iter().filter(|life| **life > expected as usize).count() as f64 / lives.len() as f64;
        let law = (1.0 - 1.0 / expected).powi(expected as i32);
        assert!((beyond - law).abs() < 2.0 / (lives.len() as f64).sqrt(), "{beyond} {law}");
    }
}

#[test]
fn the_drift_adds_up_as_a_random_walk() {
    let path = Still(vec![(0, 100_000)]);
    let config = TracksConfig { drift_px: 0.2, life_time_s: 1e6, rate_hz: 20.0, ..TracksConfig::ideal() };
    let tracks = by_id(&tracks(&config, &path, 1));
    for steps in [1, 25, 400] {
        let (mut sum, mut n) = (0.0, 0.0);
        for positions in tracks.values() {
            for pair in positions.chunks_exact(steps + 1) {
                sum += (pair[steps].1 - pair[0].1).norm_squared() / 2.0;
                n += 1.0;
            }
        }
        let found: f64 = sum / n;
        let expected = 0.04 * steps as f64;
        // Each of the n differences has two axes: the deviation of the variance is its value over sqrt(n).
        assert!(
            (found / expected - 1.0).abs() < 4.0 / f64::sqrt(n) + 0.002,
            "{steps}: {found} {expected} of {n}"
        );
    }
}

#[test]
fn outliers_are_as_many_as_asked_for_slide_straight_and_end_soon() {
    let path = Still(vec![(0, 400_000)]);
    let config = TracksConfig { outlier_share: 0.003, rate_hz: 20.0, ..TracksConfig::ideal() };
    let frames = tracks(&config, &path, 1);
    let (mut good, mut turned, mut slides) = (0.0, 0.0, 0.0);
    for positions in by_id(&frames).values() {
        let steps: Vec<Vector2<f64>> = positions.windows(2).map(|pair| pair[1].1 - pair[0].1).collect();
        let still = steps.iter().take_while(|step| step.norm() == 0.0).count();
        good += still as f64;
        let sliding = &steps[still..];
        if let Some(first) = sliding.first() {
            turned += 1.0;
            slides += sliding.len() as f64;
            assert!((first.norm() - 2.5).abs() < 0.02, "{first}");
            assert!(sliding.iter().all(|step| (step - first).norm() < 0.03), "{sliding:?}");
        }
    }
    let share = turned / (good + turned);
    assert!((share / 0.003 - 1.0).abs() < 4.0 / f64::sqrt(turned), "{share}");
    // An outlier ends with .3 a frame, or as any other track with .02.
    let (mean, expected) = (slides / turned, 1.0 / (1.0 - 0.7 * 0.98));
    assert!((mean / expected - 1.0).abs() < 4.0 / f64::sqrt(turned), "{mean} {expected}");
}

#[test]
fn another_level_of_noise_moves_no_other_draw() {
    let path = flight_path(Flight::RoomSlow);
    let ids = |frames: &[TrackFrame]| -> Vec<Vec<u64>> {
        frames.iter().map(|frame| frame.tracks.iter().map(|track| track.id).collect()).collect()
    };
    let plain = tracks(&TracksConfig { outlier_share: 0.0, ..TracksConfig::default() }, &path, 5);
    let loud = tracks(
        &TracksConfig { outlier_share: 0.0, pixel_noise_px: 1.5, ..TracksConfig::default() },
        &path,
        5,
    );
    let still = tracks(
        &TracksConfig { outlier_share: 0.0, pixel_noise_px: 0.0, ..TracksConfig::default() },
        &path,
        5,
    );
    assert_eq!(ids(&plain), ids(&loud));
    // Three times the noise is three times the same noise.
    for ((plain, loud), still) in plain.iter().zip(&loud).zip(&still) {
        for ((plain, loud), still) in plain.tracks.iter().zip(&loud.tracks).zip(&still.tracks) {
            assert!(((loud.px - still.px) - 3.0 * (plain.px - still.px)).amax() < 0.041);
        }
    }
}

#[test]
fn a_delay_moves_pixels_by_the_motion_in_it_and_leaves_the_draws() {
    let path = flight_path(Flight::RoomWild);
    let at = |ground_truth_delay_s: f64| {
        tracks(&TracksConfig { ground_truth_delay_s, ..TracksConfig::default() }, &path, 5)
    };
    let (plain, late) = (at(0.0), at(0.002));
    // The last frame's pose would lie beyond the path.
    assert!(plain.len() - late.len() <= 1);
    let camera = CameraSettings::default();
    let sigma =
        |frames: &[TrackFrame]| Reprojection::of(frames, &path, &camera, 6).unwrap().unwrap().sigma_px;
    let (exact, off) = (sigma(&plain), sigma(&late));
    assert!(off > exact * 1.05, "{exact} {off}");
    let shared = plain.iter().zip(&late).map(|(a, b)| {
        let b: BTreeMap<u64, Vector2<f64>> = b.tracks.iter().map(|track| (track.id, track.px)).collect();
        a.tracks
            .iter()
            .filter(|track| b.get(&track.id).is_some_and(|px| (px - track.px).norm() < 8.0))
            .count()
    });
    // Ids drift apart once a point leaves a frame earlier, so the first ten seconds, in which it stands, are compared.
    let first: usize = shared.take(30).sum();
    let all: usize = plain.iter().take(30).map(|frame| frame.tracks.len()).sum();
    assert_eq!(first, all);
}

#[test]
fn no_frame_is_made_in_a_gap_and_no_track_survives_it() {
    let path = Still(vec![(0, 4_000), (4_300, 8_000)]);
    let every: Vec<Stamp> = (0..200).map(|i| Still::at(50 * i)).collect();
    let config = TracksConfig { rate_hz: 20.0, ..TracksConfig::default() };
    let frames = simulate_tracks(&config, &path, &every, 1).unwrap();
    assert!(frames.iter().all(|frame| path.world_from_body(frame.t).is_some()));
    assert_eq!(frames.len(), 81 + 75);
    let (before, after) = frames.split_at(81);
    let ids = |frames: &[TrackFrame]| by_id(frames).into_keys().collect::<BTreeSet<_>>();
    assert!(ids(before).is_disjoint(&ids(after)));
    // The camera's own gaps: short ones are bridged, long ones are not.
    for (lost, survives) in [(9, true), (11, false)] {
        let stamps: Vec<Stamp> = (0..40).chain(40 + lost - 1..70).map(|i| Still::at(50 * i)).collect();
        let frames = simulate_tracks(&config, &Still(vec![(0, 4_000)]), &stamps, 1).unwrap();
        let (before, after) = frames.split_at(40);
        assert_eq!(!ids(before).is_disjoint(&ids(after)), survives, "{lost} frames");
    }
}

#[test]
fn frames_are_handed_over_at_the_rate_asked_for() {
    let path = Still(vec![(0, 10_000)]);
    for (rate_hz, frames) in [(20.0, 201), (10.0, 101), (5.0, 51), (100.0, 201), (6.0, 67)] {
        let found = tracks(&TracksConfig { rate_hz, ..TracksConfig::default() }, &path, 1);
        assert_eq!(found.len(), frames, "{rate_hz} Hz");
    }
    assert_eq!(summarise(&tracks(&TracksConfig::default(), &path, 1)).least_in_frame, 150);
}

#[test]
fn what_cannot_be_simulated_is_said_with_its_values() {
    let path = Still(vec![(0, 1_000)]);
    let error = |config: &TracksConfig, stamps: &[Stamp]| {
        simulate_tracks(config, &path, stamps, 1).unwrap_err().to_string()
    };
    let plain = TracksConfig::default();
    assert_eq!(simulate_tracks(&plain, &path, &[], 1), Err(TracksError::NoFrame));
    let at = Still::at;
    assert_eq!(
        error(&plain, &[at(1), at(2), at(2)]),
        "the camera's stamps go from 2000000 to 2000000 at frame 2; they must increase"
    );
    assert_eq!(
        error(&plain, &[at(2_000), at(3_000)]),
        "none of the 2 camera frames, 2000000000 to 3000000000 ns, lies on the path, 0 to 1000000000 ns: are both on one clock?"
    );
    let bad = TracksConfig { rate_hz: -1.0, drift_px: f64::NAN, ..plain };
    assert_eq!(
        error(&bad, &[at(0)]),
        "`rate_hz` is -1, but must be above 0 and at most 1000; `drift_px` is NaN, but must be 0 to 100"
    );
}
