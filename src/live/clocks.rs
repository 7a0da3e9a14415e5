//! The clocks of an IMU and a camera that run, held against each other: a stamp that is wrong, a clock that was set, and sensors that were silent are
//! three things.
//!
//! A stamp that does not follow on its sensor's last one, nor on what the other sensor's clock made of that time, is held back until the next messages tell:
//!
//! * its sensor goes on where it was: the stamp was wrong, and its message is passed over;
//! * the other sensor's stamps jump as far: both clocks were set, or nothing was recorded. Where messages came as they were stamped, when they came tells: a clock that
//!   was set is set back, and a gap is left; where they did not, as from a file, both go on as they are, with a gap between;
//! * the other sensor goes on where it was: this one's clock was set. What it was set by is taken off from then on.
//!
//! One that runs ahead by less than that waits for its sensor's next: where that comes before it, the stamp was wrong.
//!
//! What is let through unchanged is let through in the order in which it came: good streams are not touched.

use dpn_core::{Stamp, named};
use std::collections::VecDeque;
use std::time::Instant;

/// What a stamp may be off at most \[s\], and where both sensors' messages come one by one.
const OFF_S: f64 = 1.0;
const NEAR_S: f64 = 0.1;
/// By half, how messages came is forgotten after so long \[s\].
const FORGOTTEN_S: f64 = 3.0;
/// A clock that was set by less goes on as it is \[ns\]: that much is how messages come.
const SET_NS: i64 = 50_000_000;
/// So long \[s\] of stamps, and of messages that come, are held against each other; they go together within a fifth.
const PACE_S: f64 = 2.0;
const PACE: std::ops::Range<f64> = 0.8..1.25;
/// Messages of a sensor whose clock was set, and of the other meanwhile, before it is said so.
const ENOUGH: [usize; 2] = [3, 2];
/// So many of a sensor's messages before one that runs ahead say that its stamp is wrong. Single samples overtake others; an image waits only where its stamp
/// is ahead of the IMU's too.
const BEFORE: [usize; 2] = [3, 1];
/// Where the other sensor is silent for so long \[s\], a jump is taken as it is.
const ALONE_S: f64 = 2.0;
/// Less than this \[ns\] is how messages come, and no clock that was set.
const APART_NS: i64 = 1_000_000;
/// What the odometry finds a clock to be off by itself \[s\].
const FOUND_S: f64 = 0.25;
/// So many times is said that messages were passed over.
const SHOWN: usize = 8;
/// Stamps of one sensor that are the same, one after another, before it is said.
const SAME: usize = 20;

named!(
    /// A sensor.
    pub enum LiveSensor {
        /// The IMU.
        Imu = "IMU",
        /// The camera.
        Camera = "camera",
    }
);

impl LiveSensor {
    /// The other one.
    #[must_use]
    pub fn other(self) -> Self {
        Self::ALL[1 - self as usize]
    }
}

/// A message on its way.
#[derive(Debug)]
struct Held<E> {
    sensor: LiveSensor,
    /// As it was stamped.
    raw: Stamp,
    /// When it came, where that is known.
    came: Option<Instant>,
    message: E,
}

/// A message that runs ahead of its sensor.
#[derive(Debug)]
struct Ahead<E> {
    /// On the common time.
    t: Stamp,
    /// The other's last stamp when it came, and when that was.
    other: Option<Stamp>,
    came: Option<Instant>,
    message: E,
    /// How many of its sensor's messages came from before it since.
    before: usize,
}

/// One sensor's clock.
#[derive(Debug, Default)]
struct Clock {
    /// The last stamp that was let through, on the common time.
    last: Option<Stamp>,
    /// Time between the last two.
    step_s: f64,
    /// When it came.
    came: Option<Instant>,
    /// A stamp [`PACE_S`] ago at most and when it came, and whether the time before went by as the stamps say.
    pace_from: Option<(Stamp, Instant)>,
    is_timely: bool,
    /// The other's last stamp then.
    other: Option<Stamp>,
    /// The newest that is held back and the other's newest then, as they were stamped.
    newest: Option<(Stamp, Stamp)>,
    /// How far the other's stamps go on between two of its own, as a rule.
    usual_s: f64,
    /// How far its stamps are from where the other's would have them, as a rule.
    usual_off_s: Option<f64>,
    /// How much more or less time went by than its stamps say, as a rule.
    usual_late_s: f64,
    /// What is taken off its stamps \[ns\].
    shift_ns: i64,
    /// How many were passed over since that stamp.
    dropped: usize,
    /// How many are held back, doubles once, and what the other let through since.
    held: usize,
    since: usize,
    same: usize,
    standing_said: bool,
}

impl Clock {
    /// How much more time went by since the last message than the stamps say \[s\].
    fn late_s(&self, t: Stamp, came: Option<Instant>) -> Option<f64> {
        let (before, last) = (self.came?, self.last?);
        Some(came?.saturating_duration_since(before).as_secs_f64() - t.seconds_since(last))
    }

    /// A message of time `t` came: whether stamps go on as time does.
    fn keeps_pace(&mut self, t: Stamp, came: Option<Instant>) {
        self.came = came;
        let Some(came) = came else { return };
        let (from, begun) = *self.pace_from.get_or_insert((t, came));
        let stamps_s = t.seconds_since(from);
        if stamps_s >= PACE_S {
            self.is_timely = PACE.contains(&(came.saturating_duration_since(begun).as_secs_f64() / stamps_s));
        }
        if !(0.0..PACE_S).contains(&stamps_s) {
            self.pace_from = Some((t, came));
        }
    }
}

