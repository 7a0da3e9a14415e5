//! How far an estimated trajectory is from the truth, and whether its covariance says so: pure functions, no files.
//!
//! 1. [`TruthTrack`]: ground truth as a function of time, which does not reach across its own gaps.
//! 2. [`associate_interpolated`], [`associate_nearest`]: pairs of a true and an estimated pose at one instant.
//! 3. [`align`]: the estimate's world has a freedom that the truth's has not; four choices of it.
//! 4. Errors: [`ate`] (absolute), [`rpe`], [`rpe_by`] (relative, by distance, time, frames or turn, by evo's names), [`scale_error`].
//! 5. [`absolute`], [`relative`]: all of it for two trajectories, as `evo_ape` and `evo_rpe` do it under their options ([`Comparing`]).
//! 6. Consistency: [`nees`] of one run, [`nees_report`] over runs.
//!
//! Both trajectories are of the same body frame, in increasing time; a trajectory of another frame (a camera's, a prism's) must be
//! moved to the body first. Every figure that evo also computes is held to evo's (`golden/evo`).

mod align;
mod associate;
mod ate;
mod compared;
mod error;
#[cfg(test)]
mod golden_tests;
mod nees;
mod nees_report;
mod relation;
mod rpe;
mod rpe_spec;
mod summary;
mod truth;

pub use align::{Alignment, AlignmentKind, align};
pub use associate::{Association, PosePair, associate_interpolated, associate_nearest};
pub use ate::{Ate, ate, scale_error};
pub use compared::{Compared, Comparing, absolute, relative};
pub use error::{MetricsError, Trajectory};
pub use nees::{PoseNees, nees, start_alignment};
pub use nees_report::{NeesPart, NeesReport, nees_report};
pub use relation::PoseRelation;
pub use rpe::{RPE_TOLERANCE, Rpe, rpe, rpe_by};
pub use rpe_spec::{BadRpeSpec, RpeSpec, RpeStep, StretchesOn};
pub use summary::ErrorSummary;
pub use truth::{Cover, Interpolation, TruthOptions, TruthTrack, poses_of};
