//! How well degraded ground truth of simulated flights comes back: `cargo run --example degraded_flights -p dpn-truth -- [FLIGHT] [VIBRATION]`.
#![allow(clippy::unwrap_used)]

#[path = "../tests/degrade.rs"]
mod degrade;

use degrade::{Degradation, against};
use dpn_sim::{Flight, FlightConfig, simulate};
use dpn_truth::{TruthConfig, reconcile};

fn main() {
    let mut args = std::env::args().skip(1);
    let flight: Flight = args.next().map_or(Flight::RoomMedium, |name| name.parse().unwrap());
    let mut config = FlightConfig::default();
    config.vibration.scale = args.next().map_or(1.0, |scale| scale.parse().unwrap());
    let only = args.next().filter(|only| only != "each");
    let mut settings =
        TruthConfig { position_limit_m: 0.1, rotation_limit_deg: 2.0, ..TruthConfig::default() };
    if let Some(interval) = args.next() {
        settings.key_interval_s = interval.parse().unwrap();
    }
    let flown = simulate(flight, 5, &config).unwrap();
    for (name, degradation) in Degradation::all() {
        if only.as_ref().is_some_and(|only| only != name) {
            continue;
        }
        let published = degradation.of(&flown, 1);
        let begin = std::time::Instant::now();
        match reconcile(&flown.recording, &published, &settings) {
            Ok(done) => {
                let before = against(&published, &flown);
                let (m, deg, share) = against(&done.truth, &flown);
                let r = &done.report;
                let l = &r.levels;
                println!(
                    "{flight} {name:9} {:6.2} mm {:.3} deg -> {:5.2} mm, held {:?}, {deg:.4} deg over {share:.3}; delay {:.3}+-{:.3} ms; blur {:.1}; acc {:.3} gyr {:.4} walks {:.1e} {:.1e} pos {:.2} rot {:.3} slow {:.2} {:.3} ({:.2} {:.2} s); {} its {} in {:.0} s",
                    1e3 * before.0,
                    before.1,
                    1e3 * m,
                    r.held,
                    r.delay_ms.value,
                    r.delay_ms.std,
                    r.blur_ms,
                    l.accel_sample_std,
                    l.gyro_sample_std,
                    l.accel_bias_walk,
                    l.gyro_bias_walk,
                    1e3 * l.position_std,
                    l.rotation_std.to_degrees(),
                    1e3 * l.slow_position_std,
                    l.slow_rotation_std.to_degrees(),
                    l.slow_position_s,
                    l.slow_rotation_s,
                    r.iterations,
                    r.settled,
                    begin.elapsed().as_secs_f64()
                );
                for warning in &r.warnings {
                    println!("    {warning}");
                }
            }
            Err(error) => println!("{flight} {name}: {error}"),
        }
    }
}