/// Two sensors' clocks, with the messages that are held back.
#[derive(Debug)]
pub struct LiveClocks<E> {
    clocks: [Clock; 2],
    /// How far an image's stamp is ahead of the newest sample's when it comes \[ns\].
    apart_ns: i64,
    /// The same of the last image, until a sample comes.
    apart_next: Option<i64>,
    held: Vec<Held<E>>,
    ahead: [Option<Ahead<E>>; 2],
    /// From when on \[common time\] so many nanoseconds were taken off the IMU's stamps.
    set: Vec<(Stamp, i64)>,
    words: VecDeque<String>,
    /// Messages that were passed over.
    passed_over: usize,
    said: usize,
}

impl<E> Default for LiveClocks<E> {
    fn default() -> Self {
        Self {
            clocks: Default::default(),
            apart_ns: 0,
            apart_next: None,
            held: Vec::new(),
            ahead: [None, None],
            set: Vec::new(),
            words: VecDeque::new(),
            passed_over: 0,
            said: 0,
        }
    }
}

impl<E> LiveClocks<E> {
    /// Takes a message and when it came, where that is known; those that may go on, in the order in which they came, their stamps on the common time.
    pub fn take(
        &mut self,
        sensor: LiveSensor,
        raw: Stamp,
        came: Option<Instant>,
        message: E,
    ) -> Vec<(LiveSensor, Stamp, E)> {
        self.stands(sensor, raw);
        let t = self.common(sensor, raw);
        if self.follows(sensor, t, came) && !self.goes_with_held(sensor, raw) {
            let mut ready = self.overtaken(sensor, t);
            let other = self.last(sensor.other());
            if self.ahead[sensor as usize].is_none() && self.runs_ahead(sensor, t) {
                self.ahead[sensor as usize] = Some(Ahead { t, other, came, message, before: 0 });
            } else {
                ready.extend(self.goes_on(sensor, t, (other, came), message));
            }
            return ready;
        }
        let last = self.held_of(sensor).next_back();
        let step_s = self.clocks[sensor as usize].step_s;
        // One that is late is no beginning of those that are set, but where the next one is a step behind it.
        let most = if self.clocks[sensor as usize].held == 1
            && last.is_some_and(|last| self.is_late(sensor, last))
        {
            1.5 * step_s
        } else if step_s > 0.0 {
            (NEAR_S + 3.0 * step_s).min(OFF_S)
        } else {
            OFF_S
        };
        let after_s = last.map(|last| raw.seconds_since(last));
        if self.clocks[sensor as usize].held >= ENOUGH[0]
            && after_s.is_some_and(|s| (-OFF_S..0.0).contains(&s))
        {
            self.pass_over(sensor, 1, t);
            return Vec::new();
        }
        let agree = after_s.map(|after_s| (0.0..=most).contains(&after_s));
        if agree == Some(false) {
            // Neither here nor there: two that are wrong, each in its own way.
            self.drop_held(sensor);
        }
        self.held.push(Held { sensor, raw, came, message });
        let beside = self.newest(sensor.other()).map(|other| (raw, other));
        let clock = &mut self.clocks[sensor as usize];
        // A double says nothing more.
        let is_double = after_s == Some(0.0);
        clock.held += usize::from(!is_double);
        clock.newest = beside;
        if self.clocks[sensor as usize].last.is_none() {
            // The first stamp may be the wrong one, and come twice: two that agree begin, or three doubles.
            let begins = agree == Some(true) && (!is_double || self.held_of(sensor).count() >= ENOUGH[0]);
            return if begins { self.release(Some(sensor)) } else { Vec::new() };
        }
        if self.both_jumped() {
            self.keep_on(&LiveSensor::ALL);
            return self.release(None);
        }
        let goes = match self.jumped_apart() {
            // One of them had a gap, and the other's clock was set: an image says how they go together.
            Some(nearer) if sensor == LiveSensor::Camera => nearer,
            _ if self.waits_alone(sensor) => sensor,
            _ => return Vec::new(),
        };
        self.keep_on(&[goes]);
        let mut ready = self.release(Some(goes));
        ready.extend(self.follow(goes.other()));
        ready
    }

    /// Whether a stamp is beyond its sensor's next one by half a step and more, an image's beyond the IMU's clock too, where that tells: something was lost, or
    /// it is wrong.
    fn runs_ahead(&self, sensor: LiveSensor, t: Stamp) -> bool {
        let Clock { last: Some(last), step_s, other, .. } = self.clocks[sensor as usize] else {
            return false;
        };
        let beyond = |by_s: f64| step_s > 0.0 && by_s > 0.5 * step_s;
        let imu = &self.clocks[LiveSensor::Imu as usize];
        let is_heard = imu.held == 0 && imu.last > other;
        let beyond_imu = || is_heard && self.off_s(sensor, t).is_some_and(beyond);
        beyond(t.seconds_since(last) - step_s) && (sensor == LiveSensor::Imu || beyond_imu())
    }

    /// What a sensor's message of time `t` says of one that runs ahead: it goes on where this one is not before it.
    fn overtaken(&mut self, sensor: LiveSensor, t: Stamp) -> Vec<(LiveSensor, Stamp, E)> {
        let Some(mut ahead) = self.ahead[sensor as usize].take() else { return Vec::new() };
        let still_follows = self.follows(sensor, ahead.t, ahead.came);
        if still_follows && t >= ahead.t {
            return self.goes_on(sensor, ahead.t, (ahead.other, ahead.came), ahead.message);
        }
        // A double of the last one, or one that is late, says nothing.
        ahead.before += usize::from(self.last(sensor).is_none_or(|last| t > last));
        if still_follows && ahead.before < BEFORE[sensor as usize] {
            self.ahead[sensor as usize] = Some(ahead);
        } else {
            self.pass_over(sensor, 1, ahead.t);
        }
        Vec::new()
    }

