//! The closed loop: the odometry, told its noise by each of several sources, over sequences, seeds and starts, judged against the truth.
//!
//! * [`Experiment`] says what is run: source, camera, span, noises, seeds, estimator, injection. [`RunSource`] opens sources.
//! * [`SequenceSet`] has the sequences: recordings on disk with camera tracks given or made along their ground truth, or simulated flights.
//! * [`ImageStream`] is the seam for images. The estimator follows points through them; its own tracker does it once where many runs share the
//!   tracks ([`CameraInput::tracks`]), to the same bits.
//! * [`drive`] runs the estimator over one [`Recording`] with one noise track; [`judge`] makes a [`Row`] of what comes out.
//! * [`Sweep`] runs all cells on all threads into a folder, which a later call goes on with. A cell is named by a checksum of all that its row is a
//!   function of, so that nothing stale is ever taken for it; the folder has one writer at a time.
//! * [`watched_run`] runs one recording and says everything of it.
//! * [`consistency`] puts the NEES of many seeds together. What rows say of noises: [`crate::study`].

mod cell;
mod cell_run;
mod consistency;
mod drive;
mod error;
mod experiment;
mod frame_log;
mod image_report;
mod images;
mod judge;
mod judged_run;
mod lazy;
mod learned;
mod logged;
mod manifest;
mod recording;
mod rendered;
mod rhythm;
mod row;
mod scale_known;
mod sequence;
mod sequence_checksum;
mod sequence_fault;
mod sequence_name;
mod sequence_set;
mod settings;
mod source;
mod source_error;
mod states;
mod store;
mod sweep;
mod sweep_cache;
mod sweep_faults;
mod sweep_plan;
mod tally;
mod track_cache;
mod tracked;
mod tracking;
mod tracking_log;
mod walk;

pub use consistency::{Consistency, consistency};
pub use drive::{EstimatorOutput, FEWEST_FRAMES, UpdateWatch, drive, frames_from};
pub use error::ClosedLoopError;
pub use experiment::Experiment;
pub use frame_log::SeenFrame;
pub use image_report::{FrontEndFigures, ImageEvent, ImageReport, PassedOver};
pub use images::{ImageStream, has_images};
pub use judge::{Errors, Judged, MAX_GAP_S, RunInfo, judge, paired, run_nees};
pub use judged_run::{JudgedRun, Report, Watchers, watched_run};
pub use learned::{LearnedFigure, LearnedLevels, LearnedNoise};
pub use logged::LoggedSequence;
pub use manifest::Manifest;
pub use recording::{Recording, Span, StartAt, first_motion};
pub use rhythm::{Hole, Rhythm};
pub use row::{CellKey, Failure, Restart, Row, StageSeconds, TruthKind};
pub use scale_known::ScaleKnown;
pub use sequence::path_config;
pub use sequence_fault::SequenceFault;
pub use sequence_set::{SequenceSet, Sequences, TrackSource};
pub use settings::Settings;
pub use source::{Camera, RunSource};
pub use source_error::SourceError;
pub use states::ANCHOR;
pub use states::write_states;
pub use store::{Store, read_rows};
pub use sweep_faults::{FailedCell, UntrackedSequence};
pub use sweep_plan::{CellFiles, Sweep};
pub use track_cache::TrackCache;
pub use tracked::TrackedSequence;
pub use tracking::CameraInput;

#[cfg(any(test, feature = "testing"))]
#[doc(hidden)]
pub use row::testing;
