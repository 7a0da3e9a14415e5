//! Two trajectories compared as `evo_ape` and `evo_rpe` compare them, option by option.
//!
//! 1. Poses outside `from..=to` are left out, and the estimate's stamps are moved by `offset_s`.
//! 2. Pairs are those of the nearest stamps ([`associate_nearest`]).
//! 3. The estimate is brought into the truth's world: aligned over the first `n_to_align` pairs, scaled, or put on the truth's first pose.
//! 4. Errors by [`PoseRelation`]: of every pair, or of every stretch of an [`RpeSpec`].
//!
//! Every option is held to evo's programs (`golden/evo/commands.json`, `tests/cli/trajectories.rs`).

use super::align::{Alignment, AlignmentKind, align};
use super::associate::{PosePair, associate_nearest};
use super::error::MetricsError;
use super::relation::PoseRelation;
use super::rpe::stretches_of;
use super::rpe_spec::RpeSpec;
use super::summary::ErrorSummary;
use dpn_core::Stamp;
use dpn_core::trajectory::StampedPose;

/// How two trajectories are compared; named as evo's options, in whose order they stand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparing {
    /// What of an error is counted.
    pub relation: PoseRelation,
    /// SE(3) alignment.
    pub align: bool,
    /// Scale of the Sim(3) alignment; with `align` that alignment itself.
    pub correct_scale: bool,
    /// The estimate's first pose is put on the truth's; not with `align`.
    pub align_origin: bool,
    /// Pairs that align and scale, from the first on; all of them where none is given.
    pub n_to_align: Option<usize>,
    /// Farthest that the stamps of a pair may be apart \[s\].
    pub max_diff_s: f64,
    /// Added to the estimate's stamps \[s\].
    pub offset_s: f64,
    /// First stamp that is looked at.
    pub from: Option<Stamp>,
    /// Last stamp that is looked at.
    pub to: Option<Stamp>,
}

/// What a comparison found.
#[derive(Debug, Clone, PartialEq)]
pub struct Compared {
    /// The pairs, the estimate brought into the truth's world.
    pub pairs: Vec<PosePair>,
    /// What brought it there.
    pub alignment: Alignment,
    /// Errors, each with the pair that it belongs to: of a stretch the last.
    pub errors: Vec<(usize, f64)>,
    /// The same in a few numbers.
    pub summary: ErrorSummary,
}

/// Absolute errors, one of every pair.
///
/// # Errors
/// A trajectory without poses, with stamps that do not increase or with values that are not finite; too few pairs; an alignment that the
/// positions do not determine.
pub fn absolute(
    truth: &[StampedPose],
    estimate: &[StampedPose],
    by: &Comparing,
) -> Result<Compared, MetricsError> {
    let (pairs, alignment) = by.pairs(truth, estimate)?;
    let errors = pairs.iter().map(|pair| by.relation.absolute(pair)).enumerate().collect();
    compared(pairs, alignment, errors, "an absolute error")
}

/// Relative errors, one of every stretch; `tolerance` as of [`rpe_by`](super::rpe_by).
///
/// # Errors
/// As [`absolute`]; no stretch of that length; options as of [`rpe_by`](super::rpe_by).
pub fn relative(
    truth: &[StampedPose],
    estimate: &[StampedPose],
    by: &Comparing,
    (spec, tolerance): (&RpeSpec, f64),
) -> Result<Compared, MetricsError> {
    let (pairs, alignment) = by.pairs(truth, estimate)?;
    if pairs.len() < 2 {
        return Err(MetricsError::TooFewPairs { what: "a relative error", needed: 2, found: pairs.len() });
    }
    let stretches = stretches_of(&pairs, spec, tolerance)?;
    if stretches.is_empty() {
        return Err(MetricsError::NoStretch { spec: spec.to_string(), pairs: pairs.len() });
    }
    let errors =
        stretches.into_iter().map(|(i, j)| (j, by.relation.relative(&pairs[i], &pairs[j]))).collect();
    compared(pairs, alignment, errors, "a relative error")
}

fn compared(
    pairs: Vec<PosePair>,
    alignment: Alignment,
    errors: Vec<(usize, f64)>,
    what: &'static str,
) -> Result<Compared, MetricsError> {
    let values: Vec<f64> = errors.iter().map(|(_, error)| *error).collect();
    let none = MetricsError::TooFewPairs { what, needed: 1, found: 0 };
    let summary = ErrorSummary::of(&values).ok_or(none)?;
    Ok(Compared { pairs, alignment, errors, summary })
}

impl Comparing {
    /// The pairs, the estimate brought into the truth's world, and what brought it there.
    fn pairs(
        &self,
        truth: &[StampedPose],
        estimate: &[StampedPose],
    ) -> Result<(Vec<PosePair>, Alignment), MetricsError> {
        let within = |pose: &&StampedPose| {
            self.from.is_none_or(|from| from <= pose.t) && self.to.is_none_or(|to| pose.t <= to)
        };
        let truth: Vec<StampedPose> = truth.iter().filter(within).copied().collect();
        let moved = |pose: &StampedPose| StampedPose { t: pose.t.plus_seconds(self.offset_s), ..*pose };
        let estimate: Vec<StampedPose> = estimate.iter().filter(within).map(moved).collect();
        if truth.is_empty() || estimate.is_empty() {
            return Ok((Vec::new(), Alignment::identity()));
        }
        let mut pairs = associate_nearest(&truth, &estimate, self.max_diff_s)?.pairs;
        let alignment = self.alignment(&pairs)?;
        for pair in &mut pairs {
            pair.est_world_from_body = alignment.apply(&pair.est_world_from_body);
        }
        Ok((pairs, alignment))
    }

    fn alignment(&self, pairs: &[PosePair]) -> Result<Alignment, MetricsError> {
        let first = &pairs[..self.n_to_align.unwrap_or(pairs.len()).min(pairs.len())];
        let mut alignment = match (self.align, self.correct_scale) {
            (true, false) => align(first, AlignmentKind::Se3)?,
            (true, true) => align(first, AlignmentKind::Sim3)?,
            (false, true) => {
                Alignment { scale: align(first, AlignmentKind::Sim3)?.scale, ..Alignment::identity() }
            }
            (false, false) => Alignment::identity(),
        };
        if let (true, Some(first)) = (self.align_origin, pairs.first()) {
            let origin = alignment.apply(&first.est_world_from_body);
            alignment.true_world_from_est_world = first.true_world_from_body * origin.inverse();
        }
        Ok(alignment)
    }
}
