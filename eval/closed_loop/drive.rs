//! One run of the estimator over one recording.

use super::error::{ClosedLoopError, OfSequence};
use super::image_report::ImageReport;
use super::images::ImageStream;
use super::recording::{Recording, Span};
use super::sequence_fault::SequenceFault;
use super::tracking_log::TrackingLog;
use super::walk::{SampleWalk, Step, walk};
use cpu_time::ThreadTime;
use dpn_core::trajectory::StampedPose;
use dpn_core::{ImuNoise, ImuSample, NoiseTrack, Stamp, TrackFrame};
use dpn_live::pass_over_spikes;
use dpn_vio::diagnosis::Axes;
use dpn_vio::estimator::{Estimator, EstimatorConfig, FeedError, FrontEndObserver, RunReport, Update};
use dpn_vio::preint::NoisySample;
use dpn_vio::window::Window;
use nalgebra::Matrix6;
use std::cell::Cell;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Fewest frames with samples that are worth a run.
pub const FEWEST_FRAMES: usize = 20;

/// What a run left.
#[derive(Debug, Clone)]
pub struct EstimatorOutput {
    /// One a frame that was worked off.
    pub updates: Vec<Update>,
    /// The estimator's own totals.
    pub report: RunReport,
    /// Camera against gyroscope.
    pub axes: Axes,
    /// CPU time of the whole run on its thread, feeding included, the front-end not \[s\].
    pub cpu_s: f64,
    /// CPU time of each update \[s\].
    pub update_cpu_s: Vec<f64>,
    /// From the first to the last frame handed over \[s\].
    pub data_s: f64,
    /// Stamps of the frames handed over.
    pub frames: Vec<Stamp>,
}

impl EstimatorOutput {
    /// The estimated trajectory: the newest pose at every frame that has one, as it was known then.
    pub fn poses(&self) -> Vec<StampedPose> {
        let pose = |u: &Update| Some(StampedPose { t: u.t, world_from_body: u.state?.world_from_body });
        self.updates.iter().filter_map(pose).collect()
    }

    /// What was in force of the noise `told`: times the levels learned, each from its frame on.
    pub(super) fn in_force(&self, told: Arc<NoiseTrack>) -> Arc<NoiseTrack> {
        if self.updates.iter().all(|update| update.levels.is_none()) {
            return told;
        }
        let mut updates = self.updates.iter().peekable();
        let mut levels = None;
        let noises = told.stamps().iter().zip(told.noises()).map(|(t, noise)| {
            while let Some(update) = updates.next_if(|update| update.t <= *t) {
                levels = update.levels.as_deref().or(levels);
            }
            levels.map_or(*noise, |levels| {
                levels.inertial.applied_to(noise).expect("levels are bounded factors of noise that is told")
            })
        });
        Arc::new(told.with_noises(noises.collect()))
    }

    /// Covariances of the poses, where every pose has one.
    pub fn covariances(&self) -> Option<Vec<Matrix6<f64>>> {
        self.updates.iter().filter(|u| u.state.is_some()).map(|u| u.covariance.as_deref().copied()).collect()
    }
}

/// The frames within `span`, having checked that there are samples for them.
///
/// # Errors
/// Fewer than [`FEWEST_FRAMES`] left, or within the samples.
pub fn frames_from<'a>(
    recording: &Recording,
    frames: &'a [TrackFrame],
    span: &Span,
) -> Result<&'a [TrackFrame], ClosedLoopError> {
    let stamps: Vec<Stamp> = frames.iter().map(|frame| frame.t).collect();
    enough(recording, &stamps, span)?;
    Ok(span.of(frames, |frame| frame.t))
}

/// The same of the frames' stamps alone.
pub(super) fn enough(recording: &Recording, stamps: &[Stamp], span: &Span) -> Result<(), ClosedLoopError> {
    let nothing_left = |seconds| {
        let Span { from_s, to_s } = *span;
        SequenceFault::NothingLeft { seconds, from_s, to_s, needed: FEWEST_FRAMES }.of(&recording.name)
    };
    let (Some(&first), Some(&last)) = (stamps.first(), stamps.last()) else { return Err(nothing_left(0.0)) };
    if stamps.len() < FEWEST_FRAMES {
        return Err(nothing_left(last.seconds_since(first)));
    }
    let samples = recording.imu.samples();
    let (imu_first, imu_last) = (samples[0].t, samples[samples.len() - 1].t);
    let inside = |stamps: &[Stamp]| stamps.iter().filter(|t| (imu_first..=imu_last).contains(t)).count();
    if inside(stamps) < FEWEST_FRAMES {
        let apart = SequenceFault::Apart {
            frames: stamps.len(),
            first_ns: first.ns(),
            last_ns: last.ns(),
            imu_first_ns: imu_first.ns(),
            imu_last_ns: imu_last.ns(),
            needed: FEWEST_FRAMES,
        };
        return Err(apart.of(&recording.name));
    }
    if inside(span.of(stamps, |t| *t)) < FEWEST_FRAMES {
        return Err(nothing_left(last.seconds_since(first)));
    }
    Ok(())
}

