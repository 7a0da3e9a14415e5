//! Simple estimators of the deviation of white noise per sample, each usable as a noise model.
//!
//! All look at one axis and answer for white noise without bias; they differ in what else they take for noise:
//!
//! | spec | takes for noise | spread over the Cramer-Rao bound, 200 samples |
//! |---|---|---|
//! | `sg(11,2)` | what a local polynomial does not follow | 1.19 |
//! | `diff1`, `diff2`, `diff3`, `diff4` | ever more of the highest frequencies alone | 1.23, 1.40, 1.52, 1.63 |
//! | `allan` | as `diff1`; a slope counts too | 1.23 |
//! | `mad2` | as `diff2`, but not its outliers | 1.99 |
//! | `wavelet(db4)` | the upper half of the spectrum, but not its outliers | 2.36 |
//! | `running`, `sliding` | everything, motion included | 1.00 |
//! | `ewma(0.01)` | everything, the latest most | 1.15 |
//! | `kalman(0.1)` | what a slow random walk does not follow | 1.04 |
//!
//! `effective(0.1)` is none of these: it says which white noise errs as much over a span as what the axis has, vibration included.
//!
//! * [`WindowSigma`]: an estimator asked for a window; the moving variances are asked after every sample too.
//! * `windowed`: estimators on six axes as a [`NoiseModel`](crate::noise::NoiseModel).
//! * [`Seen`], [`Watch`]: what the spectrum of many seconds says against an estimate that looks at one.
//! * [`spec`]: the strings that name all of them.

mod allan;
mod axis;
mod differences;
mod effective;
mod fall;
mod mad2;
mod moving;
mod quadratic;
mod savgol;
pub mod spec;
mod watch;
mod wavelet;
mod window_sigma;
mod windowed;

#[cfg(test)]
mod white_noise_tests;

pub(crate) use allan::allan;
pub(crate) use axis::{Answer, AxisSigma, EachSample, Given, HopWindow, Reading};
pub(crate) use differences::differences;
pub use effective::{Effective, EffectiveStream, MOTION_HZ};
pub use fall::{Fall, LowPassSight, Seen};
pub(crate) use mad2::Mad2;
pub(crate) use savgol::sg_residual;
pub use spec::{DEFAULT_TAG, FLIGHT_TAG, NoiseSpec, SensorPair, SpecError, parse_list};
pub use watch::{Doubt, SLOWEST, Watch, Why, two};
pub(crate) use wavelet::WaveletMad;
pub use window_sigma::{EstimatorError, WindowSigma};
pub(crate) use windowed::Windowed;
pub use windowed::{Schedule, raised_to_floor};
