//! One way for an image: who feeds the estimator live, who feeds it in batches, `dpn run` and a sweep get the same trajectory, byte by byte.

use crate::run::{dpn, end};
use dpn_core::camera::{CameraConfig, CameraModel};
use dpn_core::estimate::NoiseSpec;
use dpn_core::random::Stream;
use dpn_core::trajectory::StampedPose;
use dpn_eval::noise::{Fresh, Recorded, track};
use dpn_io::asl::Sequence;
use dpn_io::{ImageFolder, StampedImage, write_tum};
use dpn_vio::preint::NoisySample;
use dpn_vio::{Estimator, EstimatorConfig};
use std::path::Path;

const SEED: u64 = 3;
/// Another one at every sample.
const NOISE: &str = "sg(11,2)";

/// What the two sensors of a recording say, and the noise of each sample.
struct Sensors {
    camera: CameraModel,
    calibration: CameraConfig,
    samples: Vec<NoisySample>,
    images: Vec<StampedImage>,
}

impl Sensors {
    fn of(dir: &Path) -> Self {
        let sequence = Sequence::open(dir).unwrap();
        let calibration = sequence.camera_config().unwrap().unwrap();
        let imu = sequence.imu().unwrap();
        let noise: NoiseSpec = NOISE.parse().unwrap();
        let recorded = Recorded { name: sequence.name(), imu: &imu, oracle: None };
        let stream = Stream::new(SEED).named("noise");
        let noises = track(&noise, &imu, &Fresh { recorded, networks: &[] }, &stream).unwrap();
        let samples = imu.samples().iter().zip(noises.noises());
        let images = ImageFolder::open(&sequence).unwrap();
        Self {
            camera: CameraModel::try_from(&calibration).unwrap(),
            samples: samples.map(|(sample, noise)| NoisySample { sample: *sample, noise: *noise }).collect(),
            images: (0..images.len()).map(|i| images.read(i).unwrap()).collect(),

            calibration,
        }
    }

    fn run(&self) -> Run {
        let body_from_cam = self.calibration.body_from_cam;
        let config = EstimatorConfig::default();
        Run {
            estimator: Estimator::new(config, self.camera, body_from_cam, SEED).unwrap(),
            poses: Vec::new(),
        }
    }

    /// Images come `late` seconds after they were taken, samples `burst` at a time, as their drivers please.
    fn live(&self, late: f64, burst: usize) -> Vec<StampedPose> {
        let (mut run, mut images) = (self.run(), self.images.iter().peekable());
        for samples in self.samples.chunks(burst) {
            for sample in samples {
                run.estimator.feed_imu(*sample).unwrap();
            }
            let now = samples[samples.len() - 1].sample.t;
            while let Some(image) = images.next_if(|image| now.seconds_since(image.t) >= late) {
                run.image(image);
            }
            run.take();
        }
        images.for_each(|image| run.image(image));
        run.poses
    }

    /// Thirty images, then all samples that reach them.
    fn images_first(&self) -> Vec<StampedPose> {
        let (mut run, mut samples) = (self.run(), self.samples.iter().peekable());
        for images in self.images.chunks(30) {
            for image in images {
                run.image(image);
            }
            let last = images[images.len() - 1].t;
            while let Some(sample) = samples.next_if(|sample| sample.sample.t < last.plus_seconds(0.006)) {
                run.estimator.feed_imu(*sample).unwrap();
            }
        }
        run.take();
        run.poses
    }
}

struct Run {
    estimator: Estimator,
    poses: Vec<StampedPose>,
}

impl Run {
    fn image(&mut self, image: &StampedImage) {
        self.estimator.feed_image(image.image.view(), image.t).unwrap();
        self.take();
    }

    fn take(&mut self) {
        while let Some(update) = self.estimator.next_update() {
            let pose = |state: dpn_vio::NavState| StampedPose {
                t: update.t,
                world_from_body: state.world_from_body,
            };
            self.poses.extend(update.state.map(pose));
        }
    }
}

#[test]
fn live_in_batches_by_run_and_in_a_sweep_the_same_trajectory_comes_out() {
    let tmp = tempfile::tempdir().unwrap();
    let data = tmp.path().join("data");
    let dir = data.join("flown");
    let camera = tmp.path().join("camera.toml");
    let text = "[camera]\nresolution = [376, 240]\nintrinsics = [229.3, 228.6, 183.4, 123.9]\n";
    std::fs::write(&camera, text).unwrap();
    let mut command = dpn();
    command.args(["simulate", "images", "room-medium", "--from", "12", "--to", "18", "--config"]);
    end(command.arg(&camera).arg("--out").arg(&dir)).well();

    let (out, seed) = (tmp.path().join("run"), SEED.to_string());
    let common = ["--noise", NOISE, "--seed", &seed, "--camera", "images", "--out"];
    end(dpn().arg("run").arg(&dir).args(common).arg(&out)).well();
    let expected = std::fs::read(out.join("trajectory.tum")).unwrap();
    let poses = expected.iter().filter(|byte| **byte == b'\n').count();
    assert!(poses > 25, "{poses} poses");

    let swept = tmp.path().join("sweep");
    let mut command = dpn();
    command.args(["eval", "--closed-loop", "--trajectories", "--data"]).arg(&data).args(common).arg(&swept);
    end(&mut command).well();
    let swept = std::fs::read_dir(swept.join("trajectories")).unwrap().next().unwrap().unwrap().path();
    assert!(std::fs::read(swept).unwrap() == expected, "a sweep's trajectory is another");

    let sensors = Sensors::of(&dir);
    let ways = [
        ("as they were taken", sensors.live(0.0, 1)),
        ("images 35 ms late, samples three at a time", sensors.live(0.035, 3)),
        ("images half a second late", sensors.live(0.5, 1)),
        ("all samples, then all images", sensors.live(1e6, 1_000_000)),
        ("images before their samples", sensors.images_first()),
    ];
    for (way, poses) in ways {
        let path = tmp.path().join("live.tum");
        write_tum(&path, &poses).unwrap();
        assert!(std::fs::read(&path).unwrap() == expected, "{way}: {} poses", poses.len());
    }
}
