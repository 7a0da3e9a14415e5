//! Recordings from a folder, or the simulated flights.

use crate::ui::Fault;
use anyhow::Result;
use dpn_sim::{FlightConfig, Split};
use dpn_train::corpus::{Corpus, Member};
use dpn_train::split::Side;
use std::path::Path;

/// Name of the collection of simulated flights.
pub(crate) const SIMULATED: &str = "simulated";

/// Every collection under `dir`; without it the simulated flights of seed 0.
pub(crate) fn load(dir: Option<&Path>) -> Result<Vec<Corpus>> {
    match dir {
        Some(dir) => Ok(dpn_train::asl::load(dir)?),
        None => Ok(vec![simulated(0, &FlightConfig::default())?]),
    }
}

/// The collection that is trained on: the first with sequences to train on.
pub(crate) fn to_train(mut corpora: Vec<Corpus>) -> Result<Corpus> {
    let place = corpora.iter().position(|corpus| !corpus.side(Side::Train).is_empty()).unwrap_or(0);
    if corpora.is_empty() {
        return Err(Fault::new("the data hold no sequence").into());
    }
    Ok(corpora.swap_remove(place))
}

/// The simulated flights of `seed`.
pub(crate) fn simulated(seed: u64, config: &FlightConfig) -> Result<Corpus> {
    let members = dpn_sim::simulate_all(seed, config)?
        .into_iter()
        .map(|flight| Member {
            name: flight.name().to_owned(),
            side: match flight.split() {
                Split::Train => Side::Train,
                Split::Test => Side::Test,
            },
            recording: flight.recording,
        })
        .collect();
    Ok(Corpus::new(SIMULATED, members)?)
}
