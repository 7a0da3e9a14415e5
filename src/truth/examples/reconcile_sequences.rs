//! Reconciles sequences in release: `cargo run --release --example reconcile_sequences -p dpn-truth -- OUT HOLD_OUT_KEYS KEY_INTERVAL DIR...`.
//! Each becomes a folder of its own beside links to the rest of the sequence.

use dpn_io::asl::{Sequence, write_ground_truth};
use dpn_truth::{TruthConfig, reconcile};
use std::path::Path;

fn main() {
    let mut args = std::env::args().skip(1);
    let out = args.next().unwrap();
    let hold_out = args.next().unwrap().parse().unwrap();
    let config = TruthConfig {
        hold_out,
        key_interval_s: args.next().unwrap().parse().unwrap(),
        ..TruthConfig::default()
    };
    for dir in args {
        let sequence = Sequence::open(Path::new(&dir)).unwrap();
        let begin = std::time::Instant::now();
        let done = match reconcile(&sequence.imu().unwrap(), &sequence.ground_truth().unwrap(), &config) {
            Ok(done) => done,
            Err(error) => {
                println!("{} {error}", sequence.name());
                continue;
            }
        };
        let (r, l) = (&done.report, &done.report.levels);
        println!(
            "{} err {:.2} mm {:.3} deg; held {:?}; delay {:.3}+-{:.3} ms; mount {:.2?} deg lever {:.1?}+-{:.1?} mm tilt {:.3} blur {:.1}; acc {:.3} gyr {:.4} walks {:.1e} {:.1e} pos {:.3} rot {:.4} slow {:.2} {:.3} ({:.2} {:.2} s); used {} of {}; hold {:?}; spans {}; {} its {} in {:.0} s",
            sequence.name(),
            r.published_position_error_mm,
            r.published_rotation_error_deg,
            r.held,
            r.delay_ms.value,
            r.delay_ms.std,
            r.mount_deg.value,
            r.lever_mm.value,
            r.lever_mm.std,
            r.tilt_deg.value,
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
            r.used,
            r.poses,
            r.held_out,
            r.spans.len(),
            r.iterations,
            r.settled,
            begin.elapsed().as_secs_f64()
        );
        for warning in &r.warnings {
            println!("    {warning}");
        }
        let to = Path::new(&out).join(sequence.name());
        write_ground_truth(&to.join("truth.csv"), &done.truth).unwrap();
        std::fs::write(to.join("truth.json"), serde_json::to_string_pretty(r).unwrap()).unwrap();
    }
}
