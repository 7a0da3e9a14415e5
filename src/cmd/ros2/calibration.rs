//! A camera's calibration from what ROS says of it: `CameraInfo` and `/tf_static`.

use super::session::{Next, Session};
use crate::ui::errln;
use anyhow::Result;
use dpn_io::calibration::Calibration;
use dpn_io::printable;
use dpn_ros2::incoming::{CameraInfo, Imu, kind, transforms};
use dpn_ros2::outgoing::{Level, Status};
use dpn_ros2::{Quality, StaticFrames, TopicId, calibration_of};

/// Waits until the camera is known; none where somebody asked to end before.
pub(super) fn wait(session: &mut Session, camera_info: &str, imu: TopicId) -> Result<Option<Calibration>> {
    let plain = Quality { reliable: false, latched: false, depth: 10 };
    let latched = Quality { reliable: true, latched: true, depth: 100 };
    let info_topic = session.listen(camera_info, kind::CAMERA_INFO, plain, ("camera's calibration", true))?;
    let tf_topic = session.listen("/tf_static", kind::TRANSFORMS, latched, ("camera's place", true))?;
    let mut frames = StaticFrames::default();
    let (mut info, mut imu_frame): (Option<CameraInfo>, Option<String>) = (None, None);
    let mut said = String::new();
    loop {
        let mut bad = None;
        match session.next() {
            Next::Asked => return Ok(None),
            Next::Nothing => {}
            Next::Message(message) => {
                let read = match message.topic {
                    topic if topic == info_topic => {
                        CameraInfo::read(&message.data).map(|read| info = Some(read))
                    }
                    topic if topic == tf_topic => transforms(&message.data).map(|read| frames.take(read)),
                    topic if topic == imu => {
                        Imu::read(&message.data).map(|read| imu_frame = Some(read.frame_id))
                    }
                    _ => Ok(()),
                };
                bad = read.err().map(|error| format!("messages on {} {error}", session.name(message.topic)));
            }
        }
        let missing = match (&info, &imu_frame) {
            (Some(info), Some(imu_frame)) => match frames.between(imu_frame, &info.frame_id) {
                Some(body_from_cam) => match calibration_of(info, body_from_cam) {
                    Ok(calibration) => return Ok(Some(calibration)),
                    Err(error) => Some(format!("{} is of no use: {error}", session.name(info_topic))),
                },
                None => Some(format!(
                    "no transforms on /tf_static lead from the camera's frame `{}` to the IMU's `{}`; --calib names a file that says it",
                    printable(&info.frame_id),
                    printable(imu_frame)
                )),
            },
            _ => None,
        };
        if session.is_due() {
            let words = bad.or(missing).unwrap_or_default();
            if !words.is_empty() && words != said {
                errln!("warning: {words}");
            }
            let message = if words.is_empty() {
                "waits for the camera's calibration".to_owned()
            } else {
                words.clone()
            };
            said = words;
            session.diagnose(Status {
                level: Level::Warn,
                name: "odometry".to_owned(),
                message,
                values: Vec::new(),
            });
        }
    }
}
