//! The noise figures of an IMU as other programs write them: reading, converting, writing, with the arithmetic said line by line.
//!
//! * [`ImuFigures`](dpn_core::noise::ImuFigures): white noise and bias walk of both sensors as densities, what everything is converted through.
//! * [`Format`]: who writes what: a table of [`Layout`]s of four keys for kalibr, openvins, orbslam3, okvis2, basalt, vins and variances; `ros` (covariance matrices of a message) and `datasheet` (numbers with units) read and write in their own way.
//! * [`Meaning`](dpn_core::noise::Meaning): what a number means (density, per sample, variance, step of a walk ...), with the way to a density and back.
//! * [`Quantity`]: a number with a unit, such as `0.2 mg/sqrt(Hz)` or `0.3 deg/sqrt(h)`.
//! * [`read`], [`Given`], [`write()`]: file to figures to text; [`Conversion`]: both at once.
//!
//! Left out: scale, misalignment, g-sensitivity, and whatever else such a file says about cameras.

mod calibration;
mod convert;
mod datasheet;
mod error;
mod format;
mod imu_utils;
pub(crate) mod kalibr_results;
mod key_fault;
mod keyed;
mod layout;
mod layouts;
mod number;
mod quantity;
mod read;
mod registry;
mod ros;
#[cfg(test)]
mod round_trip;
mod step;
#[cfg(test)]
mod table;
pub(crate) mod tree;
mod vins;
mod write;
pub(crate) mod xrslam;

pub use calibration::{Given, NoiseCalibration, Zero};
pub use convert::Conversion;
pub use error::{FormatError, Slip};
pub use format::{Format, UnknownFormat};
pub use key_fault::KeyFault;
pub use layout::{Key, Layout};
pub use number::number;
pub use quantity::{Quantity, QuantityError};
pub use read::{parse, read};
pub use step::{Remark, Step};
pub use write::{Written, write};
