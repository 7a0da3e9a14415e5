//! A ROS 2 node without ROS 2: what `dpn ros2` is made of.
//!
//! * [`RosArgs`]: what stands behind `--ros-args`: remappings, parameters, namespace. [`Names`] makes topics' names of them, as `rcl` does.
//! * [`Node`]: topics over DDS (RTPS on UDP, by `rustdds`), messages as their bytes; it says who publishes, whose quality of service or type does not fit.
//! * [`incoming`] reads messages, [`outgoing`] writes them, both in plain CDR. Types as humble, jazzy and kilted have them: in what is used here they are the same.
//! * [`StaticFrames`]: `/tf_static`, for where a camera stands on its IMU.
//! * [`calibration_of`] makes a calibration of a `CameraInfo` and such a place.
//!
//! On the wire a topic `/a/b` is called `rt/a/b` and a type `sensor_msgs/msg/Imu` is called `sensor_msgs::msg::dds_::Imu_`.
//! Source: design.ros2.org, "Topic and Service name mapping to DDS".
#![cfg_attr(test, allow(clippy::unwrap_used))]

mod args;
mod camera_info;
mod cdr;
mod domain;
mod error;
mod frames;
pub mod incoming;
mod names;
mod node;
pub mod outgoing;
mod raw;

pub use args::{Param, RosArgs};
pub use camera_info::{BadCameraInfo, calibration_of};
pub use domain::Domain;
pub use error::Ros2Error;
pub use frames::StaticFrames;
pub use names::Names;
pub use node::{Message, Node, Publisher, Quality, TopicId};

/// The README's code is a test.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
