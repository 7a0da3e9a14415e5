//! `dpn run -`: the odometry beside running sensors, poses out as they are made.

use super::{settings, shipped};
use crate::args::{CameraArg, RunArgs};
use crate::ui::{Fault, errln, outln, warn};
use anyhow::Result;
use dpn_core::Stamp;
use dpn_core::camera::CameraModel;
use dpn_core::trajectory::StampedPose;
use dpn_eval::closed_loop::{ClosedLoopError, LiveRun, settings_for};
use dpn_io::calibration::Calibration;
use dpn_io::{printable, tum_line};
use dpn_logs::{SensorEvent, read_sensors};
use dpn_vio::estimator::{FeedError, Phase, Update};
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;

/// So many messages that were passed over are said.
const SHOWN: usize = 8;

/// Whether `source` is to be read as it comes: stdin, or a pipe.
pub(super) fn is_live(source: &str) -> bool {
    let path = Path::new(source);
    source == "-" || path.metadata().is_ok_and(|meta| !meta.is_file() && !meta.is_dir())
}

/// Reads the bag until it ends; a pose is a line on stdout as soon as there is one, everything else goes to stderr.
pub(super) fn run(args: &RunArgs) -> Result<()> {
    let of_recordings = [
        ("--tracks", args.tracks.is_some()),
        ("--truth", args.truth.is_some()),
        ("--to", args.to.is_some()),
        ("--out", args.out.is_some()),
        ("--draw", args.draw.is_some()),
        ("--kitti", args.kitti),
        ("--mcap", args.mcap.is_some()),
        ("--rerun", args.rerun.is_some()),
        ("--rpe", !args.rpe.is_empty()),
        ("--strict", args.strict),
        ("--camera tracks or rendered", args.camera.is_some_and(|camera| camera != CameraArg::Images)),
    ];
    if let Some((flag, _)) = of_recordings.iter().find(|(_, given)| *given) {
        return Err(Fault::new(format!("{flag} is for recordings; `{}` is read as it comes", args.source))
            .hint("leave it away, or record first and run on the file")
            .into());
    }
    let calibration = settings::calibration(&args.settings)?.ok_or_else(|| {
        Fault::new(format!("`{}`: nobody knows what camera it comes from", args.source))
            .hint("name its calibration: --calib cam0/sensor.yaml")
    })?;
    errln!("calibration: {calibration}");
    let config = &calibration.camera;
    let camera = CameraModel::try_from(config)
        .map_err(|source| ClosedLoopError::Camera { sequence: "live".to_owned(), source })?;
    let networks = shipped::or_of(args.models.as_deref())?;
    let estimator = super::run::estimator(args)?;
    let camera = (camera, config.body_from_cam);
    let noise = args.noise.parse()?;
    warn(settings_for(&estimator, &noise).warnings());
    let run = LiveRun::new(&estimator, noise, &networks, camera, args.seed)?;
    let mut live = Live {
        run,
        calibration: &calibration,
        json: args.json,
        started: false,
        clock_said: false,
        restarts: 0,
        poses: 0,
        frames: 0,
        passed_over: 0,
        waited_for: BTreeMap::new(),
    };
    let mut fault = None;
    let size = config.resolution.map(|side| side as usize);
    let options = super::run::image_log(args);
    let read = read_sensors(Path::new(&args.source), &options, size, &mut |event| match live.take(event) {
        Ok(()) => ControlFlow::Continue(()),
        Err(error) => {
            fault = Some(error);
            ControlFlow::Break(())
        }
    });
    if let Some(fault) = fault {
        return Err(fault);
    }
    let damage = read?;
    live.run.end()?;
    live.updates()?;
    live.run.look_back();
    live.warnings();
    if let Some(damage) = damage {
        errln!("warning: {}: {damage}; what came before was used", printable(&args.source));
    }
    let Live { poses, frames, restarts, passed_over, waited_for, .. } = live;
    errln!("{poses} poses of {frames} frames, {restarts} restarts, {passed_over} messages passed over");
    if poses == 0 {
        errln!("warning: {}", super::run::no_pose(frames, &waited_for));
    }
    Ok(())
}

struct Live<'a> {
    run: LiveRun<'a>,
    calibration: &'a Calibration,
    json: bool,
    started: bool,
    clock_said: bool,
    restarts: usize,
    poses: usize,
    frames: usize,
    passed_over: usize,
    /// What frames waited for that could not be initialised with, and how many.
    waited_for: BTreeMap<String, usize>,
}

impl Live<'_> {
    fn take(&mut self, event: SensorEvent) -> Result<()> {
        let taken = match event {
            SensorEvent::Sample(sample) => self.run.feed_sample(sample),
            SensorEvent::Image(t, Ok(image)) => self.run.feed_image(self.calibration.on_imu_clock(t), &image),
            SensorEvent::Image(_, Err(error)) => Err(error.into()),
            SensorEvent::PassedOver(why) => {
                self.pass_over(&why);
                Ok(())
            }
        };
        match taken {
            Err(error @ ClosedLoopError::Feed { source: FeedError::ImuBehind { .. }, .. }) => {
                return Err(error.into());
            }
            Err(error @ (ClosedLoopError::Feed { .. } | ClosedLoopError::Io(_))) => {
                // A camera whose images are all alike unreadable is no camera.
                if self.frames == 0 && self.passed_over >= SHOWN && matches!(error, ClosedLoopError::Io(_)) {
                    return Err(error.into());
                }
                self.pass_over(&error.in_full());
            }
            other => other?,
        }
        self.updates()
    }

    fn pass_over(&mut self, why: &str) {
        self.passed_over += 1;
        if self.passed_over <= SHOWN {
            errln!("warning: {}; passed over", printable(why));
        }
    }

    fn updates(&mut self) -> Result<()> {
        while let Some(update) = self.run.next_update() {
            self.warnings();
            self.frames += 1;
            let clock = self.run.report().clock;
            if clock.found.is_some() && !std::mem::replace(&mut self.clock_said, clock.found.is_some()) {
                errln!(
                    "note: the camera's clock is {:+.1} ms off the gyroscope's; `--time-offset {:.4}` takes it off from the start",
                    -1e3 * clock.offset_s,
                    clock.offset_s
                );
            }
            self.say(&update);
            let Some(state) = update.state else { continue };
            self.poses += 1;
            let pose = StampedPose { t: update.t, world_from_body: state.world_from_body };
            if self.json {
                outln!("{}", json(&pose))?;
            } else {
                outln!("{}", tum_line(&pose))?;
            }
        }
        Ok(())
    }

    fn warnings(&mut self) {
        while let Some(warning) = self.run.take_warning() {
            errln!("warning: {warning}");
        }
    }

    fn say(&mut self, update: &Update) {
        match &update.phase {
            Phase::Initialising(reason) => {
                *self.waited_for.entry(reason.name().to_owned()).or_default() += 1;
            }
            Phase::Restarted(reason) => {
                self.restarts += 1;
                errln!("warning: {}: {reason}; initialising again", update.t);
            }
            _ if update.state.is_some() && !self.started => {
                self.started = true;
                errln!("note: initialised at {}, frame {}", update.t, self.frames);
            }
            _ => {}
        }
    }
}

fn json(pose: &StampedPose) -> serde_json::Value {
    let (p, q, t): (_, _, Stamp) =
        (pose.world_from_body.translation.vector, pose.world_from_body.rotation.coords, pose.t);
    serde_json::json!({ "t_ns": t.ns(), "position": [p.x, p.y, p.z], "quaternion_wxyz": [q.w, q.x, q.y, q.z] })
}
