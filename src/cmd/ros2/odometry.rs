//! `dpn ros2`: IMU and images in, odometry, transforms, the IMU with covariances and diagnostics out.

use super::calibration;
use super::params::{named, take, truth, unknown};
use super::session::{Next, Session};
use crate::args::Ros2Args;
use crate::cmd::foxglove::onlooker;
use crate::cmd::live::{self, Beside};
use crate::cmd::shipped;
use crate::ui::{Fault, errln, warn};
use anyhow::Result;
use dpn_core::Stamp;
use dpn_core::estimate::NoiseSpec;
use dpn_io::calibration as calibrations;
use dpn_io::config::load_over;
use dpn_live::{Fed, Listener, LiveRun, Seen, Watched, settings_for};
use dpn_logs::SensorEvent;
use dpn_logs::ros::{Encoding, ImageKind, decode_image};
use dpn_ros2::incoming::{Imu, kind};
use dpn_ros2::outgoing::{self, Level, Odometry, Status};
use dpn_ros2::{Message, Param, Publisher, Quality};
use dpn_vio::EstimatorConfig;
use dpn_vio::estimator::Phase;
use std::path::Path;
use std::time::Instant;

/// Samples that wait in DDS: a second and more of the quickest.
const SAMPLES: u16 = 2000;
/// Images that wait in DDS.
const IMAGES: u16 = 10;

const PARAMETERS: &str = "use_sim_time, reliable, odom_frame, publish_tf, image_transport, calib, noise, seed, time_offset, and the estimator's \
                          own (window.pixel_std)";

pub(super) fn run(mut args: Ros2Args) -> Result<()> {
    let (names, params) = named(&args.node)?;
    params.iter().try_for_each(|param| set(&mut args, param))?;
    let mut estimator: EstimatorConfig = load_over(args.config.as_deref(), &sets(&args))?;
    // Whoever fuses poses asks how sure they are.
    estimator.covariance = true;
    let noise: NoiseSpec = args.noise.parse()?;
    warn(settings_for(&estimator, &noise).warnings());
    let networks = shipped::or_of(args.models.as_deref())?;
    let given = args.calib.as_deref().map(calibrations::read).transpose()?;

    let mut session = Session::new(names, &args.node)?;
    let reliable = args.node.reliable;
    let quality = |depth| Quality { reliable, latched: false, depth };
    let imu = session.listen(&args.node.imu, kind::IMU, quality(SAMPLES), ("IMU", false))?;
    let (image_kind, image_name) = match args.compressed {
        true => (ImageKind::Compressed, format!("{}/compressed", args.image)),
        false => (ImageKind::Raw, args.image.clone()),
    };
    let of_images = if args.compressed { kind::COMPRESSED_IMAGE } else { kind::IMAGE };
    let images = session.listen(&image_name, of_images, quality(IMAGES), ("images", false))?;
    let again = session.send("imu/with_covariance", outgoing::kind::IMU)?;
    let sender = Sender {
        odometry: session.send("odometry", outgoing::kind::ODOMETRY)?,
        tf: (!args.no_tf).then(|| session.send("/tf", outgoing::kind::TRANSFORMS)).transpose()?,
        world: args.odom_frame.clone(),
        body: "imu".to_owned(),
        state: "waits for the first images".to_owned(),
        scale_std: None,
        last_warning: None,
    };
    let calibration = match given {
        Some(calibration) => calibration,
        None => match calibration::wait(&mut session, &args.camera_info, imu)? {
            Some(calibration) => calibration,
            None => return Ok(()),
        },
    };
    errln!("calibration: {calibration}");
    let run = LiveRun::new(&estimator, noise, networks, &calibration.camera, Fed::Images, args.seed)?;
    let mut watched = Watched::new(run, &calibration, Beside::new(sender, onlooker(args.view)?));
    let size = calibration.camera.resolution.map(|side| side as usize);
    let ends = loop {
        match session.next() {
            Next::Asked => break Ok(()),
            Next::Nothing => watched.silences((!session.is_simulated()).then(Instant::now)),
            Next::Message(message) => {
                let place = session.name(message.topic);
                let taken = if message.topic == imu {
                    sample(&mut watched, &again, &message, place)
                } else if message.topic == images {
                    live::take(&mut watched, image(&message, image_kind, place, size), message.came)
                } else {
                    Ok(())
                };
                if let Err(error) = taken {
                    break Err(error);
                }
            }
        }
        if session.is_due() {
            session.diagnose(status(&watched));
        }
    };
    let lost = session.lost();
    if lost > 0 {
        errln!("{lost} messages never came, or came quicker than they were worked off");
    }
    watched.end()?;
    watched.listener.own.odometry.settle();
    ends.and_then(|()| live::finish(watched, false))
}

/// Keys of the estimator, as typed.
fn sets(args: &Ros2Args) -> Vec<(String, String)> {
    let offset =
        args.time_offset.map(|seconds| ("front_end.time_offset_s".to_owned(), format!("{seconds:?}")));
    args.sets.iter().cloned().chain(offset).collect()
}

