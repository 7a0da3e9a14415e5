//! Tracks through a lens that is not as it was calibrated: learned, and the path is better for it; one that is as calibrated is left as it is.

use crate::flown::{Case, apart, make, run};
use dpn_core::TrackFrame;
use dpn_sim::Flight;
use dpn_vio::EstimatorConfig;
use dpn_vio::estimator::{FedTracks, RunReport, Update};
use nalgebra::Vector2;

/// A field of waves some hundreds of pixels long, `size` px an axis and rms.
fn field(px: &Vector2<f64>, size: f64) -> Vector2<f64> {
    let wave = |x: f64, y: f64, phase: f64| (px.x / x + px.y / y + phase).sin();
    size * Vector2::new(
        wave(70.0, 90.0, 0.3) + wave(-110.0, 60.0, 1.0),
        wave(95.0, -65.0, 2.0) + wave(60.0, 140.0, 4.0),
    )
}

/// Over tracks that are `size` off.
fn runs(case: &Case, size: f64, learn: bool) -> (Vec<Update>, RunReport) {
    let mut config = EstimatorConfig { fed_tracks: FedTracks::Followed, ..EstimatorConfig::default() };
    config.lens.learn = learn;
    let seen = |frame: &mut TrackFrame| frame.tracks.iter_mut().for_each(|t| t.px += field(&t.px, size));
    run(case, config, 1.0, |_| (), seen)
}

#[test]
fn a_lens_that_is_off_is_learned_and_one_that_is_not_left_alone() {
    let case = make(Flight::RoomMedium, 3, 0.0, 60.0);
    let (exact, report) = runs(&case, 0.0, false);
    assert_eq!(report.lens_px, None);
    let (off, _) = runs(&case, 0.4, false);
    let (learned, report) = runs(&case, 0.4, true);
    let (before, after) = (apart(&off, &exact), apart(&learned, &exact));
    let px = report.lens_px.unwrap();
    println!("{before:.4} m apart, {after:.4} m once the lens is learned as {px:.2} px off");
    assert!(after < 0.6 * before, "{before} m, {after} m");
    assert!((0.4..0.8).contains(&px), "{px} px");
    let (as_calibrated, report) = runs(&case, 0.0, true);
    let px = report.lens_px.unwrap();
    println!(
        "{:.4} m apart where the lens is as calibrated, learned as {px:.2} px off",
        apart(&as_calibrated, &exact)
    );
    assert!(px < 0.3 && apart(&as_calibrated, &exact) < 0.5 * before, "{px} px");
}
