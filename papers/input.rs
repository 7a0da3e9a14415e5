//! What there is to work on, and what is missing.

use super::error::PaperError;
use dpn_core::{ImuRecording, SampleRate};
use dpn_eval::closed_loop::{
    Camera, ClosedLoopError, Experiment, SequenceSet, Sequences, TrackSource, UntrackedSequence, has_images,
};
use dpn_eval::published;
use dpn_sim::tracks::TracksConfig;
use dpn_train::corpus::{Corpus, Member};
use dpn_train::split::{Side, paper_side};
use serde::{Deserialize, Serialize};

dpn_core::named!(
    /// What the odometry sees.
    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    pub enum CameraChoice {
        /// The best that every sequence has: its own images, else rendered ones, else tracks.
        Auto = "auto",
        /// The sequences' own images; those without any are missing.
        Images = "images",
        /// Images rendered along the ground truth.
        Rendered = "rendered",
        /// Camera tracks, given or made along the ground truth.
        Tracks = "tracks",
    }
);

impl CameraChoice {
    /// The experiment `asked` for with this camera, its sequences, and why this camera, in words; `quick` where minutes count: [`Auto`](Self::Auto) renders
    /// nothing then.
    ///
    /// # Errors
    /// A folder that cannot be listed, a sequence that is not there, images of flights.
    pub fn open(
        self,
        asked: &Experiment,
        quick: bool,
    ) -> Result<(Experiment, SequenceSet, String), PaperError> {
        let (camera, why) = self.chosen(asked, quick)?;
        let run = Experiment { camera, ..asked.clone() };
        let source = run.source()?;
        Ok((run, source, why))
    }

    fn chosen(self, asked: &Experiment, quick: bool) -> Result<(Camera, String), PaperError> {
        let flies = asked.data.is_none();
        let tracks = match (flies, &asked.tracks) {
            (true, _) => "made along the true path",
            (false, Some(_)) => "the given ones",
            (false, None) => "made along the ground truth",
        };
        let path = if flies { "along the true path" } else { "along the ground truth" };
        let (camera, why) = match self {
            Self::Images if flies => {
                return Err(PaperError::NoCamera {
                    camera: self.to_string(),
                    reason: "simulated flights have no images".into(),
                });
            }
            Self::Images => (Camera::Images, "the sequences' own, as asked for".into()),
            Self::Rendered => (Camera::Rendered, format!("{path}, as asked for")),
            Self::Tracks => (Camera::Tracks, format!("{tracks}, as asked for")),
            Self::Auto if flies && quick => (
                Camera::Tracks,
                "simulated flights have no images, and to render some takes long; tracks are made along their true path".into(),
            ),
            Self::Auto if flies => {
                (Camera::Rendered, format!("{path}, for simulated flights have no images"))
            }
            Self::Auto if asked.tracks.is_some() => (Camera::Tracks, format!("{tracks}, as asked for")),
            Self::Auto => {
                let source = Experiment { camera: Camera::Tracks, ..asked.clone() }.source()?;
                let sequences = source.recordings(&source.select(&asked.sequences)?);
                // One whose list of images does not read is named with its reason when the input is checked.
                let without = sequences.iter().filter(|s| matches!(has_images(s), Ok(false))).count();
                let none = format!("{without} of {} sequences have no images here", sequences.len());
                let long = if quick { ", and to render some takes long" } else { "" };
                if without == 0 {
                    (Camera::Images, "every sequence has its own".into())
                } else if !quick && sequences.iter().any(|s| s.ground_truth_path().is_some()) {
                    (Camera::Rendered, format!("{path}, for {none}"))
                } else {
                    (Camera::Tracks, format!("{tracks}, for {none}{long}"))
                }
            }
        };
        Ok((camera, why))
    }
}

/// A sequence that has no rows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Missing {
    /// Its name; of EuRoC's, the short one.
    pub name: String,
    /// Why.
    pub reason: String,
}

/// Recordings that can be used, and those that cannot.
#[derive(Debug, Clone)]
pub struct Input {
    /// Name of the collection, `euroc` or `simulated`.
    pub name: String,
    /// Sequences of the closed loop.
    pub source: SequenceSet,
    /// Places of those that are used.
    pub places: Vec<usize>,
    /// Those that are not.
    pub missing: Vec<Missing>,
    /// Those whose samples are used and that the odometry could not see: without rows where it runs.
    pub unseen: Vec<Missing>,
    /// The sequences as the odometry sees them where noise is added: [`SequenceSet`], but for rendered images, in whose place there are tracks made
    /// along the ground truth.
    pub injected: SequenceSet,
    /// The recordings of those used: windows of the open loop come from them.
    pub corpus: Corpus,
    /// Minutes of the IMU of each sequence used, and its samples.
    pub lengths: Vec<(String, Side, usize, f64)>,
}

