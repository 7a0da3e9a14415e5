//! One recording through the estimator, with everything a person wants to know of it.

use super::cell_run::{noise_stream, run_on_tracks};
use super::drive::{EstimatorOutput, UpdateWatch, drive_images, enough, frames_from};
use super::error::ClosedLoopError;
use super::frame_log::{FrameLog, SeenFrame};
use super::image_report::{ImageEvent, ImageReport};
use super::judge::{RunInfo, judge, noise_rms};
use super::learned::{LearnedLevels, LearnedNoise};
use super::recording::{Recording, Span};
use super::rhythm::Rhythm;
use super::row::{Row, TruthKind};
use super::scale_known::ScaleKnown;
use super::sequence_fault::SequenceFault;
use super::tracking::CameraInput;
use crate::noise::{Fresh, Recorded};
use dpn_core::check::{CheckOptions, Gap, RecordingFault, check, is_made_up};
use dpn_core::estimate::NoiseSpec;
use dpn_core::{ImuRecording, NoiseTrack, Stamp, TrackFrame};
use dpn_live::{gravity_warning, settings_for};
use dpn_pronet::network::Network;
use dpn_vio::EstimatorConfig;
use dpn_vio::clock::{CameraClock, Readout};
use dpn_vio::diagnosis::{Axes, TrackHealth};
use dpn_vio::estimator::{BiasJump, Doubt, FrontEndObserver, Phase, doubts, doubts_warning};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// Tracks that cover less than this share of the samples' time are worth a word.
const COVERED: f64 = 0.5;
/// So many of the events in images are said; all are in the report.
const SHOWN_EVENTS: usize = 8;
/// Brightness that changes by a larger share from image to image is no exposure that follows the light.
const MOST_FLICKER: f64 = 0.05;

/// An IMU that gives fewer samples a second is worth a word.
const SLOW_IMU_HZ: f64 = 80.0;

/// One run, judged.
#[derive(Debug, Clone)]
pub struct JudgedRun {
    /// The figures.
    pub report: Report,
    /// What the estimator left.
    pub output: EstimatorOutput,
    /// The noise in force: what it was told, times the levels it learned.
    pub noise: Arc<NoiseTrack>,
    /// The frames that were run.
    pub frames: Vec<SeenFrame>,
}

impl JudgedRun {
    /// What `dpn run --json` prints; `program` says which build, `input` has the checksum of what was read where it was read from files.
    pub fn json(
        &self,
        program: &str,
        estimator: &EstimatorConfig,
        input: Option<&str>,
        (camera_is_simulated, truth): (bool, TruthKind),
    ) -> Value {
        serde_json::json!({
            "program": program, "estimator": estimator, "input": input, "camera_is_simulated": camera_is_simulated,
            "truth": truth, "report": self.report,
        })
    }
}

/// What is said of a run.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// The row, as in a sweep.
    pub row: Row,
    /// What the input looks like, in sentences; empty where all is well.
    pub warnings: Vec<String>,
    /// What speaks against believing the run; empty where nothing does.
    pub doubts: Vec<Doubt>,
    /// Camera against gyro.
    pub axes: Axes,
    /// The camera's clock against the IMU's.
    pub clock: CameraClock,
    /// How long an image's lines take to be read out, where that was found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub readout: Option<Readout>,
    /// Tracks from frame to frame.
    pub tracks: TrackHealth,
    /// What was wrong with images, in time; empty without images.
    pub images: Vec<ImageEvent>,
    /// Frames before the first sample; left out.
    pub skipped: usize,
    /// What the initialisation waited for, and at how many frames.
    pub waited_for: BTreeMap<String, usize>,
    /// Relative standard deviation of the scale of the last pose, as the window believes; large also where the body hardly moves. It is too sure.
    pub scale_std: Option<f64>,
    /// From when on the scale was known, by how well.
    pub scale_known: Vec<ScaleKnown>,
    /// Jumps of the biases that were found; empty where there is none.
    pub bias_jumps: Vec<BiasJump>,
    /// How far the lens was found to be off its calibration, root mean square over the points last seen \[px\]; none where that is not learned.
    pub lens_px: Option<f64>,
    /// By what the noise told is multiplied at the end, where that is learned.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub learned: Option<LearnedLevels>,
    /// The same as figures of the IMU, over the run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub learned_noise: Option<LearnedNoise>,
    /// Root mean square of the noise in force: accelerometer x, y, z \[m/s^2\], gyroscope x, y, z \[rad/s\].
    pub noise_rms: [[f64; 3]; 2],
}

impl Report {
    /// Whether something speaks against believing the run.
    pub fn is_doubted(&self) -> bool {
        !self.doubts.is_empty() || self.axes.warning().is_some()
    }
}

/// Who looks on.
pub struct Watchers<'a> {
    /// While points are followed through images.
    pub images: &'a mut dyn FrontEndObserver,
    /// At every update.
    pub updates: &'a mut UpdateWatch<'a>,
}

