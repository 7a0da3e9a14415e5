//! How far the whole is: behind the note of a stage's step stand the share of the paper that is done, and about how long the rest takes.
//!
//! The unit is a run on camera tracks. A run on images counts as one and a half, a set of windows of the open loop as seven, a figure as a half: as they
//! took on two cores. What was kept from an earlier call costs nothing, so the pace is that of what was made.

use super::error::PaperError;
use super::paper::Paper;
use super::results::PaperLoop;
use dpn_core::estimate::NoiseSpec;
use dpn_core::progress::Progress;
use std::time::Instant;

/// Units of a step of a stage, and steps as foreseen.
pub(super) type Foreseen = (f64, u64);

/// A [`Progress`] that hands everything on and speaks of the whole beside.
pub(super) struct Overall<'a> {
    inner: &'a mut dyn Progress,
    stages: Vec<Foreseen>,
    /// The stage that is worked on, and its steps behind us.
    stage: usize,
    done: Option<u64>,
    /// Units made in this call.
    made: f64,
    clock: Instant,
}

impl<'a> Overall<'a> {
    pub(super) fn new(inner: &'a mut dyn Progress, stages: Vec<Foreseen>) -> Self {
        Self { inner, stages, stage: 0, done: None, made: 0.0, clock: Instant::now() }
    }

    /// The stages before this one are over.
    pub(super) fn enter(&mut self, stage: usize) {
        self.stage = stage.min(self.stages.len() - 1);
        self.done = None;
    }

    /// Share of the whole behind us, and the seconds left at this pace; no seconds before there is one.
    fn outlook(&self, elapsed_s: f64) -> (f64, Option<f64>) {
        let units =
            |stages: &[Foreseen]| stages.iter().map(|(unit, steps)| unit * *steps as f64).sum::<f64>();
        let (unit, all) = (self.stages[self.stage].0, units(&self.stages));
        let behind = units(&self.stages[..self.stage]) + unit * self.done.unwrap_or(0) as f64;
        let left = (all - behind).max(0.0);
        // The first steps of a stage share what they need, and tell little.
        (behind / all.max(1.0), (self.made >= 4.0).then(|| left * elapsed_s / self.made))
    }
}

impl Progress for Overall<'_> {
    fn start(&mut self, what: &str, total: u64) {
        self.stages[self.stage].1 = total;
        self.inner.start(what, total);
    }

    fn step(&mut self, done: u64, note: &str) {
        // What was there before the first step was kept.
        let before = self.done.unwrap_or_else(|| done.saturating_sub(1));
        self.made += self.stages[self.stage].0 * done.saturating_sub(before) as f64;
        self.done = Some(done);
        let (share, left_s) = self.outlook(self.clock.elapsed().as_secs_f64());
        let left = left_s.map_or_else(String::new, |s| format!(", about {:.0} min left", (s / 60.0).ceil()));
        self.inner.step(done, &format!("{note}; whole paper {:.0} %{left}", 100.0 * share));
    }

    fn finish(&mut self, note: &str) {
        self.inner.finish(note);
    }
}

impl Paper<'_> {
    /// The stages that tell of progress, in order: open loop, closed loop, every course, figures.
    pub(super) fn foreseen(&self) -> Result<Vec<Foreseen>, PaperError> {
        let mut stages = vec![(7.0, 4 * self.plan.bases.len() as u64)];
        for closed in self.requests() {
            let PaperLoop { experiment, source, count, .. } = closed?;
            let of = |noises: &[NoiseSpec], seeds: u64| noises.len() as u64 * seeds;
            let cells =
                of(&experiment.noises, experiment.seeds) + of(&experiment.others, experiment.other_seeds);
            stages.push((if source.camera() == "tracks" { 1.0 } else { 1.5 }, cells * count as u64));
        }
        stages.push((0.5, 13));
        Ok(stages)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Default)]
    struct Heard(Vec<String>);

    impl Progress for Heard {
        fn start(&mut self, what: &str, total: u64) {
            self.0.push(format!("{what} {total}"));
        }
        fn step(&mut self, done: u64, note: &str) {
            self.0.push(format!("{done} {note}"));
        }
        fn finish(&mut self, note: &str) {
            self.0.push(note.to_owned());
        }
    }

    #[test]
    fn the_whole_is_told_beside_the_stage_and_what_was_kept_has_no_pace() {
        let mut heard = Heard::default();
        let mut overall = Overall::new(&mut heard, vec![(1.0, 10), (3.0, 20), (1.0, 30)]);
        overall.enter(1);
        // Twice as many steps as foreseen; eleven of them were kept.
        overall.start("closed loop", 40);
        for done in 12..=16 {
            overall.step(done, "fine");
        }
        assert!((overall.made - 15.0).abs() < 1e-12);
        let (share, left_s) = overall.outlook(30.0);
        assert!((share - (10.0 + 48.0) / 160.0).abs() < 1e-12, "{share}");
        assert!((left_s.unwrap() - 102.0 * 30.0 / 15.0).abs() < 1e-9, "{left_s:?}");
        overall.finish("done");
        overall.enter(2);
        assert!(overall.outlook(30.0).0 > share);
        assert_eq!(heard.0[..2], ["closed loop 40", "12 fine; whole paper 29 %"]);
        assert!(heard.0[5].starts_with("16 fine; whole paper 36 %, about "), "{:?}", heard.0);
        assert_eq!(heard.0[6], "done");
    }
}