impl Input {
    /// Reads every sequence among `wanted` once; what does not read is missing, with its reason, as are sequences of the paper that are
    /// not there. `whole`: whether all sequences were wanted; `made`: tracks of the experiment with injected noise, where images are rendered.
    ///
    /// # Errors
    /// No sequence that reads.
    pub fn check(
        source: SequenceSet,
        wanted: &[usize],
        whole: bool,
        made: &TracksConfig,
    ) -> Result<Self, PaperError> {
        let names = source.names();
        let (mut places, mut missing, mut lengths) = (Vec::new(), Vec::new(), Vec::new());
        let mut members = Vec::new();
        for &place in wanted {
            let (name, side) = &names[place];
            match usable(&source, place) {
                Ok(recording) => {
                    places.push(place);
                    lengths.push((name.clone(), *side, recording.len(), recording.duration() / 60.0));
                    members.push(Member { name: name.clone(), recording, side: *side });
                }
                Err(reason) => missing.push(Missing { name: name.clone(), reason }),
            }
        }
        if places.is_empty() {
            let reasons = missing.iter().map(|m| format!("{}: {}", m.name, m.reason)).collect();
            return Err(PaperError::Nothing { reasons });
        }
        let of_paper = names.iter().any(|(name, _)| paper_side(name).is_some());
        if of_paper {
            for published::SplitSequence { sequence, .. } in published::split() {
                let there = names.iter().position(|(name, _)| name.starts_with(&sequence));
                let reason = match there {
                    None => "there is no such folder in the data".to_owned(),
                    Some(place) if !wanted.contains(&place) && !whole => "not asked for".to_owned(),
                    _ => continue,
                };
                missing.push(Missing { name: sequence, reason });
            }
        }
        missing.sort_by(|a, b| a.name.cmp(&b.name));
        let name = match source.of {
            Sequences::Flights(_) => "simulated",
            Sequences::Recorded(_) if of_paper => "euroc",
            Sequences::Recorded(_) | Sequences::Logged(_) => "recorded",
        };
        let corpus = Corpus { name: name.into(), rate: SampleRate::HZ_200, members };
        let mut injected = source.clone();
        if let TrackSource::Rendered(_) = source.tracks {
            injected.tracks = TrackSource::Simulated(made.clone());
        }
        let unseen = Vec::new();
        Ok(Self { name: name.into(), source, places, missing, unseen, injected, corpus, lengths })
    }

    /// Without these on the odometry's side.
    #[must_use]
    pub(super) fn without(&self, unseen: &[UntrackedSequence]) -> Self {
        let names = self.source.names();
        let missing = unseen.iter().map(|unseen| {
            let name = names[unseen.place].0.clone();
            let words = unseen.error.in_full();
            let reason = words.strip_prefix(&format!("{name}: ")).unwrap_or(&words).to_owned();
            Missing { name, reason }
        });
        let places = self.places.iter().copied();
        Self {
            places: places.filter(|place| unseen.iter().all(|unseen| unseen.place != *place)).collect(),
            unseen: self.unseen.iter().cloned().chain(missing).collect(),
            ..self.clone()
        }
    }

    /// Whether the sequences are those of the paper.
    pub fn is_papers(&self) -> bool {
        self.name == "euroc"
    }

    /// Lines that say what is missing, for the foot of a table.
    pub(super) fn notes(&self) -> Vec<String> {
        notes(self.missing.iter())
    }

    /// What the odometry sees, in words.
    pub(super) fn camera(&self) -> &'static str {
        match self.source.camera() {
            "rendered" => "rendered images",
            camera => camera,
        }
    }

    /// The side of a sequence that is there, or of one of the paper's.
    pub(super) fn side(&self, name: &str) -> Option<Side> {
        let names = self.source.names();
        let there = names.iter().find(|(there, _)| there == name).map(|(_, side)| *side);
        there.or_else(|| paper_side(name))
    }

    /// Every sequence without rows where the odometry runs.
    pub(super) fn not_run(&self) -> impl Iterator<Item = &Missing> {
        self.missing.iter().chain(&self.unseen)
    }

    /// Lines that say what is missing where the odometry runs.
    pub(super) fn notes_of_runs(&self) -> Vec<String> {
        notes(self.not_run())
    }
}

/// A line a reason.
fn notes<'a>(missing: impl Iterator<Item = &'a Missing>) -> Vec<String> {
    let mut by_reason: Vec<(&str, Vec<&str>)> = Vec::new();
    for Missing { name, reason } in missing {
        match by_reason.iter_mut().find(|(there, _)| *there == reason) {
            Some((_, names)) => names.push(name),
            None => by_reason.push((reason, vec![name])),
        }
    }
    by_reason.iter().map(|(reason, names)| format!("No row for {}: {reason}.", names.join(", "))).collect()
}

