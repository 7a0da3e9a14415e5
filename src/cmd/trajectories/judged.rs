//! Trajectories that were judged, and those of one estimator against another's.

use super::find::Case;
use anyhow::{Context, Result};
use dpn_eval::metrics::Compared;
use dpn_eval::study::{Comparison, MARGIN, compare_pairs, correct_for_count};

/// One trajectory that was judged.
pub(super) struct Judged {
    pub(super) case: Case,
    /// Poses that its file has.
    pub(super) poses: usize,
    pub(super) compared: Compared,
    /// Whether its poses have no stamps.
    pub(super) counted: bool,
}

/// One estimate against the first over several sequences.
pub(super) struct Versus {
    pub(super) comparison: Comparison,
    /// Sequences in which it is worse.
    pub(super) worse: usize,
}

/// The others against the first, over the sequences that both have.
pub(super) fn versus(judged: &[Judged], estimates: usize) -> Result<Vec<Option<Versus>>> {
    let of = |estimate: usize| judged.iter().filter(move |one| one.case.number == estimate);
    let mut all = vec![None];
    for estimate in 1..estimates {
        let pairs = of(estimate).filter_map(|ours| {
            let theirs = of(0).find(|theirs| theirs.case.sequence == ours.case.sequence)?;
            Some((ours.compared.summary.rmse, theirs.compared.summary.rmse))
        });
        let (ours, theirs): (Vec<f64>, Vec<f64>) = pairs.unzip();
        let worse = ours.iter().zip(&theirs).filter(|(a, b)| a > b).count();
        let comparison = compare_pairs(&ours, &theirs, MARGIN).context("the ratio of two errors")?;
        all.push(comparison.map(|comparison| Versus { comparison, worse }));
    }
    correct_for_count(all.iter_mut().flatten().map(|versus| &mut versus.comparison))?;
    Ok(all)
}