    /// Where both sensors jumped and not as far, the one that jumped less.
    fn jumped_apart(&self) -> Option<LiveSensor> {
        let far = |sensor| {
            let clock = &self.clocks[sensor as usize];
            let first = self.held.iter().find(|held| held.sensor == sensor)?;
            let by_s = self.common(sensor, first.raw).seconds_since(clock.last?).abs();
            (clock.held >= ENOUGH[0]).then_some(by_s)
        };
        let [imu, camera] = LiveSensor::ALL.map(far);
        imu.zip(camera).map(|(imu, camera)| if imu <= camera { LiveSensor::Imu } else { LiveSensor::Camera })
    }

    /// The other sensor was let go as it is. What is held back of this one jumped otherwise: what came last of both came together.
    fn follow(&mut self, sensor: LiveSensor) -> Vec<(LiveSensor, Stamp, E)> {
        let first = self.held.iter().find(|held| held.sensor == sensor).map(|held| held.raw);
        let (Some(first), Some(_), Some(by_ns)) =
            (first, self.clocks[sensor as usize].last, self.together_ns(sensor))
        else {
            return Vec::new();
        };
        if by_ns.abs() > APART_NS {
            self.was_set(sensor, by_ns, first);
        }
        self.release(Some(sensor))
    }

    /// What is still held back when nothing more comes.
    pub fn end(&mut self) -> Vec<(LiveSensor, Stamp, E)> {
        let ahead = LiveSensor::ALL.map(|sensor| (sensor, self.ahead[sensor as usize].take()));
        let mut ready: Vec<_> = ahead
            .into_iter()
            .filter_map(|(sensor, ahead)| ahead.map(|Ahead { t, message, .. }| (sensor, t, message)))
            .collect();
        ready.extend(self.release(None));
        ready
    }

    /// What is to be said, once.
    pub fn take_words(&mut self) -> Option<String> {
        self.words.pop_front()
    }

    /// Messages that were passed over for their stamps.
    pub fn passed_over(&self) -> usize {
        self.passed_over
    }

    /// A sensor's last stamp that was let through, on the common time.
    pub fn last(&self, sensor: LiveSensor) -> Option<Stamp> {
        self.clocks[sensor as usize].last
    }

    /// A common time as the IMU's own stamps have it.
    pub fn on_imu_clock(&self, t: Stamp) -> Stamp {
        let shift = self.set.iter().rfind(|(since, _)| t >= *since).map_or(0, |(_, shift)| *shift);
        Stamp::from_ns(t.ns().saturating_add(shift))
    }

    fn common(&self, sensor: LiveSensor, raw: Stamp) -> Stamp {
        Stamp::from_ns(raw.ns().saturating_sub(self.clocks[sensor as usize].shift_ns))
    }

    /// How far `t` is from where the other sensor's clock would have it; none where that does not tell.
    fn off_s(&self, sensor: LiveSensor, t: Stamp) -> Option<f64> {
        let [clock, other] = [sensor, sensor.other()].map(|sensor| &self.clocks[sensor as usize]);
        Some(t.seconds_since(clock.last?) - other.last?.seconds_since(clock.other?))
    }

    /// What a stamp may be off: more where messages come in batches.
    fn most_off_s(&self, sensor: LiveSensor) -> f64 {
        self.clocks[sensor as usize].usual_off_s.map_or(OFF_S, |usual| (NEAR_S + 2.0 * usual).min(OFF_S))
    }

    /// Whether a stamp goes on from its sensor's last one, as the other's did or as time did, and does not run ahead of the time that went by until its message came.
    fn follows(&self, sensor: LiveSensor, t: Stamp, came: Option<Instant>) -> bool {
        let (clock, most) = (&self.clocks[sensor as usize], self.most_off_s(sensor));
        let Some(last) = clock.last else { return false };
        let step_s = t.seconds_since(last);
        let late_s = clock.late_s(t, came).filter(|_| clock.is_timely);
        let most_late_s = NEAR_S + 2.0 * clock.usual_late_s;
        let goes_on = (0.0..=most).contains(&step_s)
            || step_s > 0.0
                && (self.off_s(sensor, t).is_some_and(|off| off.abs() <= most)
                    || late_s.is_some_and(|late_s| late_s.abs() <= NEAR_S));
        // A sample behind a gap that took longer than it says: the IMU was silent and its clock was set back, or it is caught up with.
        let is_gap = sensor == LiveSensor::Imu && step_s > 3.0 * clock.step_s;
        let most_behind_s = if is_gap { most_late_s.max(FOUND_S) } else { f64::INFINITY };
        goes_on && late_s.is_none_or(|late_s| (-most_late_s..=most_behind_s).contains(&late_s))
    }

    /// Whether a stamp goes on from several that are held back, as its sensor's stamps do.
    fn goes_with_held(&self, sensor: LiveSensor, raw: Stamp) -> bool {
        let clock = &self.clocks[sensor as usize];
        let mut held = self.held_of(sensor).rev();
        let Some(last) = held.next().filter(|_| clock.held > 1) else { return false };
        // Several that are late were missing in the last step.
        let before = held.find(|before| *before != last);
        let usual_s = before.map_or(clock.step_s, |before| clock.step_s.min(last.seconds_since(before)));
        let step_s = raw.seconds_since(last);
        step_s > 0.0 && step_s <= 1.5 * usual_s
    }

