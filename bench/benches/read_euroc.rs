//! Reads the eleven EuRoC IMU files (274,241 rows), one thread; without the data, the excerpt in `tests/data` as a smoke test.

use dpn_io::asl::{Sequence, discover};
use std::path::{Path, PathBuf};
use std::time::Instant;

const RUNS: usize = 7;

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let data = std::env::var_os("DPN_DATA").map_or_else(|| root.join("data"), PathBuf::from);
    let sequences = discover(&data.join("euroc")).or_else(|_| {
        eprintln!("skipped: no data; the excerpt is read instead");
        discover(&root.join("tests/data/euroc"))
    });
    let sequences = match sequences {
        Ok(sequences) => sequences,
        Err(error) => {
            eprintln!("error: {error}");
            std::process::exit(2);
        }
    };
    let mut rows = 0;
    let mut seconds: Vec<f64> = (0..RUNS)
        .map(|_| {
            let start = Instant::now();
            rows = read(&sequences);
            start.elapsed().as_secs_f64()
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    println!(
        "read_euroc: {} files, {rows} rows, median of {RUNS}: {:.1} ms (fastest {:.1}, slowest {:.1}), 1 thread",
        sequences.len(),
        seconds[RUNS / 2] * 1e3,
        seconds[0] * 1e3,
        seconds[RUNS - 1] * 1e3,
    );
}

fn read(sequences: &[Sequence]) -> usize {
    let lengths = sequences.iter().map(|sequence| match sequence.imu() {
        Ok(imu) => imu.len(),
        Err(error) => {
            eprintln!("error: {error}");
            std::process::exit(2);
        }
    });
    lengths.sum()
}
