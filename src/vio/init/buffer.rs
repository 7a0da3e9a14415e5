//! The frames looked back on, the IMU between them, and the few that are chosen for an estimate.

use super::config::InitConfig;
use super::frame::InitFrame;
use super::rest::Rest;
use crate::preint::Preintegration;

/// A frame and what led to it.
#[derive(Debug, Clone)]
struct Held {
    frame: InitFrame,
    /// From the frame before; none for the oldest.
    preint: Option<Preintegration>,
    at_rest: bool,
}

/// Frames of the last seconds, oldest first.
#[derive(Debug, Clone, Default)]
pub(super) struct Buffer {
    held: Vec<Held>,
}

/// Frames chosen from the buffer.
#[derive(Debug, Clone)]
pub(super) struct Chosen<'a> {
    /// Oldest first, the newest of the buffer last.
    pub frames: Vec<&'a InitFrame>,
    /// Whether each stands still.
    pub at_rest: Vec<bool>,
    /// The IMU between consecutive chosen frames.
    pub preints: Vec<Preintegration>,
}

impl Buffer {
    /// Takes the next frame with the IMU since the last; frames beyond the longest span leave.
    ///
    /// Without `preint` nothing connects the frame with what is held: that is forgotten.
    pub(crate) fn push(&mut self, frame: InitFrame, preint: Option<Preintegration>, config: &InitConfig) {
        if preint.is_none() {
            self.held.clear();
        }
        let newest = frame.t;
        self.held.push(Held { frame, preint, at_rest: false });
        let old = self
            .held
            .iter()
            .take_while(|h| newest.seconds_since(h.frame.t) > config.max_span_s + 1e-6)
            .count();
        self.held.drain(..old);
        if let Some(oldest) = self.held.first_mut() {
            oldest.preint = None;
        }
    }

    /// Marks the frames of a rest.
    pub(crate) fn mark(&mut self, rest: &Rest) {
        for held in &mut self.held {
            if held.frame.t >= rest.from && held.frame.t <= rest.to {
                held.at_rest = true;
            }
        }
    }

    /// The later half of the span.
    pub(crate) fn latest_half(&self) -> Self {
        let mut held = self.held.clone();
        let from = self.held.last().map(|h| h.frame.t.plus_seconds(-0.5 * self.span()));
        held.retain(|h| from.is_none_or(|from| h.frame.t >= from));
        if let Some(oldest) = held.first_mut() {
            oldest.preint = None;
        }
        Self { held }
    }

    /// Number of frames.
    pub(crate) fn len(&self) -> usize {
        self.held.len()
    }

    /// From the oldest frame to the newest \[s\].
    pub(crate) fn span(&self) -> f64 {
        match (self.held.first(), self.held.last()) {
            (Some(first), Some(last)) => last.frame.t.seconds_since(first.frame.t),
            _ => 0.0,
        }
    }

    /// The IMU between frames at rest, oldest first.
    pub(crate) fn resting(&self) -> impl Iterator<Item = &Preintegration> {
        let pairs = self.held.windows(2).filter(|pair| pair[0].at_rest && pair[1].at_rest);
        pairs.filter_map(|pair| pair[1].preint.as_ref())
    }

    /// Frames for an estimate: of a rest its first and its last, of the others as many as there is room for, evenly in order, and
    /// the newest.
    pub(crate) fn choose(&self, config: &InitConfig) -> Chosen<'_> {
        let inner = |k: usize| {
            // Inside a rest nothing happens: its ends tell all.
            k > 0
                && k + 1 < self.held.len()
                && self.held[k - 1].at_rest
                && self.held[k].at_rest
                && self.held[k + 1].at_rest
        };
        let candidates: Vec<usize> = (0..self.held.len()).filter(|k| !inner(*k)).collect();
        let room = config.max_frames.min(candidates.len());
        let mut picked: Vec<usize> = if room < 2 {
            candidates.clone()
        } else {
            (0..room)
                .map(|k| candidates[(k * (candidates.len() - 1) + (room - 1) / 2) / (room - 1)])
                .collect()
        };
        picked.dedup();
        let mut preints = Vec::with_capacity(picked.len());
        for pair in picked.windows(2) {
            let mut between = self.held[pair[0] + 1..=pair[1]].iter().filter_map(|h| h.preint.as_ref());
            let Some(mut merged) = between.next().cloned() else { continue };
            between.for_each(|next| merged.append(next));
            preints.push(merged);
        }
        Chosen {
            frames: picked.iter().map(|k| &self.held[*k].frame).collect(),
            at_rest: picked.iter().map(|k| self.held[*k].at_rest).collect(),
            preints,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::init::tests::{Scene, gentle_flight};
    use dpn_core::time::Stamp;

    fn filled(frames: usize) -> (Buffer, Scene, InitConfig) {
        let config = InitConfig { max_span_s: 2.0, max_frames: 6, ..InitConfig::default() };
        let scene = Scene::new(&gentle_flight(1), frames, 0.1, 0.0, 1);
        let mut buffer = Buffer::default();
        for (k, frame) in scene.frames.iter().enumerate() {
            buffer.push(frame.clone(), k.checked_sub(1).map(|p| scene.preints[p].clone()), &config);
        }
        (buffer, scene, config)
    }

    #[test]
    fn the_chosen_span_what_is_held_and_their_imu_is_without_gaps() {
        let (buffer, scene, config) = filled(30);
        assert_eq!(buffer.len(), 21);
        let chosen = buffer.choose(&config);
        assert_eq!(chosen.frames.len(), 6);
        assert_eq!(chosen.frames[0].t, scene.frames[9].t);
        assert_eq!(chosen.frames[5].t, scene.frames[29].t);
        for (pair, preint) in chosen.frames.windows(2).zip(&chosen.preints) {
            assert!((preint.duration() - pair[1].t.seconds_since(pair[0].t)).abs() < 1e-9);
        }
    }

    #[test]
    fn of_a_rest_its_ends_are_chosen() {
        let (mut buffer, scene, config) = filled(20);
        let at = |k: usize| scene.frames[k].t;
        buffer.mark(&Rest { from: at(0), to: at(12), lasts: false, seconds: 1.2, moved: 1e-3 });
        let chosen = buffer.choose(&config);
        assert_eq!(chosen.frames.len(), 6);
        // Nine candidates are left for six places: 0, 12, 13, .. 19.
        assert_eq!(chosen.frames.iter().filter(|f| f.t > at(0) && f.t < at(12)).count(), 0);
        assert!(chosen.at_rest[0] && !chosen.at_rest[2..].contains(&true));
    }

    #[test]
    fn a_frame_that_nothing_leads_to_starts_anew() {
        let (mut buffer, _, config) = filled(10);
        buffer.push(InitFrame::new(Stamp::from_ns(9_000_000_000), Vec::new()), None, &config);
        assert_eq!((buffer.len(), buffer.span()), (1, 0.0));
    }
}
