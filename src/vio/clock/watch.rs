//! The camera's clock looked after while frames come: found before anything is built on it, followed afterwards.
//!
//! What is said at a frame is a function of the frames up to it and of samples up to its instant: pairs of frames wait until the samples reach as far beyond
//! them as an offset is looked for. So it is the same whatever came first.

use super::delay::{Delay, REACH_S, Turns};
use super::flow_turn::{FlowTurn, SharedRays};
use super::gyro_course::GyroCourse;
use super::readout::{LinePair, Readout, ReadoutMeter};
use crate::diagnosis::{Axes, Turn, compared};
use crate::frontend::turn_of_camera;
use dpn_core::camera::CameraModel;
use dpn_core::{ImuSample, Stamp, TrackFrame};
use nalgebra::UnitQuaternion;
use serde::Serialize;
use std::collections::VecDeque;

/// How far off a clock in force may be \[s\], of one that is known by the first alone: by one of them a turn is near enough to be found.
const OFFSETS_S: [f64; 5] = [0.0, -0.08, 0.08, -0.16, 0.16];
/// Pairs of frames between two looks.
const EVERY: usize = 4;
/// Fewest pairs for an answer.
const FEWEST: usize = 8;
/// Pairs that are looked at: ten seconds.
const MOST: usize = 100;
/// An answer is one where its deviation is below this \[s\], for one that is off by ten milliseconds costs a start less than none while stamps are late by fifty, ...
const TELLING_S: f64 = 0.012;
/// ... the gyroscope explains this much of the camera's turning with it, ...
const EXPLAINED: f64 = 0.65;
/// ... and no other place costs less than this share more.
const ELSEWHERE: f64 = 0.65;
/// What moves by less is not followed \[s\].
const FOLLOWED_S: f64 = 0.0005;
/// What is known so well is not looked for over all the reach again \[s\].
const KNOWN_S: f64 = 0.002;
/// A clock is off where the answer is so many deviations from zero ...
const SURE: f64 = 4.0;
/// ... and so much \[s\]: exposures and filters move stamps by less, and a window does with less.
const LEAST_S: f64 = 0.003;

/// Turns that are kept for comparison, ten minutes: beyond, the oldest go.
const KEPT_TURNS: usize = 6_000;
/// What rests on a clock that is found to be off by more is of no use \[s\].
pub(crate) const SLIGHT_S: f64 = 0.015;
/// An answer so far from the offset in force is none: what is followed does not jump \[s\].
const LEAP_S: f64 = 0.05;
/// After so many looks in a row without an answer it is looked for over all the reach again.
const LOST: usize = 10;

/// The camera's clock as a run has it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Default)]
pub struct CameraClock {
    /// What is added to the camera's stamps at the end \[s\]: below zero where they are late.
    pub offset_s: f64,
    /// How fast that grows, per second; 0 where no drift shows.
    pub drift: f64,
    /// Whether somebody gave it, and nothing was looked for.
    pub given: bool,
    /// What the turns of camera and gyroscope say it is \[s\]; none where there were too few.
    pub seen_s: Option<f64>,
    /// The deviation of that \[s\].
    pub std_s: Option<f64>,
    /// The frame after which the first offset other than zero was in force, on the camera's clock; none where zero is.
    pub found: Option<Stamp>,
}

/// Looks after the clock.
#[derive(Debug, Clone)]
pub struct ClockWatch {
    camera: CameraModel,
    cam_from_body: UnitQuaternion<f64>,
    course: GyroCourse,
    before: Option<TrackFrame>,
    /// Pairs that samples have not passed by as far as is looked.
    waiting: VecDeque<(SharedRays, Option<LinePair>)>,
    pairs: VecDeque<FlowTurn>,
    /// The last pair that samples have passed by.
    last: Option<FlowTurn>,
    new: usize,
    readout: ReadoutMeter,
    /// Of all pairs, by the clock in force.
    turns: VecDeque<Turn>,
    /// Whether an offset, be it zero, was found once: from there on it is followed.
    settled: bool,
    /// Looks in a row that saw turns and no answer.
    lost: usize,
    clock: CameraClock,
}

impl ClockWatch {
    /// With the offset given, or one to be found.
    pub fn new(camera: CameraModel, body_from_cam: UnitQuaternion<f64>, given_s: Option<f64>) -> Self {
        let offset_s = given_s.unwrap_or(0.0);
        Self {
            camera,
            cam_from_body: body_from_cam.inverse(),
            course: GyroCourse::default(),
            before: None,
            waiting: VecDeque::new(),
            pairs: VecDeque::new(),
            last: None,
            new: 0,
            readout: ReadoutMeter::default(),
            turns: VecDeque::new(),
            settled: false,
            lost: 0,
            clock: CameraClock { offset_s, given: given_s.is_some(), ..CameraClock::default() },
        }
    }

    /// What there is to say.
    pub fn clock(&self) -> CameraClock {
        self.clock
    }

    /// Pairs of frames whose turns are known.
    pub fn compared_pairs(&self) -> usize {
        self.turns.len()
    }

    /// How camera and gyroscope turn together.
    pub fn axes(&self) -> Axes {
        let turns: Vec<Turn> = self.turns.iter().copied().collect();
        compared(&turns, &self.cam_from_body.inverse())
    }

    /// How long an image's lines take to be read out, where that was found.
    pub fn readout(&self) -> Option<Readout> {
        self.readout.found()
    }

