//! The odometry as a program with a camera and an IMU uses it: feed what comes, take what there is.
//!
//! `cargo run --release -p dpn-vio --example live -- data/images/V1_01_easy_static` plays a folder as if its sensors were live. Its poses are
//! those of `dpn run` on that folder, bit by bit: chance is a function of the seed and of the recording's name.

use dpn_core::ImuNoise;
use dpn_core::camera::CameraModel;
use dpn_io::ImageFolder;
use dpn_io::asl::Sequence;
use dpn_vio::preint::NoisySample;
use dpn_vio::{Estimator, EstimatorConfig};
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let dir: PathBuf = std::env::args_os().nth(1).ok_or("name the folder of an ASL sequence")?.into();
    let sequence = Sequence::open(&dir)?;
    let calibration = sequence.camera_config()?.ok_or("no cam0/sensor.yaml")?;
    let camera = CameraModel::try_from(&calibration)?;
    let (config, body_from_cam) = (EstimatorConfig::default(), calibration.body_from_cam);
    let mut estimator =
        Estimator::new(config, camera, body_from_cam, 0).map_err(|faults| format!("{faults:?}"))?;

    let imu = sequence.imu()?;
    let mut images = ImageFolder::open(&sequence)?.prefetch(2).peekable();
    for sample in imu.samples() {
        // Live these calls come from two drivers, in whatever order.
        estimator.feed_imu(NoisySample { sample: *sample, noise: ImuNoise::baseline() })?;
        let due = |t| sample.t.seconds_since(t) >= 0.01;
        while let Some(image) = images.next_if(|image| image.as_ref().map_or(true, |image| due(image.t))) {
            let image = image?;
            estimator.feed_image(image.image.view(), image.t)?;
        }
        while let Some(update) = estimator.next_update() {
            let Some(state) = update.state else {
                println!("{} {:?}", update.t, update.phase);
                continue;
            };
            println!("{} {:.3}", update.t, state.world_from_body.translation.vector.transpose());
        }
    }
    Ok(())
}
