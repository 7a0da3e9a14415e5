//! A run beside its sensors that does not end in silence: their clocks are held against each other, and whatever keeps poses from coming is said.
//!
//! Time is told by whoever feeds it: by stamps, and by the machine's clock where nothing comes at all. A sensor that stopped, one that never began, images in which
//! nothing can be followed and an initialisation that waits are each said within [`SILENT`], once.

use super::clocks::{LiveClocks, LiveSensor};
use super::error::LiveError;
use super::run::LiveRun;
use dpn_core::{GrayImage, ImuNoise, ImuSample, Stamp};
use dpn_io::calibration::Calibration;
use dpn_io::{IoError, in_full, printable};
use dpn_vio::estimator::{FeedError, FrontEndObserver, Phase, Update};
use std::collections::{BTreeMap, VecDeque};
use std::time::{Duration, Instant};

/// So many messages that were passed over are said.
const SHOWN: usize = 8;
/// What has not been heard of for so long is said to be silent.
const SILENT: Duration = Duration::from_secs(2);

/// How much longer the first images may take than others: they are looked at together.
const FIRST: Duration = Duration::from_millis(300);

/// Who is told what a live run makes of its sensors.
pub trait Listener {
    /// Why an update cannot be taken; it ends the run.
    type Error: From<LiveError>;

    /// Takes what a frame gave.
    ///
    /// # Errors
    /// Where nobody takes it any more.
    fn update(&mut self, seen: &Seen<'_>) -> Result<(), Self::Error>;

    /// Who looks on at the images, where anybody does.
    fn observer(&mut self) -> Option<&mut dyn FrontEndObserver> {
        None
    }

    /// Takes words for a person: `warning: ` or `note: ` and a sentence, or totals.
    fn say(&mut self, words: &str);

    /// Whether a run ends where its first inputs cannot be used, instead of passing them over.
    fn gives_up(&self) -> bool;
}

/// What came of a frame.
pub struct Seen<'a> {
    /// Its stamp on the IMU's own clock.
    pub t: Stamp,
    /// What the odometry says of it.
    pub update: &'a Update,
    /// The noise in force.
    pub noise: Option<ImuNoise>,
    /// The image that it was made of: its stamp as it was fed, and when it came.
    pub image: Option<(Stamp, Instant)>,
}

/// When a sensor was last heard of.
#[derive(Default)]
struct Heard {
    /// Its last message's stamp, as it was stamped, and when it came.
    last: Option<(Stamp, Instant)>,
    /// How far its stamps have come.
    newest: Option<Stamp>,
    /// Its last stamp, where that is before the newest.
    below: Option<Stamp>,
    /// For how long the other one has been heard alone, by its own stamps \[s\].
    alone_s: f64,
    /// Its silence was said.
    silent: bool,
}

/// What a sensor said, beside its stamp.
enum Message {
    Sample(ImuSample),
    /// And when it came.
    Image(Result<GrayImage, IoError>, Instant),
}

/// A run beside its sensors.
pub struct Watched<'a, L> {
    run: LiveRun,
    /// Who is told.
    pub listener: L,
    calibration: &'a Calibration,
    clocks: LiveClocks<Message>,
    streams: [Heard; 2],
    /// When the first message came, and the last.
    first: Option<Instant>,
    now: Option<Instant>,
    /// When a frame was last worked off that went on from others.
    seen: Option<Stamp>,
    blind: bool,
    started: bool,
    clock_said: bool,
    /// The last pose, or the first message: its stamp and when it came, and whether it was said that there is none since.
    without: Option<(Stamp, Instant, bool)>,
    /// How far each sensor's stamps have come since \[s\].
    without_s: [f64; 2],
    /// What the last frame waited for.
    waits: Option<String>,
    totals: Totals,
    /// Images of which no frame has come back yet: their stamps, and when they came.
    images: VecDeque<(Stamp, Instant)>,
    /// Messages that were passed over for other reasons than their stamps.
    passed_over: usize,
}

/// What a live run has come to.
#[derive(Debug, Clone, Default)]
pub struct Totals {
    /// Poses.
    pub poses: usize,
    /// Frames that were worked off.
    pub frames: usize,
    /// How often it began again.
    pub restarts: usize,
    /// What frames waited for that could not be initialised with, and how many.
    pub waited_for: BTreeMap<String, usize>,
}

impl<'a, L: Listener> Watched<'a, L> {
    /// Watches over `run`, whose camera's stamps `calibration` puts on the IMU's clock.
    pub fn new(run: LiveRun, calibration: &'a Calibration, listener: L) -> Self {
        Self {
            run,
            listener,
            calibration,
            clocks: LiveClocks::default(),
            streams: Default::default(),
            first: None,
            now: None,
            seen: None,
            blind: false,
            started: false,
            clock_said: false,
            without: None,
            without_s: [0.0; 2],
            waits: None,
            totals: Totals::default(),
            images: VecDeque::new(),
            passed_over: 0,
        }
    }

