//! `dpn run -`: the odometry beside running sensors, poses out as they are made.

use super::foxglove::{Onlooker, onlooker};
use super::latency::Latency;
use super::{settings, shipped, stop};
use crate::args::RunArgs;
use crate::ui::{Fault, Untrusted, errln, is_closed_pipe, outln, warn};
use anyhow::Result;
use dpn_core::Stamp;
use dpn_core::trajectory::StampedPose;
use dpn_eval::closed_loop::{Camera, StartAt};
use dpn_io::{printable, tum_line};
use dpn_live::{Fed, Listener, LiveRun, Seen, Totals, Watched, settings_for};
use dpn_logs::{LogError, SensorEvent, read_sensors};
use dpn_vio::estimator::FrontEndObserver;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Messages that wait.
const QUEUE: usize = 64;
/// How often this looks for silence and for a wish to end.
const LOOK: Duration = Duration::from_millis(200);

/// Whether `source` is to be read as it comes: stdin, or a pipe.
pub(super) fn is_live(source: &str) -> bool {
    let path = Path::new(source);
    source == "-" || path.metadata().is_ok_and(|meta| !meta.is_file() && !meta.is_dir())
}

/// Reads the bag until it ends; a pose is a line on stdout as soon as there is one, everything else goes to stderr.
pub(super) fn run(args: &RunArgs) -> Result<()> {
    refuse_flags_of_recordings(args)?;
    let calibration = settings::calibration(&args.settings)?.ok_or_else(|| {
        Fault::new(format!("`{}`: nobody knows what camera it comes from", args.source))
            .hint("name its calibration: --calib cam0/sensor.yaml")
    })?;
    errln!("calibration: {calibration}");
    let config = &calibration.camera;
    let networks = shipped::or_of(args.models.as_deref())?;
    let estimator = super::run::estimator(args)?;
    let noise = args.noise.parse()?;
    warn(settings_for(&estimator, &noise).warnings());
    let run = LiveRun::new(&estimator, noise, networks, config, Fed::Images, args.seed)?;
    let lines = Beside::new(Lines { json: args.json }, onlooker(args.view)?);
    let mut live = Watched::new(run, &calibration, lines);
    let read = match follow(&mut live, args, config.resolution.map(|side| side as usize)) {
        // Nobody takes poses any more; what is to be said is said on stderr.
        Err(error) if is_closed_pipe(&error) => Ok(None),
        read => read,
    };
    let ended = live.end();
    let damage = read?;
    match ended {
        Err(error) if is_closed_pipe(&error) => {}
        ended => ended?,
    }
    if let Some(damage) = damage {
        errln!("warning: {}: {damage}; what came before was used", printable(&args.source));
    }
    finish(live, args.strict)
}

/// Flags that say nothing of what is read as it comes.
fn refuse_flags_of_recordings(args: &RunArgs) -> Result<()> {
    let RunArgs { settings, log, paste, .. } = args;
    let how = &log.imu;
    let all = [
        ("--tracks", args.tracks.is_some()),
        ("--truth", args.truth.is_some()),
        ("--from", args.from != StartAt::default()),
        ("--to", args.to.is_some()),
        ("--skip-missing", args.skip_missing),
        ("--draw", args.draw.is_some()),
        ("--mcap", args.mcap.is_some()),
        ("--rerun", args.rerun.is_some()),
        ("--camera tracks or rendered", args.camera.is_some_and(|camera| camera != Camera::Images)),
        ("--columns", how.columns.is_some()),
        ("--time-unit", how.time_unit.is_some()),
        ("--rate", how.rate.is_some()),
        ("--tracks-config", settings.tracks_config.is_some()),
        ("--images-config", settings.images_config.is_some()),
        ("--flight-config", settings.flight_config.is_some()),
        ("--no-vibration", settings.no_vibration),
        ("--paste", !paste.paste.0.is_empty()),
        ("--walks", paste.walks),
        ("--out", args.out.is_some()),
    ];
    let Some((flag, _)) = all.into_iter().find(|(_, given)| *given) else { return Ok(()) };
    Err(Fault::new(format!("{flag} is for recordings; `{}` is read as it comes", args.source))
        .hint("leave it away, or record first and run on the file")
        .into())
}

/// A line a pose.
struct Lines {
    json: bool,
}

impl Listener for Lines {
    type Error = anyhow::Error;

    fn update(&mut self, Seen { t, update, .. }: &Seen<'_>) -> Result<()> {
        let Some(state) = update.state else { return Ok(()) };
        let pose = StampedPose { t: *t, world_from_body: state.world_from_body };
        if self.json {
            outln!("{}", json(&pose))?;
        } else {
            outln!("{}", tum_line(&pose))?;
        }
        Ok(())
    }

    fn say(&mut self, words: &str) {
        errln!("{words}");
    }

    fn gives_up(&self) -> bool {
        true
    }
}

/// A listener, how long each pose took, and whoever looks on.
pub(super) struct Beside<L> {
    pub(super) own: L,
    /// From an image's arrival to its pose.
    latency: Latency,
    view: Option<Box<dyn Onlooker>>,
}

