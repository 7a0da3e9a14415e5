//! ASL's folder layout, as EuRoC and TUM-VI ship it: `SEQUENCE/mav0/{imu0,cam0,state_groundtruth_estimate0,mocap0}/data.csv`, each
//! sensor with a `sensor.yaml` beside.

pub(crate) mod camera;
mod discover;
pub(crate) mod ground_truth;
pub(crate) mod imu_config;
mod sequence;
mod write;
#[cfg(feature = "images")]
mod write_camera;
mod yaml;

pub use camera::{CameraFrame, read_config as read_camera_config};
pub use discover::discover;
pub use ground_truth::read as read_ground_truth;
pub use imu_config::ImuConfig;
pub use sequence::Sequence;
#[cfg(test)]
pub(crate) use sequence::parse_imu;
pub use write::{SequenceParts, write_ground_truth, write_imu_rows, write_sequence};
#[cfg(feature = "images")]
pub use write_camera::{image_place, png, write_camera_config, write_camera_frames, write_png};