/// Runs the estimator over frames of tracks, samples with their noise beside; every update is taken as soon as it can be had.
///
/// `noise` has a value at each of the recording's samples; `seed` is the estimator's.
///
/// # Errors
/// Settings out of their bounds; frames whose stamps do not increase.
///
/// # Panics
/// Without frames: [`frames_from`] says whether there are enough.
pub fn drive(
    config: &EstimatorConfig,
    recording: &Recording,
    frames: &[TrackFrame],
    noise: &NoiseTrack,
    seed: u64,
) -> Result<EstimatorOutput, ClosedLoopError> {
    drive_tracks(config, recording, frames, noise, seed, &mut |_, _| ControlFlow::Continue(()))
}

/// Is shown every update and the window it left; may end the run, which is [`SequenceFault::RunStopped`].
pub type UpdateWatch<'a> = dyn FnMut(&Update, &Window) -> ControlFlow<()> + 'a;

/// [`drive`], watched.
pub(super) fn drive_tracks(
    config: &EstimatorConfig,
    recording: &Recording,
    frames: &[TrackFrame],
    noise: &NoiseTrack,
    seed: u64,
    watch: &mut UpdateWatch<'_>,
) -> Result<EstimatorOutput, ClosedLoopError> {
    let mut run = Run::new(config, recording, noise, seed)?;
    let first = frames.first().expect("there is no run without frames");
    let mut samples = SampleWalk::of_camera(recording.imu.samples(), first.t);
    for frame in frames {
        for place in samples.until(frame.t) {
            run.feed_sample(place).of_sequence(&recording.name)?;
        }
        run.estimator.feed_frame(frame.clone()).of_sequence(&recording.name)?;
        if run.take_updates(watch).is_break() {
            return Err(SequenceFault::RunStopped.of(&recording.name));
        }
    }
    Ok(run.finish(frames.iter().map(|frame| frame.t).collect()))
}

/// The same over images, which the estimator's own front-end follows points through while `observer` looks on: what [`drive`] makes of the
/// tracks that `keep` is handed, bit by bit.
///
/// # Errors
/// Settings out of their bounds; none of the first images can be read, or none of all shows anything.
pub(super) fn drive_images(
    config: &EstimatorConfig,
    recording: &Recording,
    images: ImageStream<'_>,
    noise: &NoiseTrack,
    seed: u64,
    (observer, watch): (&mut dyn FrontEndObserver, &mut UpdateWatch<'_>),
    keep: &mut dyn FnMut(&TrackFrame),
) -> Result<(EstimatorOutput, ImageReport), ClosedLoopError> {
    let mut run = Run::new(config, recording, noise, seed)?;
    let mut stamps = Vec::new();
    let mut keep = |frame: &TrackFrame| {
        stamps.push(frame.t);
        keep(frame);
    };
    let mut log = TrackingLog::new(observer, &mut keep);
    let stopped = Cell::new(false);
    let images = Box::new(images.take_while(|_| !stopped.get()));
    walk(recording, images, &mut log, |step, log| {
        match step {
            Step::Sample(place) => run.feed_sample(place)?,
            Step::SamplesEnd => run.estimator.end_imu(),
            Step::Image(t, image) => {
                run.estimator.feed_image(image.view(), t)?;
                let clock = ThreadTime::now();
                run.estimator.track_images(log);
                run.tracking_s += clock.elapsed().as_secs_f64();
                stopped.set(run.take_updates(watch).is_break());
            }
            Step::ImagesEnd => {
                run.estimator.end_images();
                run.estimator.track_images(log);
                stopped.set(stopped.get() || run.take_updates(watch).is_break());
            }
        }
        Ok(())
    })?;
    if stopped.get() {
        return Err(SequenceFault::RunStopped.of(&recording.name));
    }
    let images = log.finish(recording)?;
    Ok((run.finish(stamps), images))
}

/// A run under way.
struct Run<'a> {
    estimator: Estimator,
    samples: &'a [ImuSample],
    noises: &'a [ImuNoise],
    updates: Vec<Update>,
    update_cpu_s: Vec<f64>,
    clock: ThreadTime,
    /// CPU time of the front-end and of who looked on \[s\].
    tracking_s: f64,
}

