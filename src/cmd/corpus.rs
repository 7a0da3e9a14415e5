//! Recordings from a folder, or the simulated flights.

use crate::ui::Fault;
use anyhow::Result;
use dpn_core::SampleRate;
use dpn_sim::FlightConfig;
use dpn_train::corpus::{Corpus, Member};
use std::path::Path;

/// Name of the collection of simulated flights.
pub(crate) const SIMULATED: &str = "simulated";

/// Every collection under `dir`, or the simulated flights of seed 0, brought to `rate`.
pub(crate) fn load(dir: Option<&Path>, rate: SampleRate) -> Result<Vec<Corpus>> {
    match dir {
        Some(dir) => Ok(dpn_train::asl::load(dir, rate)?),
        None => Ok(vec![simulated(0, &FlightConfig::default(), rate)?]),
    }
}

/// The collection that is trained on.
pub(crate) fn to_train(corpora: Vec<Corpus>) -> Result<Corpus> {
    let chosen = dpn_train::corpus::to_train(corpora);
    Ok(chosen.ok_or_else(|| Fault::new("the data hold no sequence"))?)
}

/// The simulated flights of `seed`, brought to `rate`.
pub(crate) fn simulated(seed: u64, config: &FlightConfig, rate: SampleRate) -> Result<Corpus> {
    let members = dpn_sim::simulate_all(seed, config)?
        .into_iter()
        .map(|flight| Member {
            name: flight.name().to_owned(),
            side: flight.split(),
            recording: flight.recording,
        })
        .collect();
    Ok(Corpus::brought_to(rate, SIMULATED, members)?)
}