    /// Lets a message through that came when the other's last stamp was the one `beside`, and what it tells of those that are held back.
    fn goes_on(
        &mut self,
        sensor: LiveSensor,
        t: Stamp,
        (beside, came): (Option<Stamp>, Option<Instant>),
        message: E,
    ) -> Vec<(LiveSensor, Stamp, E)> {
        self.drop_held(sensor);
        let mut ready = vec![(sensor, t, message)];
        self.passed(sensor, t, beside, came);
        let other = sensor.other();
        let first = self.held.iter().find(|held| held.sensor == other).map(|held| (held.raw, held.came));
        let Some((first, came)) = first else { return ready };
        let clock = &mut self.clocks[other as usize];
        if clock.last.is_none() {
            return ready;
        }
        clock.since += 1;
        let t = self.common(other, first);
        if self.follows(other, t, came) {
            // The other one has come so far: there was nothing wrong.
            ready.extend(self.release(Some(other)));
            return ready;
        }
        let clock = &self.clocks[other as usize];
        if clock.held < ENOUGH[0] || clock.since < ENOUGH[1] {
            return ready;
        }
        if clock.other.is_none() {
            // Nobody knows how long its jump took.
            self.keep_on(&[other]);
            ready.extend(self.release(Some(other)));
            return ready;
        }
        let by_ns = self.jump_ns(other, first);
        if by_ns.abs() >= SET_NS {
            self.was_set(other, by_ns, first);
        }
        ready.extend(self.release(Some(other)));
        ready
    }

    /// Takes off by how much a sensor's clock was set, and says so.
    fn was_set(&mut self, sensor: LiveSensor, by_ns: i64, first: Stamp) {
        self.shift(sensor, by_ns);
        let by_s = by_ns as f64 * 1e-9;
        let way = if by_s > 0.0 { "ahead" } else { "back" };
        self.words.push_back(format!(
            "the {}'s clock was set {:.3} s {way} at {first}, and the {}'s was not: that is taken off from here on",
            sensor.name(),
            by_s.abs(),
            sensor.other().name()
        ));
    }

    /// How far `first` is from where its sensor's next message would have been \[ns\]: a step after its last one and those that were passed over since. Where
    /// the other sensor's stamps went on farther meanwhile than as a rule, they tell: what came last of both came together, as before.
    fn jump_ns(&self, sensor: LiveSensor, first: Stamp) -> i64 {
        let clock = &self.clocks[sensor as usize];
        let steps_s = clock.step_s * (1 + clock.dropped) as f64;
        let of_steps = || {
            let after = (steps_s * 1e9).round() as i64;
            self.common(sensor, first)
                .ns()
                .saturating_sub(clock.last.map_or(0, Stamp::ns))
                .saturating_sub(after)
        };
        let (Some((newest, now)), Some(before)) = (clock.newest, clock.other) else { return of_steps() };
        if self.clocks[sensor.other() as usize].held > 0 {
            return of_steps();
        }
        // Since the first was held back both went on.
        let passed_s = self.common(sensor.other(), now).seconds_since(before) - newest.seconds_since(first);
        if passed_s <= clock.usual_s + steps_s - 0.25 * clock.step_s {
            return of_steps();
        }
        self.together_ns(sensor).unwrap_or_else(of_steps)
    }

    /// How far the newest that is held back is from where it would be, having come with the other sensor's newest \[ns\].
    fn together_ns(&self, sensor: LiveSensor) -> Option<i64> {
        let (newest, beside) = self.clocks[sensor as usize].newest?;
        let other = sensor.other();
        // The last image came after the last sample.
        let (beside, apart) = match sensor {
            LiveSensor::Imu => (self.newest(other)?, -self.apart_ns),
            LiveSensor::Camera => (beside, self.apart_ns),
        };
        let expected = self.common(other, beside).ns().saturating_add(apart);
        Some(self.common(sensor, newest).ns().saturating_sub(expected))
    }

    /// A sensor's newest that is held back or was let through, as it was stamped.
    fn newest(&self, sensor: LiveSensor) -> Option<Stamp> {
        let clock = &self.clocks[sensor as usize];
        // Few that are held back may be wrong.
        let held = self.held.iter().rfind(|held| held.sensor == sensor && clock.held >= ENOUGH[0]);
        held.map(|held| held.raw)
            .or_else(|| Some(Stamp::from_ns(clock.last?.ns().saturating_add(clock.shift_ns))))
    }

    fn shift(&mut self, sensor: LiveSensor, by_ns: i64) {
        let clock = &mut self.clocks[sensor as usize];
        clock.shift_ns = clock.shift_ns.saturating_add(by_ns);
        if sensor == LiveSensor::Imu {
            let since = Stamp::from_ns(clock.last.map_or(0, Stamp::ns).saturating_add(1));
            self.set.push((since, clock.shift_ns));
        }
    }

    /// Time does not go back, nor ahead of when messages come: where these sensors' stamps do, that is taken off, by as much as the first of them.
    fn keep_on(&mut self, sensors: &[LiveSensor]) {
        let Some(first) = self.held.iter().find(|held| sensors.contains(&held.sensor)) else { return };
        let by_ns = match self.jump_ns(first.sensor, first.raw) {
            by_ns if by_ns > 0 => self.set_ahead_ns(first, by_ns),
            by_ns => by_ns,
        };
        if by_ns.abs() < SET_NS {
            return;
        }
        let raw = first.raw;
        sensors.iter().for_each(|sensor| self.shift(*sensor, by_ns));
        let names: Vec<&str> = sensors.iter().map(|sensor| sensor.name()).collect();
        let (names, by_s) = (names.join("'s and the "), by_ns.unsigned_abs() as f64 * 1e-9);
        let way = if by_ns > 0 { "ahead" } else { "back" };
        self.words.push_back(format!("the {names}'s clock was set {by_s:.3} s {way} at {raw}; poses go on"));
    }

    /// How much of a jump ahead is not the time that went by until its first message came \[ns\]; 0 where that does not tell.
    fn set_ahead_ns(&self, first: &Held<E>, by_ns: i64) -> i64 {
        let clock = &self.clocks[first.sensor as usize];
        let t = self.common(first.sensor, first.raw);
        let Some(set_s) = clock.late_s(t, first.came).map(|late_s| -late_s).filter(|_| clock.is_timely)
        else {
            return 0;
        };
        let by_s = by_ns as f64 * 1e-9;
        if set_s < NEAR_S.max(0.5 * by_s) {
            0
        } else if by_s - set_s < NEAR_S {
            by_ns
        } else {
            (set_s * 1e9).round() as i64
        }
    }

