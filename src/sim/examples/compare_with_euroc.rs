//! Prints simulated flights and EuRoC's recordings side by side, as the Markdown table of `src/sim/README.md`.
//!
//! `cargo run -p dpn-sim --release --example compare_with_euroc -- DATA [SEED]`, DATA a folder of ASL sequences.

#[path = "../tests/summary/mod.rs"]
mod summary;

use dpn_io::asl;
use dpn_sim::{FlightConfig, simulate_all};
use std::error::Error;
use std::path::Path;
use summary::recording::{RecordingSummary, summarise};
use summary::table::compare;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let data = arguments.next().ok_or("usage: compare_with_euroc DATA [SEED]")?;
    let seed = arguments.next().map_or(Ok(1), |s| s.parse())?;

    let flights = simulate_all(seed, &FlightConfig::default())?;
    let simulated: Vec<RecordingSummary> =
        flights.iter().map(|f| summarise(&f.recording)).collect::<Result<_, _>>()?;
    let mut real = Vec::new();
    for sequence in asl::discover(Path::new(&data))? {
        real.push(summarise(&sequence.imu()?)?);
    }
    print!("{}", compare(&[("EuRoC", &real), ("simulated", &simulated)]));
    Ok(())
}
