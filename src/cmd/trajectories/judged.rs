//! Trajectories that were judged, and those of one estimator against another's.

use super::find::Case;
use crate::ui::Fault;
use anyhow::{Context, Result};
use dpn_eval::metrics::{AlignmentKind, Compared, PosePair, align};
use dpn_eval::study::{Comparison, MARGIN, compare_pairs, correct_for_count};
use dpn_figures::PoseBelief;
use nalgebra::Vector3;

/// One trajectory that was judged.
pub(super) struct Judged {
    pub(super) case: Case,
    /// Poses that its file has.
    pub(super) poses: usize,
    pub(super) compared: Compared,
    /// What the estimate believes of its poses, where that is known, by the stamps of the pairs.
    pub(super) beliefs: Vec<PoseBelief>,
    /// Whether its poses have no stamps.
    pub(super) counted: bool,
}

/// Errors below this are the rounding of sums.
const NOTHING: f64 = 1e-12;

impl Judged {
    /// How many times as large as the truth the estimate is, where that is clear and far from once: a factor beyond two between paths of one shape.
    pub(super) fn times_as_large(&self) -> Option<f64> {
        let scale = align(&self.compared.pairs, AlignmentKind::Sim3).ok()?.scale;
        let spread = |of: fn(&PosePair) -> Vector3<f64>| {
            let pairs = &self.compared.pairs;
            let mean = pairs.iter().map(of).sum::<Vector3<f64>>() / pairs.len() as f64;
            pairs.iter().map(|pair| (of(pair) - mean).norm_squared()).sum::<f64>().sqrt()
        };
        let estimate = spread(|pair| pair.est_world_from_body.translation.vector);
        let truth = spread(|pair| pair.true_world_from_body.translation.vector);
        // The correlation of both paths: one that has drifted away is no matter of scale.
        let alike = scale * estimate / truth > 0.9;
        (alike && !(0.5..=2.0).contains(&scale)).then_some(1.0 / scale)
    }
}

/// One estimate against the first over several sequences.
pub(super) struct Versus {
    pub(super) comparison: Comparison,
    /// Sequences in which it is worse.
    pub(super) worse: usize,
}

/// The others against the first, over the sequences that both have.
pub(super) fn versus(judged: &[Judged], estimates: usize) -> Result<Vec<Option<Versus>>> {
    if let (Some(one), true) = (judged.iter().find(|one| one.compared.summary.rmse < NOTHING), estimates > 1)
    {
        let (estimate, truth) = (one.case.estimate.display(), one.case.truth.display());
        let fault = Fault::new(format!(
            "{estimate} has no error against {truth}: it is the truth, and nothing has a ratio to it"
        ));
        return Err(fault.hint("leave its folder away, or judge it alone").into());
    }
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
