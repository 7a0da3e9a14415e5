//! How often the 95 % intervals of `dpn allan` hold the truth: simulated logs with known coefficients, all five sensors' kinds of noise.
//!
//! `cargo run --release -p dpn-probe --example allan_coverage -- [LOGS] [HOURS]` (100 logs of .5 h at 100 Hz by default). A row a coefficient
//! and setting: truth, mean estimate, logs whose interval holds the truth, logs that show it, logs whose interval lies below and above the truth.

use dpn_core::SampleRate;
use dpn_core::random::Stream;
use dpn_probe::allan::{Coefficient, Planner};
use rayon::prelude::*;

#[path = "../allan/simulate.rs"]
mod simulate;

/// Q, N, B, K, R: a gyroscope like the ADIS16448's, one without instability, one without a walk, white noise alone, all five.
const SETTINGS: [(&str, [f64; 5]); 5] = [
    ("all but a ramp", [5e-6, 1.7e-4, 3.5e-5, 2e-6, 0.0]),
    ("no instability", [0.0, 1.7e-4, 0.0, 5e-6, 0.0]),
    ("no walk", [0.0, 1.7e-4, 5e-5, 0.0, 0.0]),
    ("white noise alone", [0.0, 1.7e-4, 0.0, 0.0, 0.0]),
    ("all five", [5e-6, 1.7e-4, 3.5e-5, 3e-6, 2e-7]),
];

fn main() {
    let mut args = std::env::args().skip(1);
    let mut next = |default: f64| args.next().and_then(|a| a.parse().ok()).unwrap_or(default);
    let (logs, hours) = (next(100.0) as u64, next(0.5));
    let Some(rate) = SampleRate::from_hz(100.0) else {
        return;
    };
    let samples = (hours * 3600.0 * rate.hz()) as usize;
    let planner = Planner::new(samples, rate);
    println!("{logs} logs of {hours} h at {} Hz", rate.hz());
    for (name, truth) in SETTINGS {
        let fits: Vec<_> = (0..logs)
            .into_par_iter()
            .filter_map(|log| {
                let mut rng = Stream::new(log).named("allan-coverage").named(name).rng();
                planner.fit(&simulate::at_rest(&truth.map(|v| v * v), samples, rate, &mut rng)).ok()
            })
            .collect();
        println!("{name}");
        for (k, coefficient) in Coefficient::ALL.into_iter().enumerate() {
            let all = || fits.iter().map(|fit| fit.estimates[k]);
            let held = all().filter(|e| (e.low..=e.high).contains(&truth[k])).count();
            let seen = all().filter(|e| e.seen).count();
            let below = all().filter(|e| e.high < truth[k]).count();
            let above = all().filter(|e| e.low > truth[k]).count();
            let mean = all().map(|e| e.value).sum::<f64>() / fits.len() as f64;
            println!(
                "  {} truth {:.2e}  mean {mean:.2e}  held {held}  seen {seen}  below {below}  above {above}",
                coefficient.letter(),
                truth[k]
            );
        }
    }
}
