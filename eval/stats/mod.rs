//! The statistics that decide the question: paired tests over sequences, corrections, equivalence, intervals.
//!
//! * [`signed_rank`]: Wilcoxon's test of paired differences, exact for few pairs, ties included.
//! * [`sign_test`]: whether more differences are of one sign than chance makes.
//! * [`hodges_lehmann`]: the difference that belongs to it.
//! * [`equivalence_signed_rank`]: two one-sided tests, usually of [`log_ratios`].
//! * [`holm`]: p-values of several tests at once.
//! * [`median_interval`], [`bootstrap`]: bootstrap intervals from a named stream.
//! * [`chi_square_interval`]: bounds of a sum of squares.
//! * [`percentile`]: the value that a share of all does not exceed.
//!
//! All take plain slices, return an error for values that are not finite, and are held to scipy and statsmodels (`golden/paired_tests`).

mod bootstrap;
mod chi_square;
mod equivalence;
mod error;
mod hodges_lehmann;
mod holm;
mod percentile;
mod ranks;
mod sign;
mod signed_rank;

pub use bootstrap::{Bootstrap, Interval, bootstrap, median_interval};
pub use chi_square::chi_square_interval;
pub use equivalence::{Equivalence, equivalence_signed_rank, log_ratios};
pub use error::StatsError;
pub use hodges_lehmann::hodges_lehmann;
pub use holm::holm;
pub use percentile::percentile;
pub use sign::sign_test;
pub use signed_rank::{Alternative, EXACT_UP_TO, NullDistribution, SignedRank, signed_rank};
