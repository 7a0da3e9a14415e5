//! Signal processing on one axis: smoothing, spectra, wavelets, window statistics.
//!
//! * [`savitzky_golay`]: polynomial smoothing with polynomial edges.

pub mod savitzky_golay;

pub use savitzky_golay::{FilterError, SavitzkyGolay};
