//! `dpn ros2`: nodes of ROS 2 without ROS 2.

mod calibration;
mod noise;
mod odometry;
mod params;
mod session;

use crate::args::{Ros2Args, Ros2What};
use anyhow::Result;

pub(super) fn run(args: Ros2Args) -> Result<()> {
    match args.what {
        Some(Ros2What::Noise(args)) => noise::run(args),
        None => odometry::run(args),
    }
}
