//! Renders a sequence, follows points through the images, and writes the tracks: the same for every noise, so that one file serves many
//! runs of the odometry (`dpn eval --closed-loop --tracks DIR`).
//!
//! `cargo run --release -p dpn-vio --example rendered_tracks -- SEQUENCE OUT.txt [SEED]`
#![allow(clippy::unwrap_used)]

use dpn_core::random::Stream;
use dpn_io::asl::Sequence;
use dpn_io::write_tracks;
use dpn_sim::RenderedCamera;
use dpn_sim::render::RenderConfig;
use dpn_sim::tracks::{CameraSettings, PathConfig, RecordedPath, summarise};
use dpn_vio::frontend::{FrontEnd, FrontEndConfig, GyroTurn, turn_of_camera};
use nalgebra::Vector3;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let sequence = Sequence::open(Path::new(&args[1])).unwrap();
    let seed = args.get(3).map_or(0, |seed| seed.parse().unwrap());
    let path = RecordedPath::new(&sequence.ground_truth().unwrap(), &PathConfig::default()).unwrap();
    let own = sequence.camera_config().unwrap().unwrap();
    let config =
        RenderConfig { camera: Some(CameraSettings::try_from(&own).unwrap()), ..RenderConfig::default() };
    let mut camera = RenderedCamera::new(&config, Arc::new(path), seed).unwrap();
    let imu = sequence.imu().unwrap();
    let stream = Stream::new(seed).named(sequence.name());
    let mut front_end = FrontEnd::new(*camera.model(), FrontEndConfig::default(), &stream).unwrap();
    let (mut gyro, mut samples) = (GyroTurn::new(), imu.samples().iter());
    let mut fed_to = None;
    let (mut frames, mut images, mut asked, mut agreed) = (Vec::new(), 0, 0, 0);
    let mut front_end_time = Duration::ZERO;
    for frame in sequence.camera_frames().unwrap() {
        let Some(image) = camera.image(frame.t) else { continue };
        while fed_to.is_none_or(|t| t < frame.t) {
            let Some(sample) = samples.next() else { break };
            gyro.feed(sample);
            fed_to = Some(sample.t);
        }
        let turn = gyro.until(frame.t, &Vector3::zeros());
        let turn = turn.map(|turn| turn_of_camera(&turn, &own.body_from_cam.rotation));
        let fed = front_end.feed(image.view(), frame.t, turn.as_ref());
        front_end_time += fed.report.times.total();
        if let Some(agreement) = fed.report.agreement {
            (asked, agreed) = (asked + agreement.asked, agreed + agreement.agreed);
        }
        images += 1;
        frames.extend(fed.frame);
    }
    write_tracks(Path::new(&args[2]), &frames).unwrap();
    let summary = summarise(&frames);
    println!(
        "{}: {images} images, {} frames, {:.1} tracks in one, each in {:.1}; {:.2} % of those asked agreed; front-end {:.1} ms an image",
        sequence.name(),
        summary.frames,
        summary.mean_in_frame,
        summary.mean_life,
        100.0 * agreed as f64 / asked.max(1) as f64,
        1e3 * front_end_time.as_secs_f64() / f64::from(images.max(1))
    );
}
