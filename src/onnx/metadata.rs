//! What has to be known to use a network rightly, as text under keys.

use crate::proto::StringStringEntryProto;
use dpn_core::checksum::of_bytes;
use dpn_pronet::{StoreError, Weights};

/// What the network is, in a sentence.
pub(crate) fn summary(weights: &Weights) -> String {
    let (config, unit) = (weights.config(), weights.sensor().unit());
    format!(
        "Standard deviation [{unit}] of the white noise in {} samples of one axis of the {}, sampled at {} Hz and given in {unit}. \
         A deviation that is not above zero means zero. Outside the range of training (`range_*`) nothing is known of it.",
        config.window,
        weights.sensor(),
        weights.card().rate.hz(),
    )
}

/// Keys and values. What the training says of itself is under `training`, as JSON.
pub(crate) fn entries(weights: &Weights) -> Result<Vec<StringStringEntryProto>, StoreError> {
    let card = weights.card();
    let mut pairs = vec![
        ("sensor", weights.sensor().to_string()),
        ("unit", weights.sensor().unit().to_owned()),
        ("rate_hz", card.rate.hz().to_string()),
        ("window", weights.config().window.to_string()),
        ("dpn_version", env!("CARGO_PKG_VERSION").to_owned()),
        ("weights_sha256", of_bytes(&weights.to_bytes()?)),
        ("training", serde_json::Value::Object(card.training.clone()).to_string()),
    ];
    if let Some(range) = card.range {
        for (key, [least, most]) in [("range_roughness", range.roughness), ("range_spread", range.spread)] {
            pairs.push((key, format!("{least} {most}")));
        }
    }
    Ok(pairs.into_iter().map(|(key, value)| entry(key, value)).collect())
}

pub(crate) fn entry(key: &str, value: String) -> StringStringEntryProto {
    StringStringEntryProto { key: Some(key.to_owned()), value: Some(value) }
}