    /// What is watched over.
    pub fn run(&self) -> &LiveRun {
        &self.run
    }

    /// What it has come to so far.
    pub fn totals(&self) -> &Totals {
        &self.totals
    }

    /// Messages that were passed over so far.
    pub fn passed_over(&self) -> usize {
        self.passed_over + self.clocks.passed_over()
    }

    /// Takes a sample that came `now`.
    ///
    /// # Errors
    /// Noise that cannot be told; where the listener takes no more.
    pub fn take_sample(&mut self, sample: ImuSample, now: Instant) -> Result<(), L::Error> {
        self.take(LiveSensor::Imu, sample.t, Message::Sample(sample), now)
    }

    /// Takes an image of the camera's stamp `t` that came `now`, or why there is none.
    ///
    /// # Errors
    /// As [`take_sample`](Self::take_sample); first images that cannot be used, where the listener gives up.
    pub fn take_image(
        &mut self,
        t: Stamp,
        image: Result<GrayImage, IoError>,
        now: Instant,
    ) -> Result<(), L::Error> {
        self.take(LiveSensor::Camera, self.calibration.on_imu_clock(t), Message::Image(image, now), now)
    }

    /// Counts a message that could not be read, and says why.
    pub fn pass_over(&mut self, why: &str) {
        self.passed_over += 1;
        if self.passed_over <= SHOWN {
            self.say(format_args!("warning: {}; passed over", printable(why)));
        }
    }

    fn take(&mut self, sensor: LiveSensor, t: Stamp, message: Message, now: Instant) -> Result<(), L::Error> {
        self.first.get_or_insert(now);
        self.now = Some(now);
        let own = &mut self.streams[sensor as usize];
        (own.last, own.alone_s) = (Some((t, now)), 0.0);
        // One that is late by itself, or wrong, is no step of time; those of a clock that was set back by little follow on each other.
        let is_step = |step_s: &f64| (0.0..=SILENT.as_secs_f64()).contains(step_s);
        let step_s = own.newest.map_or(0.0, |newest| t.seconds_since(newest));
        let is_below = (-SILENT.as_secs_f64()..0.0).contains(&step_s);
        let from_below_s = own.below.map(|below| t.seconds_since(below));
        let step_s = if is_below { from_below_s.filter(is_step) } else { Some(step_s).filter(is_step) };
        own.below = is_below.then_some(t);
        if !is_below {
            own.newest = Some(t);
        }
        let was_silent = std::mem::take(&mut own.silent);
        self.without.get_or_insert((t, now, false));
        if let Some(step_s) = step_s {
            self.streams[sensor.other() as usize].alone_s += step_s;
            self.without_s[sensor as usize] += step_s;
        }
        if was_silent {
            self.say(format_args!("note: the {} is heard again, at {t}", sensor.name()));
        }
        let ready = self.clocks.take(sensor, t, Some(now), message);
        self.clock_words();
        ready.into_iter().try_for_each(|(_, t, message)| self.feed(t, message))?;
        self.silences(None);
        Ok(())
    }

    /// Says what has not been heard of for two seconds: by the other's stamps, and where nothing waits to be read by this machine's clock, as it is `now`.
    pub fn silences(&mut self, now: Option<Instant>) {
        let Some(first) = self.first else { return };
        for sensor in LiveSensor::ALL {
            let Heard { last, alone_s, silent, .. } = &mut self.streams[sensor as usize];
            let by_clock = now.map(|now| now.saturating_duration_since(last.map_or(first, |(_, came)| came)));
            let for_s = alone_s.max(by_clock.unwrap_or_default().as_secs_f64());
            if for_s < SILENT.as_secs_f64() || std::mem::replace(silent, true) {
                continue;
            }
            let since = last.map_or("yet".to_owned(), |(t, _)| format!("since {t}"));
            self.say(format_args!("warning: nothing from the {} {since}", sensor.name()));
        }
        self.look_for_poses(now.unwrap_or(first));
    }

    fn patience_s(&self) -> f64 {
        if self.totals.frames == 0 { SILENT + FIRST } else { SILENT }.as_secs_f64()
    }

    /// Says once what poses wait for, where there are none for [`SILENT`].
    fn look_for_poses(&mut self, now: Instant) {
        let Some((since, came, said)) = self.without else { return };
        let by_clock = now.saturating_duration_since(came).as_secs_f64();
        let for_s = self.without_s.into_iter().fold(by_clock, f64::max);
        if said || for_s < self.patience_s() {
            return;
        }
        self.without = Some((since, came, true));
        let trouble = self.run.trouble();
        let waits = trouble.or(self.waits.clone());
        let waits = waits.as_deref().unwrap_or("no image has samples on both sides of it");
        let words = match self.totals.poses {
            0 => format!("note: no pose yet: {waits}"),
            _ => format!("note: no pose since {}: {waits}", self.clocks.on_imu_clock(since)),
        };
        self.listener.say(&words);
    }