    /// A stamp of the camera on the IMU's clock, as far as is known.
    pub fn on_imu_clock(&self, t: Stamp) -> Stamp {
        t.plus_seconds(self.clock.offset_s)
    }

    /// Whether an offset was found, be it zero.
    pub(crate) fn is_known(&self) -> bool {
        self.clock.given || self.settled || self.clock.found.is_some()
    }

    /// Begins with a clock that was found to be off before the frame at `t`, the first one; one that was given stays.
    pub(crate) fn begin_at(&mut self, offset_s: f64, t: Stamp) {
        if !self.clock.given && offset_s != 0.0 {
            (self.clock.offset_s, self.clock.found) = (offset_s, Some(t));
        }
    }

    /// Takes a sample.
    pub fn feed_imu(&mut self, sample: &ImuSample) {
        self.course.push(sample);
    }

    /// Takes a frame whose samples are there; the offset in force may be another afterwards.
    pub fn feed_frame(&mut self, frame: &TrackFrame) {
        if let Some(before) = &self.before {
            self.clock.offset_s += self.clock.drift * frame.t.seconds_since(before.t);
            let shared = frame.shared(before);
            let rays = SharedRays::of((before, frame), &shared, &self.camera);
            self.waiting
                .extend(rays.map(|rays| (rays, LinePair::of((before, frame), &shared, &self.camera))));
        }
        self.before = Some(frame.clone());
        let reached = self.on_imu_clock(frame.t).plus_seconds(-REACH_S);
        while let Some((rays, lines)) = self.waiting.pop_front_if(|(rays, _)| rays.to <= reached) {
            let (from, to) = (rays.from.plus_seconds(-REACH_S), rays.to.plus_seconds(REACH_S));
            if self.course.turn(from, to).is_some()
                && let Some(pair) = self.turn_of(rays)
            {
                if let Some(lines) = lines {
                    self.readout.add(pair, lines, &self.course, self.clock.offset_s, &self.cam_from_body);
                }
                self.turns.extend(Turn::of(&pair, self.last.as_ref(), &self.course, self.clock.offset_s));
                self.last = Some(pair);
                // Until something is known, what says nothing of the clock would outvote what does.
                if self.is_known() || self.course.varies(from, to) {
                    self.pairs.push_back(pair);
                    self.new += 1;
                }
            }
        }
        while self.pairs.len() > MOST {
            self.pairs.pop_front();
        }
        while self.turns.len() > KEPT_TURNS {
            self.turns.pop_front();
        }
        let oldest = self
            .pairs
            .front()
            .map(|pair| pair.from)
            .or(self.waiting.front().map(|(rays, _)| rays.from))
            .unwrap_or(frame.t);
        self.course.forget_before(oldest.plus_seconds(-REACH_S));
        if !self.clock.given && self.new >= EVERY && self.pairs.len() >= FEWEST {
            self.new = 0;
            self.look(frame.t);
        }
        self.readout.look(frame.t, &self.camera);
    }

    /// The camera's turn over a pair, looked for near what the gyroscope turned by the clock in force, and by others where it is not known.
    fn turn_of(&self, rays: SharedRays) -> Option<FlowTurn> {
        let offsets = if self.is_known() { &OFFSETS_S[..1] } else { &OFFSETS_S };
        let foretold = offsets.iter().filter_map(|offset| {
            let clock = |t: Stamp| self.on_imu_clock(t).plus_seconds(*offset);
            let turn = self.course.turn(clock(rays.from), clock(rays.to))?;
            Some(turn_of_camera(&turn, &self.cam_from_body.inverse()))
        });
        let foretold: Vec<_> = foretold.collect();
        rays.turn(&foretold)
    }

    fn look(&mut self, t: Stamp) {
        let pairs = self.pairs.make_contiguous();
        let turns = Turns { course: &self.course, pairs, cam_from_body: self.cam_from_body };
        let found = if self.settled {
            turns.near(self.clock.offset_s, self.clock.found.is_some())
        } else {
            turns.delay()
        };
        let in_force = self.clock.offset_s;
        let leaps = |found: &Delay| self.settled && (found.offset_s - in_force).abs() > LEAP_S;
        let Some(found) = found.filter(|found| is_answer(found) && !leaps(found)) else {
            self.lost += 1;
            self.settled &= self.lost < LOST;
            return;
        };
        self.lost = 0;
        (self.clock.seen_s, self.clock.std_s) = (Some(found.offset_s), Some(found.std_s));
        self.settled |= found.std_s < KNOWN_S;
        let off = (found.offset_s - self.clock.offset_s).abs();
        let moves = match self.clock.found {
            None => off > LEAST_S.max(SURE * found.std_s),
            // What is off once is followed.
            Some(_) => off > FOLLOWED_S.max(found.std_s * if found.std_s < KNOWN_S { 1.0 } else { 2.0 }),
        };
        if moves {
            self.clock.offset_s = found.offset_s;
            self.clock.drift = found.drift;
            if off > SLIGHT_S {
                // Its rates were of other instants.
                self.readout.forget();
                let mut before = None;
                let again = self.pairs.iter().filter_map(|pair| {
                    Turn::of(pair, before.replace(*pair).as_ref(), &self.course, found.offset_s)
                });
                self.turns = again.collect();
            }
            self.clock.found.get_or_insert(t);
        }
    }
}

/// Whether a clock can be told from it.
fn is_answer(delay: &Delay) -> bool {
    delay.std_s < TELLING_S && delay.explained > EXPLAINED && delay.of_elsewhere < ELSEWHERE
}