/// The samples of a sequence that a loop can be closed on and windows can be cut from.
fn usable(source: &SequenceSet, place: usize) -> Result<ImuRecording, String> {
    let recording = source.recording(place, 0).map_err(|error| error.in_full())?;
    if recording.truth.is_none() {
        return Err("it has no ground truth, so that nothing can be judged".into());
    }
    match (&source.tracks, &source.of) {
        (TrackSource::File(_), Sequences::Recorded(_)) => {
            source.frames(place, 0).map_err(|error| error.in_full())?;
        }
        (TrackSource::Images { .. }, Sequences::Recorded(sequences)) => {
            let any =
                has_images(&sequences[place].0).map_err(|error| ClosedLoopError::from(error).in_full())?;
            if !any {
                return Err("it has none of the images it lists".into());
            }
        }
        _ => {}
    }
    let member = Member { name: recording.name, recording: recording.imu, side: recording.side };
    let mut one = Corpus::new("one", vec![member]).map_err(|error| error.to_string())?;
    one.members.pop().map(|member| member.recording).ok_or_else(|| "it is empty".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_eval::closed_loop::SequenceFault;
    use std::path::Path;

    fn asked(data: Option<&Path>) -> Experiment {
        Experiment { data: data.map(Path::to_path_buf), ..Experiment::default() }
    }

    fn opened(choice: CameraChoice, asked: &Experiment, quick: bool) -> (SequenceSet, String) {
        let (_, source, why) = choice.open(asked, quick).unwrap();
        (source, why)
    }

    fn check(source: SequenceSet, wanted: &[usize], whole: bool) -> Result<Input, PaperError> {
        Input::check(source, wanted, whole, &TracksConfig::default())
    }

    #[test]
    fn flights_miss_nothing_and_have_no_images() {
        let (source, why) = opened(CameraChoice::Auto, &asked(None), true);
        assert!(source.camera() == "tracks" && why.contains("no images"), "{why}");
        let (rendered, why) = opened(CameraChoice::Auto, &asked(None), false);
        assert!(rendered.camera() == "rendered" && why.contains("no images"), "{why}");
        assert_eq!(check(rendered, &[8], false).unwrap().injected.camera(), "tracks");
        let input = check(source, &[8], false).unwrap();
        assert_eq!((input.places.as_slice(), input.missing.len(), input.is_papers()), (&[8][..], 0, false));
        assert!(input.lengths[0].3 > 0.5);
        let error = CameraChoice::Images.open(&asked(None), false).unwrap_err();
        assert!(error.to_string().contains("simulated flights have no images") && error.hint().is_some());
    }

    #[test]
    fn without_images_they_are_rendered_and_images_asked_for_leave_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let mav = dir.path().join("MH_01_easy/mav0");
        let put = |name: &str| {
            std::fs::create_dir_all(mav.join(name)).unwrap();
            std::fs::write(mav.join(name).join("data.csv"), "#timestamp [ns]\n").unwrap();
        };
        put("imu0");
        let recorded = asked(Some(dir.path()));
        // Without a truth nothing can be rendered; nor can it be judged, which is said later.
        let (source, why) = opened(CameraChoice::Auto, &recorded, false);
        assert_eq!(source.camera(), "tracks");
        assert_eq!(why, "made along the ground truth, for 1 of 1 sequences have no images here");
        put("state_groundtruth_estimate0");
        let (source, why) = opened(CameraChoice::Auto, &recorded, false);
        assert_eq!(source.camera(), "rendered");
        assert_eq!(why, "along the ground truth, for 1 of 1 sequences have no images here");
        assert_eq!(opened(CameraChoice::Auto, &recorded, true).0.camera(), "tracks");
        let given = Experiment { tracks: Some("tracks".into()), ..recorded.clone() };
        assert_eq!(opened(CameraChoice::Auto, &given, false).1, "the given ones, as asked for");
        let (source, _) = opened(CameraChoice::Images, &recorded, false);
        assert_eq!(source.camera(), "images");
        assert!(matches!(check(source, &[0], true), Err(PaperError::Nothing { .. })));
    }

    #[test]
    fn what_cannot_be_seen_loses_its_place_and_keeps_its_windows() {
        let (source, _) = opened(CameraChoice::Tracks, &asked(None), false);
        let input = check(source, &[7, 8], false).unwrap();
        let error = SequenceFault::NoImages { asked: false }.of("f09-hover");
        let left = input.without(&[UntrackedSequence { place: 8, error }]);
        assert_eq!((left.places.as_slice(), left.corpus.members.len(), left.notes().len()), (&[7][..], 2, 0));
        assert_eq!(left.notes_of_runs(), ["No row for f09-hover: it has no images."]);
    }
}
