//! From the first frames to a window: what came in while the initialiser waited, and the start it then allows.

use super::config::EstimatorConfig;
use super::imu_buffer::Interval;
use crate::init::{Fit, InitFrame, InitOutcome, Initialised, Initialiser, WaitReason};
use crate::preint::{NoisySample, Preintegration};
use crate::state::{ImuBias, NavState};
use crate::window::Seen;
use dpn_core::Stamp;
use dpn_core::config::ConfigFault;
use dpn_core::random::Stream;
use nalgebra::Isometry3;
use std::collections::VecDeque;

/// One frame of a start: its stamp, its state, the samples since the frame before, its tracks.
#[derive(Debug, Clone)]
pub struct StartFrame {
    /// When.
    pub t: Stamp,
    /// What is believed of the body.
    pub state: NavState,
    /// Samples since the frame before; `None` for the first.
    pub preint: Option<Preintegration>,
    /// What was seen.
    pub seen: Vec<Seen>,
}

/// A frame that waits for a state.
#[derive(Debug, Clone)]
struct Waiting {
    t: Stamp,
    seen: Vec<Seen>,
    /// Since the frame before, both ends included.
    samples: Vec<NoisySample>,
}

/// Frames that wait, and the initialiser that looks at them.
#[derive(Debug, Clone)]
pub(crate) struct Starter {
    initialiser: Initialiser,
    waiting: VecDeque<Waiting>,
    longest: f64,
}

impl Starter {
    pub(crate) fn new(
        config: &EstimatorConfig,
        body_from_cam: Isometry3<f64>,
        stream: Stream,
    ) -> Result<Self, Vec<ConfigFault>> {
        let initialiser = Initialiser::new(config.init.clone(), body_from_cam, stream)?;
        // A rest in front of the frames may be longer than their span: it stays one frame.
        Ok(Self { initialiser, waiting: VecDeque::new(), longest: config.init.max_span_s + 60.0 })
    }

    /// Forgets all frames.
    pub(crate) fn reset(&mut self) {
        self.initialiser.reset();
        self.waiting.clear();
    }

    /// Takes the next frame; a gap in the samples before it makes all earlier frames useless.
    pub(crate) fn push(
        &mut self,
        config: &EstimatorConfig,
        t: Stamp,
        interval: Interval,
        seen: Vec<Seen>,
    ) -> Result<(Vec<StartFrame>, Fit), WaitReason> {
        let bearings = seen.iter().map(|s| (s.id, s.sighting.bearing)).collect();
        let gap = interval.longest_step > config.health.max_imu_gap;
        let preint = if gap || self.waiting.is_empty() {
            None
        } else {
            integrate(config, &ImuBias::zero(), &interval.samples)
        };
        if preint.is_none() {
            self.waiting.clear();
        }
        self.waiting.push_back(Waiting { t, seen, samples: interval.samples });
        while self.waiting.front().is_some_and(|w| t.seconds_since(w.t) > self.longest) {
            self.waiting.pop_front();
        }
        match self.initialiser.push_frame(InitFrame::new(t, bearings), preint) {
            InitOutcome::Wait(reason) => Err(reason),
            InitOutcome::Ready(found) => {
                let frames = self.frames(config, &found);
                self.waiting.clear();
                Ok((frames, found.fit))
            }
        }
    }

    /// The frames that got a state, the samples between them merged.
    fn frames(&mut self, config: &EstimatorConfig, found: &Initialised) -> Vec<StartFrame> {
        let mut frames: Vec<StartFrame> = Vec::with_capacity(found.frames.len());
        let mut between: Option<Preintegration> = None;
        for waiting in self.waiting.drain(..) {
            if !frames.is_empty() {
                match &mut between {
                    Some(preint) => waiting.samples.iter().skip(1).for_each(|s| preint.push(*s)),
                    None => between = integrate(config, &found.bias, &waiting.samples),
                }
            }
            if let Some(known) = found.frames.iter().find(|f| f.t == waiting.t) {
                frames.push(StartFrame {
                    t: waiting.t,
                    state: known.state,
                    preint: between.take(),
                    seen: waiting.seen,
                });
            }
        }
        frames
    }
}

/// Samples between two frames as one measurement; `None` where there are fewer than two.
pub(crate) fn integrate(
    config: &EstimatorConfig,
    bias: &ImuBias,
    samples: &[NoisySample],
) -> Option<Preintegration> {
    let (first, rest) = samples.split_first()?;
    if rest.is_empty() {
        return None;
    }
    let mut preint = Preintegration::new(config.imu, *bias, *first);
    rest.iter().for_each(|sample| preint.push(*sample));
    Some(preint)
}
