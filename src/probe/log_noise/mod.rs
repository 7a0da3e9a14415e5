//! How noisy an IMU is along a log that somebody recorded: `dpn noise LOG`.
//!
//! * [`Plan`]: a noise spec ([`Causal`](dpn_noise::Causal)) and how often an answer is wanted.
//! * [`track`]: its answers along a log, and which of the windows it looked at were unlike those it was trained on.
//! * [`phases`](crate::phases): at rest, motors on, moving, from the samples alone.
//! * [`TrackSummary`]: quantiles per axis and phase.
//! * [`Levels`]: floor at rest and envelope in motion, from the samples themselves.
//! * [`EffectiveNoise`]: the white noise that errs as much over a span, and what to paste.
//! * [`compare`]: a configuration against both.
//! * [`Along`]: all of it, and [`report`] in words.
//! * [`table`]: many logs, a row each.

mod along;
pub mod compare;
mod effective;
mod error;
mod levels;
#[cfg(test)]
mod mix_ups;
mod plan;
pub mod report;
mod seen;
mod summary;
pub mod table;
mod track;

pub use along::Along;
pub use effective::{EffectiveNoise, Increment, SpanNoise};
pub use error::LogNoiseError;
pub use levels::{FloorFrom, Levels, SensorLevels};
pub use plan::Plan;
pub use summary::{AxisSummary, OutsideSpan, PhaseSummary, Quantiles, SensorOutside, TrackSummary};
pub use track::{Answer, Track, track};
