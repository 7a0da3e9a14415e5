//! The driver: takes frame after frame and tries when there is something to try on.

use super::attempt::{Expected, attempt};
use super::buffer::{Buffer, Chosen};
use super::config::{InitConfig, MIN_SPAN_S, TRY_EVERY};
use super::frame::InitFrame;
use super::outcome::{InitOutcome, Initialised, WaitReason};
use super::rest::RestWatch;
use crate::preint::Preintegration;
use dpn_core::config::{ConfigFault, Validate};
use dpn_core::random::Stream;
use nalgebra::{Isometry3, Vector3};

/// Shortest part of what is held that is tried by itself \[s\]: half of a span is rarely of whole frames.
const SHORTEST_S: f64 = 0.9 * MIN_SPAN_S;

/// Finds the first states of a flight; see [`super`].
#[derive(Debug, Clone)]
pub struct Initialiser {
    config: InitConfig,
    body_from_cam: Isometry3<f64>,
    stream: Stream,
    buffer: Buffer,
    watch: RestWatch,
    frames: u64,
    last: WaitReason,
}

impl Initialiser {
    /// An initialiser for a camera at `body_from_cam`, whose random choices come from `stream`.
    ///
    /// # Errors
    /// Settings outside their bounds, all at once.
    pub fn new(
        config: InitConfig,
        body_from_cam: Isometry3<f64>,
        stream: Stream,
    ) -> Result<Self, Vec<ConfigFault>> {
        config.validate()?;
        let needed = config.min_frames;
        Ok(Self {
            config,
            body_from_cam,
            stream,
            buffer: Buffer::default(),
            watch: RestWatch::default(),
            frames: 0,
            last: WaitReason::TooFewFrames { frames: 0, needed },
        })
    }

    /// Forgets all frames.
    pub fn reset(&mut self) {
        self.buffer = Buffer::default();
        self.watch = RestWatch::default();
        self.last = WaitReason::TooFewFrames { frames: 0, needed: self.config.min_frames };
    }

    /// Takes the next frame and the IMU from the frame before to it (`None` for the first, or where the IMU has a gap: what was held
    /// is then forgotten), and says whether that makes a first estimate.
    ///
    /// Between tries the last reason to wait is repeated. After `Ready` it starts anew.
    pub fn push_frame(&mut self, frame: InitFrame, preint: Option<Preintegration>) -> InitOutcome {
        if preint.is_none() {
            self.reset();
        }
        let rate = preint.as_ref().map_or(0.0, |p| mean_gyro(std::iter::once(p)).unwrap_or_default().norm());
        let rest = self.watch.push(&frame, rate, &self.config);
        self.buffer.push(frame, preint, &self.config);
        self.frames += 1;
        if let Some(rest) = &rest {
            self.buffer.mark(rest);
        }
        let resting = self.resting_gyro_bias();
        if let (Some(rest), Some(_)) = (rest.filter(|r| r.lasts), resting) {
            return self.wait(WaitReason::AtRest { seconds: rest.seconds });
        }
        if self.buffer.len() < self.config.min_frames || self.buffer.span() < MIN_SPAN_S {
            let needed = self.config.min_frames.max(self.buffer.len() + 1);
            return self.wait(WaitReason::TooFewFrames { frames: self.buffer.len(), needed });
        }
        if !self.frames.is_multiple_of(TRY_EVERY) {
            return InitOutcome::Wait(self.last);
        }
        let tried = |held: &Buffer| self.attempt(&held.choose(&self.config), resting);
        let found = tried(&self.buffer).or_else(|reason| match reason {
            // Fast motion breaks tracks: half of the span holds more that all frames see, and half of that.
            WaitReason::NoStructure { .. } | WaitReason::TooFewTracks { .. } => {
                std::iter::successors(Some(self.buffer.latest_half()), |held| Some(held.latest_half()))
                    .take_while(|held| held.span() >= SHORTEST_S)
                    .find_map(|held| tried(&held).ok())
                    .ok_or(reason)
            }
            _ => Err(reason),
        });
        match found {
            Ok(found) => {
                self.reset();
                InitOutcome::Ready(Box::new(found))
            }
            Err(reason) => self.wait(reason),
        }
    }

    /// The gyro's bias as its mean over the frames held that are at rest \[rad/s\]; `None` while there are none.
    pub fn resting_gyro_bias(&self) -> Option<Vector3<f64>> {
        mean_gyro(self.buffer.resting())
    }

    fn attempt(
        &self,
        chosen: &Chosen<'_>,
        gyro_at_rest: Option<Vector3<f64>>,
    ) -> Result<Initialised, WaitReason> {
        if chosen.frames.len() < self.config.min_frames || chosen.preints.len() + 1 != chosen.frames.len() {
            let needed = self.config.min_frames;
            return Err(WaitReason::TooFewFrames { frames: chosen.frames.len(), needed });
        }
        let stream = self.stream.named("init").index(self.frames);
        attempt(chosen, &Expected { gyro_at_rest }, &self.body_from_cam, &self.config, &stream)
    }

    fn wait(&mut self, reason: WaitReason) -> InitOutcome {
        self.last = reason;
        InitOutcome::Wait(reason)
    }
}

/// Mean over the samples of intervals; `None` without a sample.
fn mean_gyro<'a>(intervals: impl Iterator<Item = &'a Preintegration>) -> Option<Vector3<f64>> {
    let (mut sum, mut count) = (Vector3::zeros(), 0usize);
    for sample in intervals.flat_map(Preintegration::samples) {
        sum += Vector3::from(sample.sample.gyro);
        count += 1;
    }
    (count > 0).then(|| sum / count as f64)
}