impl<'a> Run<'a> {
    fn new(
        config: &EstimatorConfig,
        recording: &'a Recording,
        noise: &'a NoiseTrack,
        seed: u64,
    ) -> Result<Self, ClosedLoopError> {
        let (camera, body_from_cam) = (recording.camera, recording.body_from_cam);
        let estimator = Estimator::new(config.clone(), camera, body_from_cam, seed);
        Ok(Self {
            estimator: estimator.map_err(ClosedLoopError::Config)?,
            samples: recording.imu.samples(),
            noises: noise.noises(),
            updates: Vec::new(),
            update_cpu_s: Vec::new(),
            clock: ThreadTime::now(),
            tracking_s: 0.0,
        })
    }

    fn feed_sample(&mut self, place: usize) -> Result<(), FeedError> {
        let sample = NoisySample { sample: self.samples[place], noise: self.noises[place] };
        pass_over_spikes(self.estimator.feed_imu(sample))
    }

    /// Takes every update there is, until `watch` wants no more.
    fn take_updates(&mut self, watch: &mut UpdateWatch<'_>) -> ControlFlow<()> {
        loop {
            let clock = ThreadTime::now();
            let Some(update) = self.estimator.next_update() else { return ControlFlow::Continue(()) };
            self.update_cpu_s.push(clock.elapsed().as_secs_f64());
            let wanted = watch(&update, self.estimator.window());
            self.updates.push(update);
            wanted?;
        }
    }

    /// What the run left over frames with these stamps.
    fn finish(self, frames: Vec<Stamp>) -> EstimatorOutput {
        let (first, last) = frames.first().zip(frames.last()).expect("there is no run without frames");
        EstimatorOutput {
            cpu_s: self.clock.elapsed().as_secs_f64() - self.tracking_s,
            updates: self.updates,
            report: self.estimator.report().clone(),
            axes: self.estimator.images().turns().axes(),
            update_cpu_s: self.update_cpu_s,
            data_s: last.seconds_since(*first),
            frames,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{RunInfo, SequenceSet, TrackSource, TruthKind, judge};
    use super::*;
    use crate::noise::{Fresh, Recorded, track};
    use dpn_core::estimate::NoiseSpec;
    use dpn_core::random::Stream;
    use dpn_testing::packs;
    use dpn_vio::estimator::BiasJump;
    use dpn_vio::window::Handover;

    /// V2_03 loses all its tracks five times within five seconds, and its truth is 2.5 ms late. Told half the usual noise, jumps of the biases were found there
    /// that are none, and the run was lost by 17 m. Where each sighting counts once, some of less than 1 m/s^2 are found still; they do no harm: at x1 the error is .255 m with one, .256 m without.
    #[test]
    fn tracks_that_are_lost_again_and_again_lose_no_run_to_jumps_of_the_biases() {
        let Some([euroc, tracks]) = packs(["euroc", "tracks"]) else { return };
        let tracks = TrackSource::File(tracks.join("V2_03_difficult.txt"));
        let source = SequenceSet::one(&euroc.join("V2_03_difficult"), tracks).unwrap();
        let recording = source.recording(0, 0).unwrap();
        // The clock as the tracks have it: followed, it leaves a jump of .15 m/s^2 in the first of these runs, which does no harm either.
        let mut config = EstimatorConfig::default();
        config.front_end.time_offset_s = Some(0.0);
        let mut twice = config.clone();
        twice.window.handover = Handover::Reuse;
        twice.delayed.enabled = false;
        let camera = source.camera_input(0, 0, &Span::from(0.0)).unwrap();
        let tracked = camera.tracks(&recording, &config.front_end, 0).unwrap();
        let recorded = Recorded { name: &recording.name, imu: &recording.imu, oracle: None };
        for (spec, config, most_jumps) in [("x0.5", &twice, 0), ("x0.5", &config, 4), ("x1", &config, 1)] {
            let noise: NoiseSpec = spec.parse().unwrap();
            let fresh = Fresh { recorded, networks: &[] };
            let told = track(&noise, &recording.imu, &fresh, &Stream::new(0)).unwrap();
            let driven = drive(config, &recording, tracked.run(), &told, 0).unwrap();
            let jumps: Vec<_> = driven.updates.iter().filter_map(|update| update.jump.as_deref()).collect();
            assert!(jumps.len() <= most_jumps, "{spec}: {jumps:?}");
            let size = |jump: &BiasJump| jump.accel.iter().map(|a| a * a).sum::<f64>().sqrt();
            assert!(jumps.iter().all(|jump| size(jump) < 1.0), "{spec}: {jumps:?}");
            assert_eq!(driven.report.restarts.len(), 0, "{spec}");
            let info = RunInfo {
                camera: "tracks".into(),
                truth: TruthKind::Published,
                noise,
                seed: 0,
                from_s: 0.0,
                to_s: None,
                front_end: None,
            };
            let ate = judge(&recording, &info, &driven).unwrap().row.ate_se3.unwrap();
            assert!(ate < 0.4, "{spec}: {ate} m");
        }
    }
}
