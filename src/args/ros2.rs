//! `dpn ros2`.

use super::examples;
use clap::{Args, Subcommand};
use std::net::SocketAddr;
use std::path::PathBuf;

/// Flags of `dpn ros2`.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct Ros2Args {
    /// Another node than the odometry.
    #[command(subcommand)]
    pub(crate) what: Option<Ros2What>,
    /// Topic of the images.
    #[arg(long, value_name = "TOPIC", default_value = "image_raw")]
    pub(crate) image: String,
    /// The images are sensor_msgs/CompressedImage (PNG or JPEG); their topic is then TOPIC/compressed.
    #[arg(long)]
    pub(crate) compressed: bool,
    /// Topic of the camera's calibration, where --calib gives none; where the camera stands on the IMU is then taken from /tf_static.
    #[arg(long, value_name = "TOPIC", default_value = "camera_info")]
    pub(crate) camera_info: String,
    /// Calibration of the camera: Kalibr, OpenVINS, VINS, ORB-SLAM3, Basalt, OKVIS2, ASL.
    #[arg(long, value_name = "FILE")]
    pub(crate) calib: Option<PathBuf>,
    /// Seconds to add to the camera's stamps, beyond what its calibration says; without it they are found.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub(crate) time_offset: Option<f64>,
    /// Where every sample's noise comes from, as for `dpn run`.
    #[arg(long, value_name = "SPEC", default_value = "self")]
    pub(crate) noise: String,
    /// Folder of trained networks; without it those that come with the program.
    #[arg(long, value_name = "DIR")]
    pub(crate) models: Option<PathBuf>,
    /// Configuration of the estimator (TOML).
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// One key of the estimator's configuration, over the file. May be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = super::closed_loop::key_value)]
    pub(crate) sets: Vec<(String, String)>,
    /// Seed of the front-end's random choices.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Frame in which poses are given.
    #[arg(long, value_name = "FRAME", default_value = "odom")]
    pub(crate) odom_frame: String,
    /// Send no transforms on /tf: another node does.
    #[arg(long)]
    pub(crate) no_tf: bool,
    /// Show it while it runs to Foxglove (its WebSocket): image with tracks, path, biases, levels, latency; on this machine alone unless another address is given (0.0.0.0:8765). Of a dpn built with the feature `view`, as a release's is.
    #[arg(long, value_name = "ADDRESS:PORT", num_args = 0..=1, require_equals = true, default_missing_value = "127.0.0.1:8765")]
    pub(crate) view: Option<SocketAddr>,
    /// What both nodes take.
    #[command(flatten)]
    pub(crate) node: NodeArgs,
}

/// Other nodes.
#[derive(Debug, Subcommand)]
pub(crate) enum Ros2What {
    /// The noise of an IMU alone, for another odometry: its messages again, with covariances.
    #[command(after_help = examples::ROS2_NOISE)]
    Noise(Ros2NoiseArgs),
}

/// Flags of `dpn ros2 noise`.
#[derive(Debug, Args)]
pub(crate) struct Ros2NoiseArgs {
    /// Where the noise comes from, as for `dpn noise`; without it the shipped networks, or diff2 where the rate is not theirs.
    #[arg(long, value_name = "SPEC")]
    pub(crate) noise: Option<String>,
    /// Folder with networks of your own, instead of those that come with the program.
    #[arg(long, value_name = "DIR")]
    pub(crate) weights: Option<PathBuf>,
    /// What both nodes take.
    #[command(flatten)]
    pub(crate) node: NodeArgs,
}

/// What every node takes.
#[derive(Debug, Args)]
pub(crate) struct NodeArgs {
    /// Topic of the IMU.
    #[arg(long, value_name = "TOPIC", default_value = "imu")]
    pub(crate) imu: String,
    /// Listen reliably: lost messages are sent again. Publishers of sensor data that are best effort are then not heard.
    #[arg(long)]
    pub(crate) reliable: bool,
    /// Time is what /clock says, as in a simulation or beside a bag that is played.
    #[arg(long)]
    pub(crate) use_sim_time: bool,
    /// Remappings (-r imu:=/imu0), parameters (-p use_sim_time:=true, --params-file FILE), namespace (-r __ns:=/robot) and name (-r __node:=eye), up to the end or to --.
    #[arg(long, value_name = "ARGS", num_args = 0.., allow_hyphen_values = true, value_terminator = "--")]
    pub(crate) ros_args: Vec<String>,
}
