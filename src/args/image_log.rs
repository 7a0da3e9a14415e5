//! A log with images, and how it is to be read.

use super::HowArgs;
use clap::Args;

/// Topics, columns and units.
#[derive(Debug, Args)]
pub(crate) struct ImageLogArgs {
    /// The images' topic in a bag; without it, the only one of type sensor_msgs/Image or CompressedImage.
    #[arg(long, value_name = "TOPIC")]
    pub(crate) image_topic: Option<String>,
    /// How the IMU's part is read.
    #[command(flatten)]
    pub(crate) imu: HowArgs,
}
