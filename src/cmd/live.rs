//! `dpn run -`: the odometry beside running sensors, poses out as they are made.

use super::foxglove::{Onlooker, onlooker};
use super::latency::Latency;
use super::{settings, shipped, stop};
use crate::args::{CameraArg, RunArgs};
use crate::ui::{Fault, Untrusted, errln, is_closed_pipe, outln, warn};
use anyhow::Result;
use dpn_core::trajectory::StampedPose;
use dpn_core::{GrayImage, ImuSample, Stamp};
use dpn_eval::closed_loop::ClosedLoopError;
use dpn_io::calibration::Calibration;
use dpn_io::{IoError, printable, tum_line};
use dpn_live::{Fed, LiveClocks, LiveError, LiveRun, LiveSensor, settings_for};
use dpn_logs::{LogError, SensorEvent, read_sensors};
use dpn_vio::estimator::{FeedError, Phase, Update};
use std::collections::{BTreeMap, VecDeque};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// So many messages that were passed over are said.
const SHOWN: usize = 8;
/// Messages that wait.
const QUEUE: usize = 64;
/// How often this looks for silence and for a wish to end.
const LOOK: Duration = Duration::from_millis(200);
/// What has not been heard of for so long is said to be silent.
const SILENT: Duration = Duration::from_secs(2);

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
        ("--mcap", args.mcap.is_some()),
        ("--rerun", args.rerun.is_some()),
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
    let networks = shipped::or_of(args.models.as_deref())?;
    let estimator = super::run::estimator(args)?;
    let noise = args.noise.parse()?;
    warn(settings_for(&estimator, &noise).warnings());
    let run = LiveRun::new(&estimator, noise, networks, config, Fed::Images, args.seed)?;
    let view = onlooker(args.view)?;
    let mut live = Live::new(run, &calibration, Lines { json: args.json }, view);
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
    live.finish(args.strict)
}

/// Who is told what a live run makes of its sensors.
pub(super) trait Listener {
    /// Takes what a frame gave; `t` is its stamp on the IMU's own clock.
    fn update(&mut self, t: Stamp, update: &Update) -> Result<()>;

    /// Takes words for a person.
    fn say(&mut self, words: &str) {
        errln!("{words}");
    }

    /// Whether a run ends where its first inputs cannot be used, instead of passing them over.
    fn gives_up(&self) -> bool;
}

/// A line a pose.
struct Lines {
    json: bool,
}

impl Listener for Lines {
    fn update(&mut self, t: Stamp, update: &Update) -> Result<()> {
        let Some(state) = update.state else { return Ok(()) };
        let pose = StampedPose { t, world_from_body: state.world_from_body };
        if self.json {
            outln!("{}", json(&pose))?;
        } else {
            outln!("{}", tum_line(&pose))?;
        }
        Ok(())
    }

    fn gives_up(&self) -> bool {
        true
    }
}

