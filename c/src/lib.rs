//! dpn for C and C++. What C sees stands in `include/dpn.h`, which cbindgen makes from this crate; `cargo test -p dpn-c` says when it is stale, and
//! `DPN_BLESS=1 cargo test -p dpn-c --test header` makes it anew.
//!
//! Pointers are read and written in `border` alone; handles are numbers from a table, never reused, so that a second free is an error and no crash.
//! Nothing panics across the border: what does is caught and is `DPN_STATUS_PANIC`.
#![cfg_attr(test, allow(clippy::unwrap_used))]

mod border;
mod gyro_bias;
mod level;
mod odometry;
mod status;
mod stream;
mod table;
mod weights;

pub use gyro_bias::{
    GyroCorrection, dpn_gyro_bias_correction, dpn_gyro_bias_feed, dpn_gyro_bias_free, dpn_gyro_bias_load,
};
pub use level::{dpn_level_factor, dpn_level_feed, dpn_level_free, dpn_level_new};
pub use odometry::{
    Noise, Phase, Update, dpn_odometry_encoded, dpn_odometry_end, dpn_odometry_free, dpn_odometry_image,
    dpn_odometry_imu, dpn_odometry_new, dpn_odometry_noise, dpn_odometry_tracks, dpn_odometry_update,
    dpn_odometry_waiting, dpn_odometry_warning,
};
pub use status::{Status, dpn_last_error, dpn_version};
pub use stream::{Sigma, dpn_stream_feed, dpn_stream_free, dpn_stream_new, dpn_stream_sigma};
pub use table::{GyroBiasHandle, LevelHandle, OdometryHandle, StreamHandle, WeightsHandle};
pub use weights::{Sensor, dpn_weights_free, dpn_weights_from_bytes, dpn_weights_load, dpn_weights_shipped};
