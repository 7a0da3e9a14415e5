//! From when on the size of a path is known.
//!
//! A window is too sure of its scale: where the noise given is the noise there is, one error in twenty is beyond three of its deviations, over two seconds
//! of motion each (`self` on six EuRoC flights: 2.3 to 3.4, between phases of rest). So three count for what is known.

use dpn_vio::estimator::{Phase, Update};
use serde::Serialize;

/// So many of the window's deviations hold an error.
const DEVIATIONS: f64 = 3.0;
/// What is asked of a scale.
const WITHIN: [f64; 2] = [0.1, 0.02];

/// A scale that is known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ScaleKnown {
    /// To such a share.
    pub within: f64,
    /// From so long after the first frame on \[s\].
    pub since_s: f64,
}

impl ScaleKnown {
    /// What is known at the end of a run.
    pub(super) fn of(updates: &[Update]) -> Vec<Self> {
        let Some(first) = updates.first() else { return Vec::new() };
        known(updates.iter().map(|update| {
            let restarted = matches!(update.phase, Phase::Restarted(_));
            (update.t.seconds_since(first.t), restarted, update.scale_std)
        }))
    }
}

/// Of frames: their time, whether they end an estimate, and the window's deviation. A new start knows nothing of what was known before it.
fn known(frames: impl Iterator<Item = (f64, bool, Option<f64>)>) -> Vec<ScaleKnown> {
    let mut since = WITHIN.map(|_| None);
    for (t, restarted, std) in frames {
        if restarted {
            since = WITHIN.map(|_| None);
        }
        for (since, within) in since.iter_mut().zip(WITHIN) {
            if std.is_some_and(|std| DEVIATIONS * std <= within) {
                since.get_or_insert(t);
            }
        }
    }
    let found = WITHIN.into_iter().zip(since);
    found.filter_map(|(within, since_s)| Some(ScaleKnown { within, since_s: since_s? })).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_known_once_stays_known_until_a_new_start() {
        let stds = [None, Some(0.04), Some(0.033), Some(0.006), Some(0.2)];
        let frames = || stds.into_iter().enumerate().map(|(t, std)| (t as f64, false, std));
        let since = |known: Vec<ScaleKnown>| known.iter().map(|k| (k.within, k.since_s)).collect::<Vec<_>>();
        assert_eq!(since(known(frames())), [(0.1, 2.0), (0.02, 3.0)]);
        let again = [(5.0, true, None), (6.0, false, Some(0.02))];
        assert_eq!(since(known(frames().chain(again))), [(0.1, 6.0)]);
    }
}
