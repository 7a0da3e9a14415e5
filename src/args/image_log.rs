//! A log with images, and how it is to be read.

use clap::Args;

/// Topics.
#[derive(Debug, Args)]
pub(crate) struct ImageLogArgs {
    /// The images' topic in a bag; without it, the only one of type sensor_msgs/Image or CompressedImage.
    #[arg(long, value_name = "TOPIC")]
    pub(crate) image_topic: Option<String>,
    /// The IMU's topic in a bag; without it, the only one of type sensor_msgs/Imu.
    #[arg(long, value_name = "TOPIC")]
    pub(crate) topic: Option<String>,
    /// Bytes that a bag's chunks or a packed file may unpack to, all together, for example 4GB; without it, 32 MB and 32 times the packed bytes.
    #[arg(long, value_name = "SIZE", value_parser = super::cache::size)]
    pub(crate) max_uncompressed: Option<u64>,
}
