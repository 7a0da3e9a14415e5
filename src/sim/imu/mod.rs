//! A simulated IMU whose noise is exactly known, part by part: white noise, biases, vibration, quantisation, each in its
//! own file and on its own named random streams, so that switching one off moves no bit of another.

mod bias;
mod ou;
mod quantise;
mod reading;
mod series;
mod truth;
mod vibration;
mod white;

pub use bias::BiasConfig;
pub use quantise::QuantisationConfig;
pub(crate) use reading::{flown, read};
pub use series::ImuSeries;
pub use truth::ImuTruth;
pub use vibration::{HoverTones, VibrationConfig};
pub use white::{SigmaEvent, WhiteConfig};