impl<L> Beside<L> {
    pub(super) fn new(own: L, view: Option<Box<dyn Onlooker>>) -> Self {
        Self { own, latency: Latency::default(), view }
    }

    /// From an image's arrival to its pose: median and what 99 % do not go beyond \[ms\].
    pub(super) fn latency_ms(&self) -> Option<[f64; 2]> {
        Some([self.latency.quantile_ms(0.5)?, self.latency.quantile_ms(0.99)?])
    }
}

impl<L: Listener<Error = anyhow::Error>> Listener for Beside<L> {
    type Error = anyhow::Error;

    fn update(&mut self, seen: &Seen<'_>) -> Result<()> {
        self.own.update(seen)?;
        let image = seen.image.map(|(fed, came)| (fed, came.elapsed().as_secs_f64()));
        if let (Some((_, latency_s)), true) = (image, seen.update.state.is_some()) {
            self.latency.add(latency_s);
        }
        if let Some(view) = &mut self.view {
            view.show((seen.t, seen.update), seen.noise, image);
        }
        Ok(())
    }

    fn observer(&mut self) -> Option<&mut dyn FrontEndObserver> {
        let view: &mut dyn Onlooker = &mut **self.view.as_mut()?;
        Some(view)
    }

    fn say(&mut self, words: &str) {
        self.own.say(words);
    }

    fn gives_up(&self) -> bool {
        self.own.gives_up()
    }
}

/// Takes what the sensors say until they end, or this is asked to; what was wrong where they ended early.
fn follow(live: &mut Watched<'_, Beside<Lines>>, args: &RunArgs, size: [usize; 2]) -> Result<Option<String>> {
    let stop = stop::on_any_end()?;
    let (events, reader) = reader(args, size);
    while !stop.load(Ordering::Relaxed) {
        match events.recv_timeout(LOOK) {
            Ok((event, came)) => take(live, event, came)?,
            Err(RecvTimeoutError::Timeout) => live.silences(Some(Instant::now())),
            Err(RecvTimeoutError::Disconnected) => {
                return Ok(reader.join().expect("a reader does not panic, whatever the bytes")?);
            }
        }
    }
    Ok(None)
}

/// Messages, each with when it was read, and what was wrong where they ended early.
type Reader = (Receiver<(SensorEvent, Instant)>, JoinHandle<Result<Option<String>, LogError>>);

/// Reads the sensors on a thread of its own, so that silence is noticed.
fn reader(args: &RunArgs, size: [usize; 2]) -> Reader {
    let (sender, events) = sync_channel(QUEUE);
    let (source, options) = (PathBuf::from(&args.source), super::run::image_log(args));
    let read = move || {
        read_sensors(&source, &options, size, &mut |event| match sender.send((event, Instant::now())) {
            Ok(()) => ControlFlow::Continue(()),
            Err(_) => ControlFlow::Break(()),
        })
    };
    (events, std::thread::spawn(read))
}

/// Hands on what a sensor said.
pub(super) fn take<L: Listener<Error = anyhow::Error>>(
    live: &mut Watched<'_, L>,
    event: SensorEvent,
    came: Instant,
) -> Result<()> {
    match event {
        SensorEvent::Sample(sample) => live.take_sample(sample, came),
        SensorEvent::Image(t, image) => live.take_image(t, image, came),
        SensorEvent::PassedOver(why) => {
            live.pass_over(&why);
            Ok(())
        }
    }
}

/// Says what a run was that has ended.
///
/// # Errors
/// No pose; a run that is doubted, where that is asked (`strict`).
pub(super) fn finish<L: Listener>(mut live: Watched<'_, Beside<L>>, strict: bool) -> Result<()>
where
    Beside<L>: Listener,
{
    let Totals { poses, frames, restarts, waited_for } = live.totals().clone();
    let passed_over = live.passed_over();
    live.listener.say(&format!(
        "{poses} poses of {frames} frames, {restarts} restarts, {passed_over} messages passed over"
    ));
    if let Some([median, most]) = live.listener.latency_ms() {
        live.listener
            .say(&format!("from an image to its pose {median:.1} ms (median), 99 % within {most:.1} ms"));
    }
    let dropped = live.listener.view.take().map_or(0, Onlooker::finish);
    if dropped > 0 {
        live.listener.say(&format!("view: {dropped} messages dropped that nobody took in time"));
    }
    if poses == 0 {
        live.listener.say(&format!("warning: {}", super::run::no_pose(frames, &waited_for)));
        return Err(Untrusted::NoPose.into());
    }
    if strict && live.run().is_doubted() {
        return Err(Untrusted::Doubted.into());
    }
    Ok(())
}

fn json(pose: &StampedPose) -> serde_json::Value {
    let (p, q, t): (_, _, Stamp) =
        (pose.world_from_body.translation.vector, pose.world_from_body.rotation.coords, pose.t);
    serde_json::json!({ "t_ns": t.ns(), "position": [p.x, p.y, p.z], "quaternion_wxyz": [q.w, q.x, q.y, q.z] })
}
