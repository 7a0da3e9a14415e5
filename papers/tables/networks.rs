//! The networks, layer by layer.

use dpn_figures::{Cell, Column, Provenance, Table};
use dpn_pronet::network::Network;
use dpn_pronet::shape::{LayerKind, layers};

/// A line a layer of the networks that `dualpronet` stands for.
pub(crate) fn networks(networks: &[&Network], made_by: Provenance) -> Table {
    let columns =
        Column::all(&["network", "layer", "what"], &["channels out", "time steps out", "parameters"]);
    let title = "The networks in use, layer by layer";
    let mut table = Table::new("networks", title, columns).made_by(made_by);
    for network in networks {
        let config = network.weights.config();
        for layer in layers(config) {
            let what = match layer.kind {
                LayerKind::Input => format!("a window of {} samples", config.window),
                LayerKind::Block { kernel, stride, .. } => {
                    format!("convolution of {kernel} samples every {stride}")
                }
                LayerKind::Pool => "pooling over time".to_owned(),
                LayerKind::Linear => "linear".to_owned(),
            };
            table.row(vec![
                Cell::text(network.sensor()),
                Cell::text(&layer.name),
                Cell::text(what),
                Cell::text(layer.channels),
                Cell::text(layer.length),
                Cell::text(layer.parameters),
            ]);
        }
        table.rule();
        table.note(format!("{}: {} ({}).", network.sensor(), network.path.display(), network.name));
    }
    table
}
