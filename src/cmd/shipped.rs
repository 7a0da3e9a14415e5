//! The networks that come with the program, in the binary itself: nothing needs training first.

use anyhow::Result;
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

/// Every shipped network.
pub(crate) fn networks() -> Result<Vec<Network>, NetworkError> {
    SHIPPED.iter().map(|(name, bytes)| Network::from_bytes(bytes, Path::new(name))).collect()
}
