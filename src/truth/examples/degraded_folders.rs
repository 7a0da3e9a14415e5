//! Writes simulated flights with exact and with degraded ground truth as ASL folders, so that the ranking of constants can be held against
//! that along the exact one: `cargo run --release --example degraded_folders -p dpn-truth -- OUT DEGRADATION...`.
//!
//! ```sh
//! dpn truth OUT/all --out OUT/reconciled
//! dpn eval --closed-loop --data OUT/exact --from 0 --noise x0.5,x1,x2,x4,x8
//! dpn eval --closed-loop --data OUT/all --truth OUT/reconciled --from 0 --noise x0.5,x1,x2,x4,x8
//! ```
#![allow(clippy::unwrap_used)]

#[path = "../tests/degrade.rs"]
#[allow(dead_code, reason = "`against` is the test's")]
mod degrade;

use degrade::Degradation;
use dpn_io::asl::{SequenceParts, write_sequence};
use dpn_sim::{Flight, FlightConfig, simulate};
use std::path::PathBuf;

/// Of the flights and their noise, and of what degrades their truth.
const SEED: u64 = 5;

fn main() {
    let mut args = std::env::args().skip(1);
    let out = PathBuf::from(args.next().expect("usage: degraded_folders OUT DEGRADATION..."));
    let wanted: Vec<String> = args.collect();
    // Without vibration: a simulated one is ten times a real one's at low frequencies, which no reconciliation tells from motion.
    let mut config = FlightConfig::default();
    config.vibration.scale = 0.0;
    for flight in Flight::ALL {
        let flown = simulate(flight, SEED, &config).unwrap();
        let exact = [("exact", Degradation::NONE)];
        let degraded = Degradation::all().into_iter().filter(|(name, _)| wanted.iter().any(|w| w == name));
        for (name, degradation) in exact.into_iter().chain(degraded) {
            let truth = degradation.of(&flown, 1);
            let parts = SequenceParts { imu: &flown.recording, imu_config: None, ground_truth: Some(&truth) };
            write_sequence(&out.join(name).join(flight.name()), &parts).unwrap();
        }
    }
}
