//! The networks that come with the program, in the binary itself: nothing needs training first.

use crate::ui::errln;
use anyhow::Result;
use dpn_core::SampleRate;
use dpn_pronet::network::{Network, NetworkError, load_all};
use std::path::Path;

include!(concat!(env!("OUT_DIR"), "/shipped.rs"));

/// The networks of a folder, or those that come with the program.
pub(crate) fn or_of(models: Option<&Path>) -> Result<Vec<Network>> {
    match models {
        Some(dir) => Ok(load_all(dir)?),
        None => Ok(networks()?),
    }
}

/// The networks of the open loop, whose windows are of the paper's rate: a folder's, or `networks`, which came with the program, and beside them those of the
/// study in the folder `more`, ordered by sensor and name; without that folder a note says so.
pub(crate) fn judged(networks: &[Network], models: Option<&Path>, more: &Path) -> Result<Vec<Network>> {
    let is_of_rate = |network: &&Network| network.weights.card().rate == SampleRate::HZ_200;
    let mut all: Vec<Network> = networks.iter().filter(is_of_rate).cloned().collect();
    if models.is_some() {
        return Ok(all);
    }
    if more.is_dir() {
        all.extend(load_all(more)?);
        all.sort_by_key(|network| (network.sensor().name(), network.tag()));
    } else {
        let what = "the open loop judges the networks that come with the program alone";
        errln!("note: {what}, for there is no folder {} (--more-models)", more.display());
    }
    Ok(all)
}

/// Every shipped network.
pub(crate) fn networks() -> Result<Vec<Network>, NetworkError> {
    SHIPPED.iter().map(|(name, bytes)| Network::from_bytes(bytes, Path::new(name))).collect()
}