/// Runs the estimator over what `camera` sees, with `noise` given: one cell of an experiment, watched.
///
/// # Errors
/// Noise that cannot be had; images that cannot be, or show nothing; tracks that share no time with the samples or whose ids do not stay with
/// points; settings out of their bounds; a run that was not wanted any more.
pub fn watched_run(
    config: &EstimatorConfig,
    recording: &Recording,
    camera: CameraInput<'_>,
    spec: &NoiseSpec,
    info: RunInfo,
    networks: &[Network],
    Watchers { images: observer, updates: watch }: Watchers<'_>,
) -> Result<JudgedRun, ClosedLoopError> {
    let recorded = Recorded { name: &recording.name, imu: &recording.imu, oracle: recording.oracle.as_ref() };
    let sources = Fresh { recorded, networks };
    let mut log = FrameLog::default();
    let (output, noise, images) = match camera {
        CameraInput::Images(images) if spec.learned_before().is_none() => {
            let stream = noise_stream(info.seed);
            let config = settings_for(config, spec);
            let given = crate::noise::track(spec, &recording.imu, &sources, &stream)?;
            let mut keep = |frame: &TrackFrame| log.feed(frame);
            let (output, images) =
                drive_images(&config, recording, images, &given, info.seed, (observer, watch), &mut keep)?;
            fit(recording, &log)?;
            let in_force = output.in_force(given);
            (output, in_force, Some(images))
        }
        // A noise that is made of a first run needs the tracks twice: images are followed before.
        camera => {
            let seen = camera.tracks_watched(recording, &config.front_end, info.seed, observer)?;
            frames_from(recording, &seen.frames, &seen.span)?.iter().for_each(|frame| log.feed(frame));
            fit(recording, &log)?;
            let (output, in_force) =
                run_on_tracks(config, recording, &seen, spec, &sources, info.seed, watch)?;
            (output, in_force, seen.images)
        }
    };
    let health = log.health();
    let frames = log.finish();
    let axes = output.axes;
    let mut waited_for: BTreeMap<String, usize> = BTreeMap::new();
    for update in &output.updates {
        if let Phase::Initialising(reason) = update.phase {
            *waited_for.entry(reason.name().to_owned()).or_default() += 1;
        }
    }
    let levels = output.updates.iter().rev().find_map(|update| update.levels.as_deref());
    let against = doubts(&output.report, levels);
    let info = RunInfo { front_end: images.as_ref().map(|images| images.figures.clone()), ..info };
    let mut report = Report {
        row: judge(recording, &info, &output)?.row,
        warnings: warnings(recording, &info, (&frames, images.as_ref()), &output, &health, &axes)
            .into_iter()
            .chain(doubts_warning(&against, axes.warning().is_some()))
            .chain(dpn_noise::doubts(spec, &recording.imu, &noise))
            .collect(),
        doubts: against,
        axes,
        clock: output.report.clock,
        readout: output.report.readout,
        tracks: health,
        images: images.map_or_else(Vec::new, |images| images.events),
        skipped: output.report.skipped,
        waited_for,
        scale_std: output.updates.iter().rev().find_map(|u| u.scale_std),
        scale_known: ScaleKnown::of(&output.updates),
        bias_jumps: output.report.jumps.clone(),
        lens_px: output.report.lens_px,
        learned: levels.map(LearnedLevels::of),
        learned_noise: None,
        noise_rms: noise_rms(&noise),
    };
    let doubted = report.is_doubted();
    report.learned_noise = LearnedNoise::of(recording, &settings_for(config, spec), &output, &noise, doubted);
    Ok(JudgedRun { report, output, noise, frames })
}

/// Whether the frames can be run on.
///
/// # Errors
/// Too few of them, or none on the samples' clock; ids that do not stay with points.
fn fit(recording: &Recording, log: &FrameLog) -> Result<(), ClosedLoopError> {
    let stamps: Vec<Stamp> = log.seen().iter().map(|frame| frame.t).collect();
    enough(recording, &stamps, &Span::from(0.0))?;
    match log.health().fault() {
        Some(problem) => Err(SequenceFault::TrackIds(problem).of(&recording.name)),
        None => Ok(()),
    }
}

/// What is to be said of long steps between samples while frames `ran`: samples that were lost, and stamps of arrival that make up for each other.
fn gap_words(imu: &ImuRecording, gaps: Vec<Gap>, ran: Option<&Range<Stamp>>) -> Vec<String> {
    let period = imu.rate().period();
    let seen = gaps.into_iter().filter(|gap| ran.is_none_or(|ran| ran.contains(&gap.after)));
    let (late, lost): (Vec<Gap>, Vec<Gap>) = seen.partition(|gap| {
        is_made_up(imu, gap.index, gap.seconds, period).expect("a recording lies in memory")
    });
    let longest = |gaps: &[Gap]| gaps.iter().map(|gap| gap.seconds).fold(0.0, f64::max);
    let mut said: Vec<String> =
        RecordingFault::of_gaps(&lost).iter().map(|fault| format!("IMU: {fault}")).collect();
    if !late.is_empty() {
        said.push(format!(
            "IMU: {} step(s) of up to {:.3} s are made up for by shorter ones: no sample is lost, but stamps are times of arrival; take the sensor's own clock for them",
            late.len(),
            longest(&late)
        ));
    }
    said
}

