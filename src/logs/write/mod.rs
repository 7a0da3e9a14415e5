//! Logs written: MCAP files, which ROS 2's tools and Foxglove read.

mod copy;
mod imu_log;
mod mcap_log;

pub use copy::{CovarianceCopy, is_copied, write_with_covariances};
pub use imu_log::write_imu_log;
pub use mcap_log::McapLog;
