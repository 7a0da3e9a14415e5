//! Timings of the kernels that matter.
//!
//! `cargo bench -p dpn-bench --bench NAME [-- ITERATIONS]`; every bench prints medians of wall time and mean CPU time. With `--test`, as `cargo test --benches`
//! passes it, one short iteration is run, so that benches cannot rot. Where `DPN_BENCH_OUT` names a file, [`keep`] puts medians there; what the book quotes is
//! `docs/results/benches.json`.

pub mod frames;

use dpn_core::signal::stats::upper_median;
use std::collections::BTreeMap;
use std::time::Instant;

/// How often to run: from the command line, or once where the bench runs as a test.
pub fn iterations(default: usize) -> usize {
    let mut args = std::env::args().skip(1).filter(|a| a != "--bench");
    match args.next() {
        Some(arg) if arg == "--test" => 1,
        Some(arg) => arg.parse().unwrap_or(default),
        // `cargo test --benches` passes nothing; its build has debug assertions.
        None if cfg!(debug_assertions) => 1,
        None => default,
    }
}

/// What the environment's variable `name` lists, split at its commas; none where it is not set.
pub fn asked(name: &str) -> Option<Vec<String>> {
    let list = std::env::var(name).ok()?;
    Some(list.split(',').map(str::to_owned).collect())
}

/// CPU time this process has used \[s\]; none where the system does not say (it says so in hundredths on Linux).
pub fn cpu_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
    let ticks = fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?;
    Some(ticks / 100.0)
}

/// What [`time`] measured.
#[derive(Debug, Clone, Copy)]
pub struct Timing {
    /// Median wall time of one iteration \[ms\].
    pub wall_ms: f64,
    /// Mean CPU time of one iteration, all threads \[ms\]; NaN where the system does not say.
    pub cpu_ms: f64,
}

/// Runs `work` `iterations` times after a tenth as many that do not count.
pub fn time(iterations: usize, mut work: impl FnMut()) -> Timing {
    for _ in 0..iterations / 10 {
        work();
    }
    let cpu = cpu_seconds();
    let walls: Vec<f64> = (0..iterations.max(1))
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    let used = cpu.zip(cpu_seconds()).map_or(f64::NAN, |(from, to)| to - from);
    let cpu_ms = used * 1e3 / walls.len() as f64;
    Timing { wall_ms: upper_median(walls).expect("one iteration at least"), cpu_ms }
}

/// Keeps a median time \[ms\] under its name in the file that `DPN_BENCH_OUT` names, beside what other benches left there.
///
/// # Panics
/// A file that does not read as such a list, or cannot be written.
pub fn keep(name: &str, median_ms: f64) {
    let Some(path) = std::env::var_os("DPN_BENCH_OUT") else { return };
    let mut kept: BTreeMap<String, BTreeMap<String, f64>> = match std::fs::read(&path) {
        Ok(bytes) => serde_json::from_slice(&bytes).expect("DPN_BENCH_OUT is a list of medians"),
        Err(_) => BTreeMap::new(),
    };
    kept.insert(name.to_owned(), BTreeMap::from([("median_ms".to_owned(), median_ms)]));
    let text = serde_json::to_string_pretty(&kept).expect("names and numbers are JSON") + "\n";
    std::fs::write(&path, text).expect("DPN_BENCH_OUT can be written");
}
