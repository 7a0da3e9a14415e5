//! Noise specs: the strings that name a noise model, parsed once.
//!
//! A spec is one call, for both sensors, or two with a comma between, accelerometer first: `x2`, `sg(11,2)`,
//! `const(.08,.004)`, `x4,x1`, `diff2,sg(11,2)`. `call` is the grammar alone; [`SensorPair`] what is made of the samples so far;
//! [`NoiseSpec`] everything that may be written, networks, files and controls included.
//!
//! | call | meaning |
//! |---|---|
//! | `x<factor>` | that multiple of the baseline (.08 m/s^2, .004 rad/s) |
//! | `const(accel,gyro)` | those deviations per sample \[m/s^2, rad/s\]; `const(value)` in a pair |
//! | `sg(window,order)`, `diff1` .. `diff4`, `mad2`, `wavelet(family)`, `allan` | the window estimators |
//! | `running(first)`, `sliding(length)`, `ewma(alpha)`, `kalman(q)` | the streaming ones |
//!
//! Arguments may be left out: `sg` is `sg(11,2)`, `wavelet` is `wavelet(db4)`, `running` averages since the start,
//! `sliding` takes the schedule's window, `ewma` is `ewma(0.01)`, `kalman` is `kalman(0.1)`.

mod call;
mod error;
mod estimator;
mod names;
mod noise;
mod sensors;

pub(crate) use call::{Arg, Call};
pub use error::SpecError;
pub use estimator::EstimatorSpec;
pub use noise::{DEFAULT_TAG, FLIGHT_TAG, NoiseSpec, parse_list};
pub use sensors::{SensorPair, SensorSpec};