    /// Whether both sensors' stamps jumped, and as far; a few samples say so, one may be late.
    fn both_jumped(&self) -> bool {
        if self.clocks[LiveSensor::Imu as usize].held < ENOUGH[0] {
            return false;
        }
        let off = |sensor| {
            let first = self.held.iter().find(|held| held.sensor == sensor)?;
            self.off_s(sensor, self.common(sensor, first.raw))
        };
        let [imu, camera] = LiveSensor::ALL.map(off);
        let most = LiveSensor::ALL.map(|sensor| self.most_off_s(sensor)).into_iter().fold(0.0, f64::max);
        imu.zip(camera).is_some_and(|(imu, camera)| (imu - camera).abs() <= most)
    }

    /// Whether the other sensor says nothing that could tell.
    fn waits_alone(&self, sensor: LiveSensor) -> bool {
        let mut own = self.held_of(sensor);
        let (Some(first), Some(last)) = (own.next(), own.next_back()) else { return false };
        self.clocks[sensor as usize].since == 0 && last.seconds_since(first) > ALONE_S
    }

    /// What is held back, of one sensor or of both, as it came.
    fn release(&mut self, of: Option<LiveSensor>) -> Vec<(LiveSensor, Stamp, E)> {
        let mut ready = Vec::with_capacity(self.held.len());
        for Held { sensor, raw, came, message } in std::mem::take(&mut self.held) {
            if of.is_some_and(|of| of != sensor) {
                self.held.push(Held { sensor, raw, came, message });
                continue;
            }
            let t = self.common(sensor, raw);
            self.passed(sensor, t, self.last(sensor.other()), came);
            ready.push((sensor, t, message));
            let clock = &mut self.clocks[sensor as usize];
            (clock.held, clock.since) = (0, 0);
        }
        ready
    }

    fn passed(&mut self, sensor: LiveSensor, t: Stamp, other: Option<Stamp>, came: Option<Instant>) {
        let others_held = self.clocks[sensor.other() as usize].held;
        // What a wrong stamp makes of it is no rule.
        let off_s = self.off_s(sensor, t).filter(|off_s| others_held == 0 && off_s.abs() <= OFF_S);
        let clock = &mut self.clocks[sensor as usize];
        let step = clock.last.map_or(0.0, |last| t.seconds_since(last));
        let goes_on = step > 0.0 && step <= OFF_S;
        // A sample after an image says that no gap had begun before it.
        if sensor == LiveSensor::Imu
            && let Some(apart) = self.apart_next.take()
            && step <= 1.5 * clock.step_s
        {
            self.apart_ns = apart;
        }
        if goes_on {
            clock.step_s = step;
            let kept = 0.5_f64.powf(step / FORGOTTEN_S);
            if let Some(off_s) = off_s {
                clock.usual_off_s = Some((kept * clock.usual_off_s.unwrap_or_default()).max(off_s.abs()));
            }
            let late_s = clock.late_s(t, came).unwrap_or_default();
            clock.usual_late_s = (kept * clock.usual_late_s).max(late_s.abs().min(OFF_S));
        }
        clock.keeps_pace(t, came);
        if let (Some(before), Some(now), true) = (clock.other, other, goes_on) {
            clock.usual_s = (0.998 * clock.usual_s).max(now.seconds_since(before).min(OFF_S));
            if sensor == LiveSensor::Camera && now > before && others_held == 0 {
                self.apart_next = Some(t.ns().saturating_sub(now.ns()));
            }
        }
        // One that is late by itself leaves the clock where it is.
        if clock.last.is_none_or(|last| t > last || last.seconds_since(t) > OFF_S) {
            (clock.last, clock.other, clock.dropped) = (Some(t), other, 0);
        }
    }

    /// The stamps of a sensor that are held back, as they were stamped, in the order in which they came.
    fn held_of(&self, sensor: LiveSensor) -> impl DoubleEndedIterator<Item = Stamp> {
        self.held.iter().filter(move |held| held.sensor == sensor).map(|held| held.raw)
    }

    /// Whether a stamp, as it was stamped, is little before its sensor's last one.
    fn is_late(&self, sensor: LiveSensor, raw: Stamp) -> bool {
        self.last(sensor)
            .is_some_and(|last| (-OFF_S..0.0).contains(&self.common(sensor, raw).seconds_since(last)))
    }

    /// Passes over what is held back of a sensor.
    fn drop_held(&mut self, sensor: LiveSensor) {
        let clock = &mut self.clocks[sensor as usize];
        let count = std::mem::take(&mut clock.held);
        clock.since = 0;
        if count == 0 {
            return;
        }
        let (first, all) = (self.held_of(sensor).next(), self.held_of(sensor).count());
        if let Some(first) = first {
            let t = self.common(sensor, first);
            let is_late = count == 1 && self.is_late(sensor, first);
            let clock = &mut self.clocks[sensor as usize];
            match clock.last {
                // It was missing in the last step, which was no step then, and nothing is missing since.
                Some(last) if is_late => clock.step_s = clock.step_s.min(last.seconds_since(t)),
                _ => clock.dropped += count,
            }
            self.pass_over(sensor, all, t);
        }
        self.held.retain(|held| held.sensor != sensor);
    }

    /// Counts messages of wrong stamps, the first of time `t`, and says so.
    fn pass_over(&mut self, sensor: LiveSensor, count: usize, t: Stamp) {
        self.passed_over += count;
        self.said += 1;
        if self.said > SHOWN {
            return;
        }
        let Clock { last, shift_ns, .. } = self.clocks[sensor as usize];
        let stamps = if count == 1 { "a stamp" } else { "stamps" };
        let off = last.map_or(0.0, |last| t.seconds_since(last));
        let raw = Stamp::from_ns(t.ns().saturating_add(shift_ns));
        self.words.push_back(format!(
            "{stamps} of the {} ({raw}, {off:+.3} s from the one before) that it does not go on from; {count} passed over",
            sensor.name()
        ));
    }

