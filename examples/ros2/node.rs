//! A ROS 2 node around the odometry: `imu` and `image_raw` in, `odometry` (a pose) out.
//!
//! NOT BUILT HERE: it needs a ROS 2 installation, rclrs (0.5) and the messages of its workspace. What it calls of dpn is built and tested by
//! `src/vio/examples/live.rs`; `dpn run -` does the same from a bag in a pipe. In a colcon workspace, Cargo.toml:
//! `rclrs = "0.5"`, `sensor_msgs = "*"`, `geometry_msgs = "*"`, `dpn-core` (package `dpn-imu-core`), `dpn-io` and `dpn-vio` by path.

use dpn_core::camera::CameraModel;
use dpn_core::{GrayView, ImuNoise, ImuSample, Stamp};
use dpn_io::asl::read_camera_config;
use dpn_vio::preint::NoisySample;
use dpn_vio::{Estimator, EstimatorConfig};
use geometry_msgs::msg::PoseStamped;
use rclrs::{Context, CreateBasicExecutor, IntoPrimitiveOptions, SpinOptions};
use sensor_msgs::msg::{Image, Imu};
use std::sync::{Arc, Mutex};

fn stamp(t: &builtin_interfaces::msg::Time) -> Stamp {
    Stamp::from_ns(i64::from(t.sec) * 1_000_000_000 + i64::from(t.nanosec))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let calibration = read_camera_config(std::path::Path::new(&std::env::args().nth(1).ok_or("sensor.yaml?")?))?;
    let camera = CameraModel::try_from(&calibration)?;
    let estimator = Estimator::new(EstimatorConfig::default(), camera, calibration.body_from_cam, 0)
        .map_err(|faults| format!("{faults:?}"))?;
    let estimator = Arc::new(Mutex::new(estimator));

    let mut executor = Context::default_from_env()?.create_basic_executor();
    let node = executor.create_node("dpn")?;
    let publisher = node.create_publisher::<PoseStamped>("odometry")?;

    let fed = Arc::clone(&estimator);
    let _imu = node.create_subscription("imu".sensor_data_qos(), move |msg: Imu| {
        let (w, a) = (&msg.angular_velocity, &msg.linear_acceleration);
        let sample = ImuSample { t: stamp(&msg.header.stamp), gyro: [w.x, w.y, w.z], accel: [a.x, a.y, a.z] };
        // The noise in force: a constant here; a `NoiseModel` such as dpn-pronet's DualProNet says it sample by sample.
        let noise = ImuNoise::baseline();
        let mut estimator = fed.lock().expect("no callback panics");
        // A sample that is refused (out of order, a spike) is passed over; the next one may be taken.
        let _ = estimator.feed_imu(NoisySample { sample, noise });
        while let Some(update) = estimator.next_update() {
            let Some(state) = update.state else { continue };
            let (p, q) = (state.world_from_body.translation.vector, state.world_from_body.rotation.coords);
            let mut pose = PoseStamped { header: msg.header.clone(), ..PoseStamped::default() };
            pose.header.frame_id = "world".into();
            (pose.pose.position.x, pose.pose.position.y, pose.pose.position.z) = (p.x, p.y, p.z);
            let to = &mut pose.pose.orientation;
            (to.x, to.y, to.z, to.w) = (q.x, q.y, q.z, q.w);
            let _ = publisher.publish(pose);
        }
    })?;
    let _camera = node.create_subscription("image_raw".sensor_data_qos(), move |msg: Image| {
        // mono8; other encodings: `dpn_io::PixelLayout::of_ros`.
        let view = GrayView::new(msg.width as usize, msg.height as usize, msg.step as usize, &msg.data);
        if let Ok(view) = view {
            let _ = estimator.lock().expect("no callback panics").feed_image(view, stamp(&msg.header.stamp));
        }
    })?;
    executor.spin(SpinOptions::default()).first_error()?;
    Ok(())
}