/// What is odd about the input.
fn warnings(
    recording: &Recording,
    info: &RunInfo,
    (frames, images): (&[SeenFrame], Option<&ImageReport>),
    output: &EstimatorOutput,
    health: &TrackHealth,
    axes: &Axes,
) -> Vec<String> {
    let mut found = recording.remarks.clone();
    if let Some(images) = images {
        let shown = images.events.iter().take(SHOWN_EVENTS);
        found.extend(shown.map(ToString::to_string));
        found.extend((images.flicker > MOST_FLICKER).then(|| {
            format!(
                "the images' brightness changes by {:.0} % from one to the next: lamps that flicker, or an exposure that hunts, spoil tracks; fix exposure \
                 and gain (under lamps an exposure of 10 or 8.3 ms, or a multiple)",
                100.0 * images.flicker
            )
        }));
        let more = images.events.len().saturating_sub(SHOWN_EVENTS) + images.more_events;
        if more > 0 {
            found.push(format!("{more} more such events, {} images in all", images.figures.passed_over));
        }
    }
    match images {
        Some(images) => found.extend(images.rhythm.remarks("images")),
        None => {
            found.extend(Rhythm::of(frames.iter().map(|frame| frame.t)).remarks("frames of tracks"));
        }
    }
    let samples = recording.imu.samples();
    let (first, last) = (samples[0].t, samples[samples.len() - 1].t);
    let early = frames.iter().filter(|f| f.t < first).count();
    let late = frames.iter().filter(|f| f.t > last).count();
    for (count, place) in [(early, "before the first"), (late, "after the last")] {
        if count > 0 {
            found.push(format!(
                "{count} of {} frames lie {place} IMU sample; nothing can be done with them",
                frames.len()
            ));
        }
    }
    if let (Some(begin), Some(end)) = (frames.first(), frames.last()) {
        let (covered, all) = (end.t.min(last).seconds_since(begin.t.max(first)), recording.imu.duration());
        // Who asked for a part has what was asked for.
        if info.to_s.is_none() && info.from_s + covered < COVERED * all {
            found.push(format!(
                "the frames cover {covered:.1} s of the IMU's {all:.1} s; the rest has no pose"
            ));
        }
    }
    let checked = check(&recording.imu, &CheckOptions::default());
    let ran = frames.first().zip(frames.last()).map(|(begin, end)| begin.t..end.t);
    found.extend(gap_words(&recording.imu, checked.gaps, ran.as_ref()));
    if recording.imu.rate().hz() < SLOW_IMU_HZ {
        found.push(format!(
            "IMU: {:.0} samples a second: shaking faster than half of that is folded into slow motion; take 100 or more, or what the sensor filters at",
            recording.imu.rate().hz()
        ));
    }
    for fault in checked.faults {
        match fault {
            RecordingFault::Saturated { .. } | RecordingFault::Constant { .. } => {
                found.push(format!("IMU: {fault}"));
            }
            RecordingFault::Gaps { .. }
            | RecordingFault::TooShort { .. }
            | RecordingFault::WrongRate { .. } => {}
        }
    }
    if let Some(first) = &output.report.first_spike {
        found.push(format!("IMU: {} sample(s) were passed over as spikes: {first}", output.report.spikes));
    }
    found.extend(gravity_warning(samples));
    found.extend(health.warning());
    found.extend(axes.warning());
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::ImuSample;
    use dpn_core::check::gaps;

    #[test]
    fn samples_lost_while_frames_ran_are_told_from_stamps_of_arrival() {
        let at = |k: i64| Stamp::from_ns(5_000_000 * k);
        // Three come at once with the fourth, twice; ten are lost, once amid the frames and once after them.
        let stamp = |k: i64| match k {
            200..203 | 300..303 => {
                Stamp::from_ns(at(k / 100 * 100 + 3).ns() - 1_000 * (k / 100 * 100 + 3 - k))
            }
            _ => at(k),
        };
        let kept = (0..1000).filter(|k| !(500..510).contains(k) && !(900..910).contains(k));
        let samples = kept.map(|k| ImuSample { t: stamp(k), gyro: [0.0; 3], accel: [0.0, 0.0, 9.81] });
        let imu = ImuRecording::new(samples.collect()).unwrap();
        let found = gaps(&imu, 1.5 * imu.rate().period());
        let said = gap_words(&imu, found.clone(), Some(&(at(0)..at(800))));
        let [lost, late] = &said[..] else { panic!("{said:?}") };
        assert!(lost.contains("1 gap(s), 0.055 s in all"), "{lost}");
        assert!(late.contains("2 step(s) of up to 0.020 s") && late.contains("times of arrival"), "{late}");
        assert_eq!(gap_words(&imu, found, Some(&(at(600)..at(800)))), Vec::<String>::new());
    }
}