    /// Says once that a sensor's stamps stand still.
    fn stands(&mut self, sensor: LiveSensor, raw: Stamp) {
        let common = self.common(sensor, raw);
        let clock = &mut self.clocks[sensor as usize];
        clock.same = if clock.last == Some(common) { clock.same + 1 } else { 0 };
        if clock.same >= SAME && !std::mem::replace(&mut clock.standing_said, true) {
            self.words.push_back(format!(
                "the {}'s stamps stand at {raw}: its driver does not stamp its messages, and nothing can be made of them",
                sensor.name()
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::LiveSensor::{Camera, Imu};
    use super::*;
    use dpn_core::random::Stream;
    use rand::Rng as _;
    use std::time::Duration;

    /// 200 Hz and 20 Hz for so many seconds, as they are recorded; the time that is true is the message.
    fn streams(seconds: i64) -> Vec<(LiveSensor, i64, i64)> {
        let mut all = Vec::new();
        for i in 0..200 * seconds {
            let t = 5_000_000 * i + 1_000_000_000_000;
            all.push((Imu, t, t));
            if i % 10 == 4 {
                all.push((Camera, t - 3_000_000, t - 3_000_000));
            }
        }
        all
    }

    /// What comes through, and what is said.
    fn through(messages: &[(LiveSensor, i64, i64)]) -> (Vec<(LiveSensor, i64, i64)>, Vec<String>) {
        passed(messages, |_| None)
    }

    /// The same where every message comes at its true time.
    fn live(messages: &[(LiveSensor, i64, i64)]) -> (Vec<(LiveSensor, i64, i64)>, Vec<String>) {
        let begun = Instant::now();
        passed(messages, |truth| {
            Some(begun + Duration::from_nanos((truth - 1_000_000_000_000).unsigned_abs()))
        })
    }

    fn passed(
        messages: &[(LiveSensor, i64, i64)],
        came: impl Fn(i64) -> Option<Instant>,
    ) -> (Vec<(LiveSensor, i64, i64)>, Vec<String>) {
        let mut clocks = LiveClocks::default();
        let mut out = Vec::new();
        for &(sensor, raw, truth) in messages {
            let ready = clocks.take(sensor, Stamp::from_ns(raw), came(truth), truth);
            out.extend(ready.into_iter().map(|(sensor, t, truth)| (sensor, t.ns(), truth)));
        }
        clocks.end();
        (out, std::iter::from_fn(|| clocks.take_words()).collect())
    }

    /// What comes through as it came, but that of each sensor the second message lets the first one go.
    fn in_order(messages: &[(LiveSensor, i64, i64)]) -> (Vec<(LiveSensor, i64, i64)>, Vec<String>) {
        let mut all = messages.to_vec();
        for sensor in LiveSensor::ALL {
            let first = all.iter().position(|(s, ..)| *s == sensor).unwrap();
            let second = first + 1 + all[first + 1..].iter().position(|(s, ..)| *s == sensor).unwrap();
            let message = all.remove(first);
            all.insert(second - 1, message);
        }
        (all, vec![])
    }

    const HOUR: i64 = 3_600_000_000_000;

    #[test]
    fn what_is_good_or_was_not_recorded_goes_through_as_it_came_without_a_word() {
        let good = streams(6);
        assert_eq!(through(&good), in_order(&good));
        let between = |t: i64, from: i64, to: i64| (from..to).contains(&(t / 1_000_000_000 - 1000));
        for (name, lost) in [("imu", [true, false]), ("camera", [false, true]), ("both", [true, true])] {
            let gap: Vec<_> = good
                .iter()
                .copied()
                .filter(|(sensor, t, _)| !(lost[*sensor as usize] && between(*t, 1, 4)))
                .collect();
            assert_eq!(through(&gap), in_order(&gap), "{name}");
        }
        // Samples that come in batches of half a second, images later than they.
        let mut batches = good.clone();
        batches.sort_by_key(|(sensor, t, _)| (t / 500_000_000, *sensor as usize));
        assert_eq!(through(&batches), in_order(&batches));
    }

    #[test]
    fn one_wrong_stamp_is_passed_over_and_said() {
        for sensor in LiveSensor::ALL {
            for by in [HOUR, -HOUR, 2_000_000_000] {
                let mut bad = streams(4);
                let at = bad.iter().position(|(s, t, _)| *s == sensor && *t > 1_002_000_000_000).unwrap();
                bad[at].1 += by;
                let (out, said) = through(&bad);
                bad.remove(at);
                assert_eq!(out, in_order(&bad).0, "{sensor:?} {by}");
                assert_eq!(said.len(), 1, "{said:?}");
                assert!(said[0].starts_with(&format!("a stamp of the {} (", sensor.name())), "{said:?}");
            }
        }
    }

    /// Where the neighbours go on, none of them is lost for it.
    #[test]
    fn one_stamp_that_is_ahead_by_less_than_a_second_is_passed_over_alone() {
        for sensor in LiveSensor::ALL {
            let period = [5_000_000, 50_000_000][sensor as usize];
            for by in [900_000_000, 330_000_000, 8 * period] {
                let mut bad = streams(4);
                let at = bad.iter().position(|(s, t, _)| *s == sensor && *t > 1_002_000_000_000).unwrap();
                bad[at].1 += by;
                // What was lost before it does not make it right.
                for lost in [false, true] {
                    if lost {
                        let before = bad[..at].iter().rposition(|(s, ..)| *s == sensor).unwrap();
                        bad.remove(before);
                    }
                    let (out, said) = through(&bad);
                    let mut good = bad.clone();
                    good.retain(|(_, t, truth)| t == truth);
                    let sorted = |mut all: Vec<(LiveSensor, i64, i64)>| {
                        all.sort_by_key(|(sensor, t, _)| (*t, *sensor as usize));
                        all
                    };
                    assert_eq!(sorted(out), sorted(good), "{sensor:?} {by} {lost}");
                    assert!(said.len() == 1 && said[0].contains(" passed over"), "{said:?}");
                }
            }
        }
    }

    /// The last before a silence was waiting: when it came tells how the clocks go together.
    #[test]
    fn a_sensor_that_stops_after_a_loss_is_heard_again_as_it_was() {
        for sensor in LiveSensor::ALL {
            let mut gap = streams(6);
            let lost = gap.iter().position(|(s, t, _)| *s == sensor && *t > 1_001_900_000_000).unwrap();
            gap.remove(lost);
            let last = gap[lost..].iter().find(|(s, ..)| *s == sensor).unwrap().1;
            gap.retain(|(s, t, _)| *s != sensor || *t <= last || *t > 1_004_700_000_000);
            let (out, said) = through(&gap);
            assert!(
                out.len() == gap.len() && out.iter().all(|(_, t, truth)| t == truth),
                "{sensor:?}: {said:?}"
            );
            assert_eq!(said, Vec::<String>::new(), "{sensor:?}");
        }
    }

    #[test]
    fn samples_that_overtake_one_another_are_put_in_order() {
        let good = streams(3);
        let mut bad = good.clone();
        let at = bad.iter().position(|(s, t, _)| *s == Imu && *t > 1_002_000_000_000).unwrap();
        bad.swap(at, at + 1);
        assert_eq!(through(&bad), in_order(&good));
    }

    #[test]
    fn a_clock_that_is_set_alone_is_set_back_and_both_that_are_set_are_left() {
        let set = |which: &[LiveSensor], by: i64| {
            let mut all = streams(6);
            for (_, t, _) in all.iter_mut().filter(|(s, t, _)| which.contains(s) && *t > 1_003_000_000_000) {
                *t += by;
            }
            all
        };
        for sensor in LiveSensor::ALL {
            for by in [HOUR, -HOUR, 3_000_000_000, -3_000_000_000] {
                let (out, said) = through(&set(&[sensor], by));
                assert_eq!(out.len(), streams(6).len(), "{sensor:?} {by}");
                assert!(out.iter().all(|(_, t, truth)| t == truth), "{sensor:?} {by}: {said:?}");
                let words = format!("the {}'s clock was set {:.3} s ", sensor.name(), by.abs() as f64 * 1e-9);
                assert!(said.len() == 1 && said[0].starts_with(&words), "{said:?}");
            }
        }
        let both = set(&LiveSensor::ALL, HOUR);
        assert_eq!(in_order(&both), through(&both));
        // Time does not go back.
        let (out, said) = through(&set(&LiveSensor::ALL, -HOUR));
        assert!(out.iter().all(|(_, t, truth)| t == truth) && out.len() == streams(6).len(), "{said:?}");
        assert_eq!(said.len(), 1);
        assert!(
            said[0].starts_with("the IMU's and the camera's clock was set 3600.000 s back at "),
            "{said:?}"
        );
        // The first stamp may be the wrong one.
        for sensor in LiveSensor::ALL {
            let mut first = streams(4);
            let at = first.iter().position(|(s, ..)| *s == sensor).unwrap();
            first[at].1 += HOUR;
            let (out, said) = through(&first);
            assert!(said.len() == 1 && out.len() == first.len() - 1, "{said:?}");
            first.insert(at, first[at]);
            let (out, said) = through(&first);
            assert!(said.len() == 1 && out.len() == first.len() - 2, "{said:?}");
        }
        // Poses keep the IMU's own stamps.
        let mut clocks = LiveClocks::default();
        for (sensor, raw, truth) in set(&[Imu], HOUR) {
            clocks.take(sensor, Stamp::from_ns(raw), None, truth);
        }
        let [before, after] = [1_002_000_000_000, 1_005_000_000_000].map(Stamp::from_ns);
        assert_eq!(clocks.on_imu_clock(before), before);
        assert_eq!(clocks.on_imu_clock(after), Stamp::from_ns(after.ns() + HOUR));
    }

    /// The late one was missing in the step before, which is then no step, and nothing is missing since.
    #[test]
    fn a_clock_that_is_set_behind_a_late_message_is_set_back_by_as_much() {
        for by in [480_000_000, 300_000_000, -300_000_000] {
            let mut all = streams(6);
            let images: Vec<usize> =
                (0..all.len()).filter(|i| all[*i].0 == Camera && all[*i].1 > 1_003_000_000_000).collect();
            all.iter_mut().skip(images[2]).filter(|(of, ..)| *of == Camera).for_each(|(_, t, _)| *t += by);
            let late = all.remove(images[0]);
            // Behind the next one.
            all.insert(images[1], late);
            let (out, said) = through(&all);
            assert_eq!(out.len(), all.len() - 1, "{by}: {said:?}");
            assert!(out.iter().all(|(_, t, truth)| t == truth), "{by}: {said:?}");
        }
    }

    /// The one that overtook them left a long step behind.
    #[test]
    fn messages_that_are_late_twice_or_in_twos_set_no_clock() {
        for late in [vec![2, 2], vec![1, 2], vec![1, 2, 2]] {
            let mut all = streams(6);
            let images: Vec<usize> =
                (0..all.len()).filter(|i| all[*i].0 == Camera && all[*i].1 > 1_003_000_000_000).collect();
            // The first is lost, and the third overtakes those behind it.
            let behind: Vec<_> = late.iter().map(|place| all[images[*place]]).collect();
            let after = images[3] + 1;
            all.splice(after..after, behind);
            for place in [2, 1, 0] {
                all.remove(images[place]);
            }
            let (out, said) = through(&all);
            assert!(out.iter().all(|(_, t, truth)| t == truth), "{late:?}: {said:?}");
            assert!(said.iter().all(|words| words.contains(" passed over")), "{late:?}: {said:?}");
        }
    }

    /// It comes when its stamps say: it was not set, the other one was.
    #[test]
    fn a_sensor_that_was_silent_while_the_others_clock_was_set_goes_on_as_it_is() {
        for (silent, by) in [(Imu, 560_000_000), (Camera, 560_000_000), (Imu, -560_000_000)] {
            let mut all = streams(9);
            all.retain(|(of, t, _)| *of != silent || !(1_003_000_000_000..1_006_600_000_000).contains(t));
            all.iter_mut()
                .filter(|(of, t, _)| *of != silent && *t > 1_006_000_000_000)
                .for_each(|(_, t, _)| *t += by);
            let (out, said) = live(&all);
            assert!(
                out.iter().all(|(_, t, truth)| (t - truth).abs() < 60_000_000),
                "{silent:?} {by}: {said:?}"
            );
            assert_eq!(said.len(), 1, "{silent:?} {by}: {said:?}");
        }
    }

    /// Less than a second is left of the gap, as if some samples were lost.
    #[test]
    fn an_imu_whose_clock_is_set_back_while_it_is_silent_is_set_back() {
        let mut all = streams(9);
        all.retain(|(of, t, _)| *of == Camera || !(1_003_000_000_000..1_004_100_000_000).contains(t));
        all.iter_mut()
            .filter(|(of, t, _)| *of == Imu && *t > 1_004_000_000_000)
            .for_each(|(_, t, _)| *t -= 850_000_000);
        let (out, said) = live(&all);
        assert!(out.iter().all(|(_, t, truth)| (t - truth).abs() < 60_000_000), "{said:?}");
        assert!(said.len() == 1 && said[0].starts_with("the IMU's clock was set 0.8"), "{said:?}");
    }

    /// Times that come through after second 5, off by what is true.
    fn off_later(messages: &[(LiveSensor, i64, i64)]) -> Vec<(LiveSensor, i64)> {
        let late = |truth: i64| truth > 1_005_000_000_000;
        let (out, _) = through(messages);
        out.into_iter()
            .filter(|(.., truth)| late(*truth))
            .map(|(sensor, t, truth)| (sensor, t - truth))
            .collect()
    }

    /// Both streams on one time, to so many nanoseconds.
    #[track_caller]
    fn go_together(off: &[(LiveSensor, i64)], within: i64) {
        let first = off.first().expect("messages come through").1;
        assert!(
            off.iter().all(|(_, off)| (off - first).abs() <= within),
            "{:?} and {:?}",
            off[0],
            off.last()
        );
        for sensor in LiveSensor::ALL {
            assert!(off.iter().any(|(of, _)| *of == sensor), "{sensor:?} does not come through");
        }
    }

    #[test]
    fn a_clock_that_is_set_in_a_gap_is_set_back_by_what_the_other_says_went_by() {
        let between =
            |t: i64, from: i64, to: i64| (1000 * from..1000 * to).contains(&(t / 1_000_000 - 1_000_000));
        for sensor in LiveSensor::ALL {
            let mut all = streams(8);
            all.retain(|(of, t, _)| *of != sensor || !between(*t, 1, 3));
            for (_, t, _) in all.iter_mut().filter(|(of, t, _)| *of == sensor && *t > 1_002_000_000_000) {
                *t += HOUR;
            }
            go_together(&off_later(&all), 5_000_000);
        }
        // The camera is silent meanwhile, and a wrong stamp comes between.
        let mut all = streams(9);
        all.retain(|(of, t, _)| *of == Imu || !between(*t, 1, 4));
        for (_, t, truth) in all.iter_mut().filter(|(of, t, _)| *of == Imu && *t > 1_002_000_000_000) {
            *t += if *truth == 1_003_500_000_000 { 2 * HOUR } else { HOUR };
        }
        let off: Vec<_> = off_later(&all).into_iter().skip_while(|(sensor, _)| *sensor == Imu).collect();
        go_together(&off[off.len() / 2..], 5_000_000);
    }

    #[test]
    fn stamps_that_stand_still_are_said_once() {
        let zeros: Vec<_> = streams(2).into_iter().map(|(sensor, _, truth)| (sensor, 0, truth)).collect();
        let (_, said) = through(&zeros);
        assert_eq!(said.iter().filter(|words| words.contains("'s stamps stand at ")).count(), 2, "{said:?}");
        assert_eq!(said.len(), 2);
    }

    /// Losses, doubles, delays and jumps by chance: whatever comes through was put in, once, and after the last fault all of it does.
    #[test]
    fn whatever_comes_nothing_is_invented_and_good_streams_come_through_again() {
        for plan in 0..300 {
            let mut rng = Stream::new(plan).named("clock faults").rng();
            let mut all = streams(5);
            for (_, t, truth) in &mut all {
                if *truth < 1_003_000_000_000 && rng.random_bool(0.03) {
                    *t += rng.random_range(-HOUR..HOUR);
                }
            }
            all.retain(|(_, _, truth)| *truth > 1_003_000_000_000 || rng.random_bool(0.98));
            let (out, _) = through(&all);
            let last = |messages: &[(LiveSensor, i64, i64)]| {
                messages.iter().filter(|(_, _, truth)| *truth > 1_003_500_000_000).count()
            };
            assert_eq!(last(&out), last(&all), "plan {plan}");
            let mut seen = std::collections::HashSet::new();
            assert!(
                out.iter().all(|(sensor, _, truth)| seen.insert((*sensor as usize, *truth))),
                "plan {plan}"
            );
        }
    }
}