/// Takes what the sensors say until they end, or this is asked to; what was wrong where they ended early.
fn follow(live: &mut Live<'_, Lines>, args: &RunArgs, size: [usize; 2]) -> Result<Option<String>> {
    let stop = stop::on_any_end()?;
    let (events, reader) = reader(args, size);
    while !stop.load(Ordering::Relaxed) {
        match events.recv_timeout(LOOK) {
            Ok((event, came)) => live.take(event, came)?,
            Err(RecvTimeoutError::Timeout) => live.silences(true),
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

/// When a sensor was last heard of.
#[derive(Default)]
struct Heard {
    /// Its last message's stamp, as it was stamped, and when it came.
    last: Option<(Stamp, Instant)>,
    /// Its silence was said.
    silent: bool,
}

/// A run beside its sensors, their clocks held against each other.
pub(super) struct Live<'a, L> {
    pub(super) run: LiveRun,
    pub(super) listener: L,
    calibration: &'a Calibration,
    clocks: LiveClocks<Message>,
    streams: [Heard; 2],
    /// When a frame was last worked off that went on from others.
    seen: Option<Stamp>,
    blind: bool,
    started: bool,
    clock_said: bool,
    pub(super) restarts: usize,
    pub(super) poses: usize,
    pub(super) frames: usize,
    passed_over: usize,
    /// What frames waited for that could not be initialised with, and how many.
    waited_for: BTreeMap<String, usize>,
    /// Images of which no frame has come back yet: their stamps, and when they came.
    images: VecDeque<(Stamp, Instant)>,
    /// From an image's arrival to its pose.
    pub(super) latency: Latency,
    view: Option<Box<dyn Onlooker>>,
}

/// What a sensor said, beside its stamp.
enum Message {
    Sample(ImuSample),
    Image(Result<GrayImage, IoError>, Instant),
}

impl<'a, L: Listener> Live<'a, L> {
    pub(super) fn new(
        run: LiveRun,
        calibration: &'a Calibration,
        listener: L,
        view: Option<Box<dyn Onlooker>>,
    ) -> Self {
        Self {
            run,
            listener,
            calibration,
            clocks: LiveClocks::default(),
            streams: Default::default(),
            seen: None,
            blind: false,
            started: false,
            clock_said: false,
            restarts: 0,
            poses: 0,
            frames: 0,
            passed_over: 0,
            waited_for: BTreeMap::new(),
            images: VecDeque::new(),
            latency: Latency::default(),
            view,
        }
    }

    /// Messages that were passed over so far.
    pub(super) fn passed_over(&self) -> usize {
        self.passed_over + self.clocks.passed_over()
    }

    /// Says what the run was, having ended.
    ///
    /// # Errors
    /// No pose; a run that is doubted, where that is asked (`strict`).
    pub(super) fn finish(mut self, strict: bool) -> Result<()> {
        let (poses, frames, restarts, passed_over) =
            (self.poses, self.frames, self.restarts, self.passed_over());
        self.say(format_args!(
            "{poses} poses of {frames} frames, {restarts} restarts, {passed_over} messages passed over"
        ));
        if let Some([median, most]) = self.latency_ms() {
            self.say(format_args!(
                "from an image to its pose {median:.1} ms (median), 99 % within {most:.1} ms"
            ));
        }
        let dropped = self.view.take().map_or(0, Onlooker::finish);
        if dropped > 0 {
            self.say(format_args!("view: {dropped} messages dropped that nobody took in time"));
        }
        if poses == 0 {
            self.say(format_args!("warning: {}", super::run::no_pose(frames, &self.waited_for)));
            return Err(Untrusted::NoPose.into());
        }
        if strict && self.run.is_doubted() {
            return Err(Untrusted::Doubted.into());
        }
        Ok(())
    }

    /// From an image's arrival to its pose: median and what 99 % do not go beyond \[ms\].
    pub(super) fn latency_ms(&self) -> Option<[f64; 2]> {
        Some([self.latency.quantile_ms(0.5)?, self.latency.quantile_ms(0.99)?])
    }

    fn say(&mut self, words: std::fmt::Arguments<'_>) {
        self.listener.say(&words.to_string());
    }

    /// Nothing more comes.
    pub(super) fn end(&mut self) -> Result<()> {
        let mut done = self.clocks.end().into_iter().try_for_each(|(_, t, message)| self.feed(t, message));
        self.clock_words();
        if done.is_ok() {
            done = self.run.end().map_err(Into::into).and_then(|()| self.updates());
        }
        self.run.look_back();
        self.warnings();
        done
    }

    /// Takes a message and when it came.
    pub(super) fn take(&mut self, event: SensorEvent, came: Instant) -> Result<()> {
        let (sensor, t, message) = match event {
            SensorEvent::Sample(sample) => (LiveSensor::Imu, sample.t, Message::Sample(sample)),
            SensorEvent::Image(t, image) => {
                (LiveSensor::Camera, self.calibration.on_imu_clock(t), Message::Image(image, came))
            }
            SensorEvent::PassedOver(why) => {
                self.pass_over(&why);
                return Ok(());
            }
        };
        self.heard(sensor, t);
        let ready = self.clocks.take(sensor, t, message);
        self.clock_words();
        ready.into_iter().try_for_each(|(_, t, message)| self.feed(t, message))?;
        self.silences(false);
        Ok(())
    }

    fn heard(&mut self, sensor: LiveSensor, t: Stamp) {
        if std::mem::take(&mut self.streams[sensor as usize].silent) {
            self.say(format_args!("note: the {} is heard again, at {t}", sensor.name()));
        }
        self.streams[sensor as usize].last = Some((t, Instant::now()));
    }

    /// Says what has not been heard of for [`SILENT`]: by the other sensor's stamps, and where nothing waits to be read (`idle`) by this machine's clock.
    pub(super) fn silences(&mut self, idle: bool) {
        for sensor in LiveSensor::ALL {
            let by_stamps = || {
                let [own, other] = [sensor, sensor.other()].map(|sensor| self.clocks.last(sensor));
                Some(other?.seconds_since(own?))
            };
            let Some((t, came)) = self.streams[sensor as usize].last else { continue };
            let by_clock = if idle { came.elapsed().as_secs_f64() } else { 0.0 };
            if by_stamps().unwrap_or(0.0).max(by_clock) < SILENT.as_secs_f64() {
                continue;
            }
            if !std::mem::replace(&mut self.streams[sensor as usize].silent, true) {
                self.say(format_args!("warning: nothing from the {} since {t}", sensor.name()));
            }
        }
    }

    fn clock_words(&mut self) {
        while let Some(words) = self.clocks.take_words() {
            self.say(format_args!("warning: {words}"));
        }
    }

    /// Gives the odometry a message whose stamp is on the common time.
    fn feed(&mut self, t: Stamp, message: Message) -> Result<()> {
        let image = match &message {
            Message::Image(Ok(_), came) => Some((t, *came)),
            _ => None,
        };
        let taken = match message {
            Message::Sample(sample) => self.run.feed_sample(ImuSample { t, ..sample }),
            Message::Image(Ok(image), _) => self.run.feed_image(t, image.view()),
            // A camera whose images are all alike unreadable is no camera.
            Message::Image(Err(error), _)
                if self.frames == 0 && self.passed_over >= SHOWN && self.listener.gives_up() =>
            {
                return Err(error.into());
            }
            Message::Image(Err(error), _) => {
                self.pass_over(&ClosedLoopError::from(error).in_full());
                Ok(())
            }
        };
        match taken {
            // Later it is the IMU's silence, which was said.
            Err(error @ LiveError::Feed(FeedError::ImuBehind { .. }))
                if self.frames == 0 && self.listener.gives_up() =>
            {
                return Err(error.into());
            }
            Err(LiveError::Feed(error)) => self.pass_over(&error.to_string()),
            other => {
                other?;
                self.images.extend(image);
            }
        }
        self.updates()?;
        if let Some((t, _)) = image {
            self.look(t);
        }
        Ok(())
    }

    fn pass_over(&mut self, why: &str) {
        self.passed_over += 1;
        if self.passed_over <= SHOWN {
            self.say(format_args!("warning: {}; passed over", printable(why)));
        }
    }

    fn updates(&mut self) -> Result<()> {
        loop {
            let update = match &mut self.view {
                Some(view) => self.run.watched_update(&mut **view),
                None => self.run.next_update(),
            };
            let Some(update) = update else { return Ok(()) };
            self.warnings();
            self.frames += 1;
            let clock = self.run.report().clock;
            if clock.found.is_some() && !std::mem::replace(&mut self.clock_said, true) {
                self.say(format_args!(
                    "note: the camera's clock is {:+.1} ms off the gyroscope's; `--time-offset {:.4}` takes it off from the start",
                    -1e3 * clock.offset_s,
                    clock.offset_s
                ));
            }
            self.phase(&update);
            self.sees(&update);
            self.poses += usize::from(update.state.is_some());
            let t = self.clocks.on_imu_clock(update.t);
            self.listener.update(t, &update)?;
            let image = self.image_of(update.t, clock.offset_s);
            if let (Some((_, latency_s)), true) = (image, update.state.is_some()) {
                self.latency.add(latency_s);
            }
            if let Some(view) = &mut self.view {
                view.show((t, &update), self.run.noise_in_force(), image);
            }
        }
    }

    /// The image that the frame of time `t` was made of: its stamp, as it was fed, and the time since it came \[s\].
    fn image_of(&mut self, t: Stamp, offset_s: f64) -> Option<(Stamp, f64)> {
        let apart = |(fed, _): &&(Stamp, Instant)| fed.plus_seconds(offset_s).ns().abs_diff(t.ns());
        let (fed, came) = self.images.iter().min_by_key(apart).copied()?;
        self.images.retain(|(other, _)| *other > fed);
        Some((fed, came.elapsed().as_secs_f64()))
    }

    fn warnings(&mut self) {
        while let Some(warning) = self.run.take_warning() {
            self.say(format_args!("warning: {warning}"));
        }
    }

    fn sees(&mut self, update: &Update) {
        if update.state.is_some() && update.tracked == 0 {
            return;
        }
        self.seen = Some(update.t);
        if std::mem::take(&mut self.blind) {
            self.say(format_args!("note: points are followed again, at {}", update.t));
        }
    }

    /// Says when images come, the last of them at `t`, and show nothing that can be followed.
    fn look(&mut self, t: Stamp) {
        let since = *self.seen.get_or_insert(t);
        let dark = t.seconds_since(since) >= SILENT.as_secs_f64();
        // Without samples no image is looked at.
        let imu = &self.streams[LiveSensor::Imu as usize];
        let is_heard = imu.last.is_some() && !imu.silent;
        if dark && is_heard && !std::mem::replace(&mut self.blind, true) {
            self.say(format_args!(
                "warning: no point is followed since {since}: the images are dark, covered or blurred"
            ));
        }
    }

    fn phase(&mut self, update: &Update) {
        match &update.phase {
            Phase::Initialising(reason) => {
                *self.waited_for.entry(reason.name().to_owned()).or_default() += 1;
            }
            Phase::Restarted(reason) => {
                self.restarts += 1;
                self.say(format_args!("warning: {}: {reason}; initialising again", update.t));
            }
            _ if update.state.is_some() && !self.started => {
                self.started = true;
                let frame = self.frames;
                self.say(format_args!("note: initialised at {}, frame {frame}", update.t));
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
