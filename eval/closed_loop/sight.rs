//! A recording's images through the front-end: tracks, and what became of the images.

use super::error::ClosedLoopError;
use super::images::ImageStream;
use super::recording::{Recording, Span};
use super::tally::Tally;
use cpu_time::ThreadTime;
use dpn_core::random::Stream;
use dpn_core::{GrayImage, Stamp, TrackFrame};
use dpn_vio::frontend::{Fed, FrontEnd, FrontEndConfig, GyroTurn, Status, turn_of_camera};
use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// When none of so many first images can be read, no later one is waited for.
const FIRST: usize = 10;

/// Tracks of a recording.
#[derive(Debug, Clone)]
pub struct Seen {
    /// Frame by frame.
    pub frames: Vec<TrackFrame>,
    /// The part of them that is run; all, where images outside were left out before.
    pub span: Span,
    /// What the front-end made of the images; none where tracks came without any.
    pub sight: Option<Sight>,
}

/// What became of a recording's images.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sight {
    /// The figures.
    pub figures: SightFigures,
    /// What was wrong with images, in time.
    pub events: Vec<SightEvent>,
    /// Events beyond those kept.
    pub more_events: usize,
}

/// The front-end over a recording, in figures.
///
/// All but `cpu_per_data_s` and `p95_ms` are the same in every run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SightFigures {
    /// Images that came, in whatever state.
    pub images: usize,
    /// Those that no point was followed into: dark, saturated, repeated, of another size, unreadable.
    pub passed_over: usize,
    /// Mean number of tracks in a frame handed over.
    pub tracks: f64,
    /// Mean number of frames handed over in which a track is.
    pub track_length: f64,
    /// Share of the tracks asked that agreed on the camera's motion.
    pub inlier_share: f64,
    /// Share of the frames in which the gyroscope's rotation was what they agreed on.
    pub by_gyro_share: f64,
    /// Share of all tracks followed that did not come home when followed back.
    pub not_home_share: f64,
    /// CPU seconds a second of data, without getting the images.
    pub cpu_per_data_s: f64,
    /// 95th percentile of an image's CPU time \[ms\].
    pub p95_ms: f64,
}

/// Why nothing was made of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PassedOver {
    /// It shows nothing: dark, saturated, or all alike.
    Blind,
    /// It is the one before over again.
    Repeated,
    /// It has another size than the camera's calibration says.
    WrongSize,
    /// It is not later than the one before.
    OutOfOrder,
    /// It cannot be read.
    Unreadable,
}

/// Images in a row that were passed over for one reason.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SightEvent {
    /// Seconds of the first of them after the first image.
    pub from_s: f64,
    /// Of the last.
    pub to_s: f64,
    /// How many.
    pub images: usize,
    /// Why.
    pub reason: PassedOver,
    /// The same in words, of the first of them.
    pub words: String,
}

impl std::fmt::Display for SightEvent {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { from_s, to_s, images, words, .. } = self;
        if *images == 1 {
            write!(f, "an image passed over at {from_s:.2} s: {words}")
        } else {
            write!(f, "{images} images passed over from {from_s:.2} to {to_s:.2} s: {words}")
        }
    }
}

/// Somebody who looks on: every image that could be had, and what the front-end made of it.
pub type Watch<'a> = dyn FnMut(&GrayImage, &Fed) + 'a;

/// Follows points through `images`, with the recording's gyroscope to say where to look; `seed` feeds the consensus.
///
/// # Errors
/// Settings out of their bounds; none of the first images can be read, or none of all shows anything.
pub fn follow(
    recording: &Recording,
    images: ImageStream<'_>,
    config: &FrontEndConfig,
    seed: u64,
    watch: &mut Watch<'_>,
) -> Result<Seen, ClosedLoopError> {
    let stream = Stream::new(seed).named(&recording.name);
    let mut front_end = FrontEnd::new(recording.camera, *config, &stream)
        .map_err(|source| ClosedLoopError::FrontEnd { sequence: recording.name.clone(), source })?;
    let mut gyro = Gyro { turn: GyroTurn::new(), recording, next: 0 };
    let mut tally = Tally::default();
    let mut frames = Vec::new();
    let mut unreadable = 0;
    for (t, image) in images {
        let image = match image {
            Ok(image) => image,
            Err(error) => {
                unreadable += 1;
                tally.passed_over(t, PassedOver::Unreadable, error.to_string());
                if unreadable == FIRST && unreadable == tally.images() {
                    return Err(error.into());
                }
                continue;
            }
        };
        let clock = ThreadTime::now();
        let turn = gyro.turn_to(t);
        let fed = front_end.feed(image.view(), t, turn.as_ref());
        tally.add(&fed, recording.camera.size(), clock.elapsed().as_secs_f64());
        watch(&image, &fed);
        frames.extend(fed.frame);
    }
    let sight = tally.finish(&frames);
    if frames.is_empty() {
        let why = sight.events.iter().max_by_key(|event| event.images).map(ToString::to_string);
        return Err(ClosedLoopError::NothingSeen {
            sequence: recording.name.clone(),
            images: sight.figures.images,
            why: why.unwrap_or_else(|| "there are none".into()),
        });
    }
    Ok(Seen { frames, span: Span::from(0.0), sight: Some(sight) })
}

/// What is said of an image with this status, where nothing was made of it.
pub(super) fn passed_over(status: Status, camera: [u32; 2]) -> Option<(PassedOver, String)> {
    match status {
        Status::Tracked | Status::HandedOver => None,
        Status::Blind => Some((PassedOver::Blind, "dark, saturated, or all alike".into())),
        Status::Repeated => Some((PassedOver::Repeated, "the image before over again".into())),
        Status::WrongSize { width, height } => Some((
            PassedOver::WrongSize,
            format!("{width} x {height} px, and the calibration is for {} x {}", camera[0], camera[1]),
        )),
        Status::OutOfOrder { last_ns } => {
            Some((PassedOver::OutOfOrder, format!("not later than the one before, at {last_ns} ns")))
        }
    }
}

/// The recording's samples, fed as far as they are needed.
struct Gyro<'a> {
    turn: GyroTurn,
    recording: &'a Recording,
    next: usize,
}

impl Gyro<'_> {
    /// How the camera turned since the image before.
    fn turn_to(&mut self, t: Stamp) -> Option<UnitQuaternion<f64>> {
        let samples = self.recording.imu.samples();
        // Up to the first at or after the image, which says the rate up to it.
        while self.next < samples.len() && (self.next == 0 || samples[self.next - 1].t < t) {
            self.turn.feed(&samples[self.next]);
            self.next += 1;
        }
        let turn = self.turn.until(t, &Vector3::zeros())?;
        Some(turn_of_camera(&turn, &self.recording.body_from_cam.rotation))
    }
}