    /// Nothing more comes.
    ///
    /// # Errors
    /// As [`take_sample`](Self::take_sample).
    pub fn end(&mut self) -> Result<(), L::Error> {
        let mut done = self.clocks.end().into_iter().try_for_each(|(_, t, message)| self.feed(t, message));
        self.clock_words();
        if done.is_ok() {
            done = self.run.end().map_err(Into::into).and_then(|()| self.updates());
        }
        self.run.look_back();
        self.warnings();
        done
    }

    fn say(&mut self, words: std::fmt::Arguments<'_>) {
        self.listener.say(&words.to_string());
    }

    fn clock_words(&mut self) {
        while let Some(words) = self.clocks.take_words() {
            self.say(format_args!("warning: {words}"));
        }
    }

    /// Gives the odometry a message whose stamp is on the common time.
    fn feed(&mut self, t: Stamp, message: Message) -> Result<(), L::Error> {
        let image = match &message {
            Message::Image(Ok(_), came) => Some((t, *came)),
            _ => None,
        };
        let gives_up = self.totals.frames == 0 && self.listener.gives_up();
        let taken = match message {
            Message::Sample(sample) => self.run.feed_sample(ImuSample { t, ..sample }),
            Message::Image(Ok(image), _) => self.run.feed_image(t, image.view()),
            // A camera whose images are all alike unreadable is no camera.
            Message::Image(Err(error), _) if gives_up && self.passed_over >= SHOWN => {
                return Err(LiveError::from(error).into());
            }
            Message::Image(Err(error), _) => {
                self.pass_over(&in_full(&error));
                Ok(())
            }
        };
        match taken {
            // Later it is the IMU's silence, which was said.
            Err(error @ LiveError::Feed(FeedError::ImuBehind { .. })) if gives_up => return Err(error.into()),
            Err(LiveError::Feed(error)) => self.pass_over(&error.to_string()),
            other => {
                other?;
                self.images.extend(image);
            }
        }
        self.warnings();
        self.updates()?;
        if let Some((t, _)) = image {
            self.look(t);
        }
        Ok(())
    }

    fn updates(&mut self) -> Result<(), L::Error> {
        loop {
            let update = match self.listener.observer() {
                Some(observer) => self.run.watched_update(observer),
                None => self.run.next_update(),
            };
            let Some(update) = update else { return Ok(()) };
            self.warnings();
            self.totals.frames += 1;
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
            if update.state.is_some() {
                self.totals.poses += 1;
                (self.without, self.without_s) = (self.now.map(|now| (update.t, now, false)), [0.0; 2]);
            }
            let image = self.image_of(update.t, clock.offset_s);
            let (t, noise) = (self.clocks.on_imu_clock(update.t), self.run.noise_in_force());
            self.listener.update(&Seen { t, update: &update, noise, image })?;
        }
    }

    /// The image that the frame of time `t` was made of.
    fn image_of(&mut self, t: Stamp, offset_s: f64) -> Option<(Stamp, Instant)> {
        let apart = |(fed, _): &&(Stamp, Instant)| fed.plus_seconds(offset_s).ns().abs_diff(t.ns());
        let image = self.images.iter().min_by_key(apart).copied()?;
        self.images.retain(|(other, _)| *other > image.0);
        Some(image)
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
        // Without samples no image is looked at.
        let t = self.run.reached().map_or(since, |sample| sample.min(t));
        let dark = t.seconds_since(since) >= self.patience_s();
        let is_heard = !self.streams[LiveSensor::Imu as usize].silent;
        if dark && is_heard && !std::mem::replace(&mut self.blind, true) {
            self.say(format_args!(
                "warning: no point is followed since {since}: the images are dark, covered or blurred"
            ));
        }
    }

    fn phase(&mut self, update: &Update) {
        match &update.phase {
            Phase::Initialising(reason) => {
                *self.totals.waited_for.entry(reason.name().to_owned()).or_default() += 1;
                self.waits = Some(format!("initialising: {reason}"));
            }
            Phase::Restarted(reason) => {
                self.totals.restarts += 1;
                self.say(format_args!("warning: {}: {reason}; initialising again", update.t));
                self.waits = Some(format!("initialising again: {reason}"));
            }
            _ if update.state.is_some() && !self.started => {
                self.started = true;
                let frame = self.totals.frames;
                self.say(format_args!("note: initialised at {}, frame {frame}", update.t));
            }
            _ => {}
        }
    }
}