/// Takes a parameter over what was typed as a flag.
fn set(args: &mut Ros2Args, param: &Param) -> Result<()> {
    if take(&mut args.node, param)? {
        return Ok(());
    }
    let bad = || Fault::new(format!("parameter {}: `{}` is no number", param.name, param.value));
    match param.name.as_str() {
        "odom_frame" => args.odom_frame.clone_from(&param.value),
        "publish_tf" => args.no_tf = !truth(param)?,
        "image_transport" => match param.value.as_str() {
            "raw" => args.compressed = false,
            "compressed" => args.compressed = true,
            other => {
                return Err(Fault::new(format!(
                    "parameter image_transport: `{other}` is neither raw nor compressed"
                ))
                .into());
            }
        },
        // Empty is what a launch file says of a file that there is not.
        "calib" => args.calib = (!param.value.is_empty()).then(|| param.value.clone().into()),
        "noise" => args.noise.clone_from(&param.value),
        "seed" => args.seed = param.value.parse().map_err(|_| bad())?,
        "time_offset" => args.time_offset = Some(param.value.parse().map_err(|_| bad())?),
        name if name.contains('.') => args.sets.push((name.to_owned(), param.value.clone())),
        _ => return Err(unknown(param, PARAMETERS).into()),
    }
    Ok(())
}

/// Hands a sample on at once, with the noise that is in force, and to the odometry.
fn sample(
    watched: &mut Watched<'_, Beside<Sender>>,
    again: &Publisher,
    message: &Message,
    place: &str,
) -> Result<()> {
    let imu = match Imu::read(&message.data) {
        Ok(imu) if imu.t == Stamp::from_ns(0) => {
            watched.pass_over(&format!("a message on {place} without a stamp"));
            return Ok(());
        }
        Ok(imu) => imu,
        Err(error) => {
            watched.pass_over(&format!("a message on {place}: such messages {error}"));
            return Ok(());
        }
    };
    if let Some(noise) = watched.run().noise_in_force() {
        again.send(outgoing::imu(&imu, &noise));
    }
    if !imu.frame_id.is_empty() {
        watched.listener.own.body.clone_from(&imu.frame_id);
    }
    watched.take_sample(imu.sample(), message.came)
}

fn image(message: &Message, kind: ImageKind, place: &str, size: [usize; 2]) -> SensorEvent {
    match decode_image(&message.data, Encoding::Cdr, kind) {
        Ok(image) if image.t_ns == 0 => {
            SensorEvent::PassedOver(format!("a message on {place} without a stamp"))
        }
        Ok(image) => SensorEvent::Image(Stamp::from_ns(image.t_ns), image.grey(Path::new(place), size)),
        Err(error) => SensorEvent::PassedOver(format!("a message on {place}: such messages {error}")),
    }
}

/// Sends what the odometry says.
struct Sender {
    odometry: Publisher,
    tf: Option<Publisher>,
    world: String,
    body: String,
    /// What it does, in words.
    state: String,
    scale_std: Option<f64>,
    last_warning: Option<String>,
}

impl Listener for Sender {
    type Error = anyhow::Error;

    fn update(&mut self, Seen { t, update, .. }: &Seen<'_>) -> Result<()> {
        self.state = match &update.phase {
            Phase::Initialising(reason) => format!("initialising: {reason}"),
            Phase::Restarted(reason) => format!("begins again: {reason}"),
            Phase::Tracking => "tracking".to_owned(),
        };
        self.scale_std = update.scale_std;
        let Some(state) = &update.state else { return Ok(()) };
        self.odometry.send(outgoing::odometry(&Odometry {
            t: *t,
            world: &self.world,
            body: &self.body,
            world_from_body: state.world_from_body,
            covariance: update.covariance.as_deref().copied(),
            vel_in_world: state.vel_in_world,
        }));
        if let Some(tf) = &self.tf {
            tf.send(outgoing::transform(*t, &self.world, &self.body, &state.world_from_body));
        }
        Ok(())
    }

    fn say(&mut self, words: &str) {
        errln!("{words}");
        if let Some(warning) = words.strip_prefix("warning: ") {
            self.last_warning = Some(warning.to_owned());
        }
    }

    fn gives_up(&self) -> bool {
        false
    }
}

/// How the odometry is.
fn status(watched: &Watched<'_, Beside<Sender>>) -> Status {
    let doubts: Vec<String> = watched.run().doubts().iter().map(ToString::to_string).collect();
    let Sender { state, scale_std, last_warning, .. } = &watched.listener.own;
    let is_tracking = state == "tracking";
    let level = if is_tracking && doubts.is_empty() { Level::Ok } else { Level::Warn };
    let mut values = Vec::new();
    let mut value = |key: &str, value: String| values.push((key.to_owned(), value));
    value("frames", watched.totals().frames.to_string());
    value("poses", watched.totals().poses.to_string());
    value("restarts", watched.totals().restarts.to_string());
    value("messages passed over", watched.passed_over().to_string());
    if let Some(levels) = watched.run().levels() {
        let names =
            ["accel x", "accel y", "accel z", "gyro x", "gyro y", "gyro z", "accel walk", "gyro walk"];
        for (name, level) in names.iter().zip(levels.inertial.0) {
            value(&format!("level {name}"), format!("{level:.3}"));
        }
        value("level pixel", format!("{:.3}", levels.pixel));
    }
    if let Some(std) = scale_std {
        value("scale, relative deviation", format!("{std:.4}"));
    }
    if let Some([median, most]) = watched.listener.latency_ms() {
        value("image to pose, median [ms]", format!("{median:.1}"));
        value("image to pose, 99 % [ms]", format!("{most:.1}"));
    }
    let clock = &watched.run().report().clock;
    if clock.found.is_some() {
        value("camera clock ahead [ms]", format!("{:.2}", -1e3 * clock.offset_s));
    }
    if let Some(warning) = last_warning {
        value("last warning", warning.clone());
    }
    let message = if doubts.is_empty() {
        state.clone()
    } else {
        format!("{state}; not to be trusted: {}", doubts.join("; "))
    };
    Status { level, name: "odometry".to_owned(), message, values }
}
