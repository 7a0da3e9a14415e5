//! The networks that come with the program, in the binary itself: nothing needs training first.

use anyhow::Result;
use dpn_pronet::network::Network;
use std::path::Path;

include!(concat!(env!("OUT_DIR"), "/shipped.rs"));

/// Every shipped network.
pub(crate) fn networks() -> Result<Vec<Network>> {
    SHIPPED.iter().map(|(name, bytes)| Ok(Network::from_bytes(bytes, Path::new(name))?)).collect()
}
