//! A closed loop as it is asked for, by a plan or by flags: what becomes a [`Sweep`].

use super::error::SweepError;
use super::settings::Settings;
use crate::closed_loop::{
    Camera, CellFiles, ImageSource, LoggedSequence, SequenceSet, StartAt, Sweep, TrackSource,
};
use crate::injected::Injection;
use dpn_core::config::{ConfigFault, ConfigFaults, Validate};
use dpn_core::estimate::NoiseSpec;
use dpn_io::calibration::Calibration;
use dpn_logs::{ImageLogOptions, LogOptions};
use dpn_pronet::network::Network;
use dpn_sim::tracks::TracksConfig;
use dpn_sim::{FlightConfig, RenderConfig};
use dpn_vio::EstimatorConfig;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// A closed loop: the keys are the flags of `dpn eval --closed-loop`, and their defaults are the same.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LoopPlan {
    /// `closed-loop`.
    pub kind: String,
    /// Folder of ASL sequences, or of datasets as unpacked; without it the simulated flights.
    pub data: Option<PathBuf>,
    /// Folder of trained networks; without it those that come with the program.
    pub models: Option<PathBuf>,
    /// What the odometry sees.
    pub camera: Camera,
    /// Folder with camera tracks, SEQUENCE.txt each; without it tracks are made along the ground truth from the seed.
    pub tracks: Option<PathBuf>,
    /// Folder with reconciled ground truth, NAME.csv each, as `dpn truth` writes it; without it the published one. Of a log with images, also a file of true poses.
    pub truth: Option<PathBuf>,
    /// A calibration in place of every sequence's own; `dpn eval --closed-loop --calib` alone has it.
    #[serde(skip)]
    pub calibration: Option<Calibration>,
    /// Whether images that are listed but not there are passed over.
    pub skip_missing: bool,
    /// Where `data` is a bag: its topic of images; without it, the only one.
    pub image_topic: Option<String>,
    /// Where `data` is a bag: its IMU's topic; without it, the only one.
    pub topic: Option<String>,
    /// `all`, or names with commas between.
    pub sequences: String,
    /// The noises told.
    pub noises: Vec<NoiseSpec>,
    /// The first seed.
    pub seed: u64,
    /// How many seeds, from the first on; 1 to 10000.
    pub seeds: u64,
    /// Seconds after the first frame at which runs begin; or `table`.
    pub from: StartAt,
    /// Seconds after the first frame at which runs end.
    pub to: Option<f64>,
    /// The estimator.
    pub estimator: Settings<EstimatorConfig>,
    /// Simulated tracks.
    pub simulated_tracks: Settings<TracksConfig>,
    /// Rendered images.
    pub images: Settings<RenderConfig>,
    /// Simulated flights.
    pub flights: Settings<FlightConfig>,
    /// Noise of a known course that is added to every recording.
    pub injection: Option<Settings<Injection>>,
    /// Whether every run's trajectory is kept.
    pub trajectories: bool,
}

impl Default for LoopPlan {
    fn default() -> Self {
        let noises = ["x0.5", "x1", "x2", "x4", "x8", "self", "dualpronet"];
        Self {
            kind: "closed-loop".into(),
            data: None,
            models: None,
            camera: Camera::Tracks,
            tracks: None,
            truth: None,
            calibration: None,
            skip_missing: false,
            image_topic: None,
            topic: None,
            sequences: "all".into(),
            noises: noises.map(|noise| noise.parse().expect("a noise spec")).to_vec(),
            seed: 0,
            seeds: 1,
            from: StartAt::Table,
            to: None,
            estimator: Settings::default(),
            simulated_tracks: Settings::default(),
            images: Settings::default(),
            flights: Settings::default(),
            injection: None,
            trajectories: false,
        }
    }
}

impl LoopPlan {
    /// Sequences on disk, or the simulated flights.
    ///
    /// # Errors
    /// Files of settings or folders of data that cannot be read.
    pub fn source(&self) -> Result<SequenceSet, SweepError> {
        let tracks = match (self.camera, &self.tracks) {
            (Camera::Tracks, Some(dir)) => TrackSource::File(dir.clone()),
            (Camera::Tracks, None) => TrackSource::Simulated(self.simulated_tracks.load()?),
            (Camera::Images | Camera::Rendered, Some(_)) => return Err(SweepError::TwoCameras),
            (Camera::Images, None) => {
                TrackSource::Images(ImageSource::Folder { skip_missing: self.skip_missing })
            }
            (Camera::Rendered, None) => {
                TrackSource::Images(ImageSource::Rendered(Box::new(self.images.load()?)))
            }
        };
        let source = match &self.data {
            Some(dir) => match self.logged(dir)? {
                Some(log) => {
                    // Of one log, a file of poses does as well as a folder of them.
                    let in_folder = |dir: &PathBuf| dir.join(format!("{}.csv", log.name()));
                    let truth =
                        self.truth.as_ref().map(|t| if t.is_dir() { in_folder(t) } else { t.clone() });
                    let log = match truth {
                        Some(file) => log.with_truth(&file)?,
                        None => log,
                    };
                    SequenceSet::logged(log, self.skip_missing)
                }
                None => SequenceSet::recorded(dir, tracks)?
                    .with_calibration(self.calibration.clone())
                    .with_reconciled_truth(self.truth.as_deref()),
            },
            None => SequenceSet::Flights { config: self.flights.load()?, tracks },
        };
        if self.seeds > 1 && !source.tracks_are_seeded() {
            return Err(SweepError::Unseeded);
        }
        Ok(source)
    }

    /// The log with images that `data` is, if it is one.
    fn logged(&self, data: &Path) -> Result<Option<LoggedSequence>, SweepError> {
        let options = ImageLogOptions {
            imu: LogOptions { topic: self.topic.clone(), ..LogOptions::default() },
            image_topic: self.image_topic.clone(),
            skip_missing: self.skip_missing,
        };
        let found = LoggedSequence::find(data, options, self.calibration.as_ref())?;
        match found {
            Some(_) if self.camera != Camera::Images => {
                Err(SweepError::OwnImages { data: data.to_path_buf() })
            }
            found => Ok(found),
        }
    }

    /// The sweep over `source`.
    ///
    /// # Errors
    /// Files of settings that cannot be read; sequences that are not there.
    pub fn sweep<'a>(
        &self,
        source: &'a SequenceSet,
        networks: &'a [Network],
        threads: usize,
    ) -> Result<Sweep<'a>, SweepError> {
        Ok(Sweep {
            source,
            places: source.select(&self.sequences)?,
            noises: self.noises.clone(),
            seeds: (self.seed..self.seed.saturating_add(self.seeds)).collect(),
            others: (Vec::new(), Vec::new()),
            from: self.from,
            to: self.to,
            estimator: self.estimator.load()?,
            networks,
            threads,
            cache: None,
            keep: CellFiles { trajectories: self.trajectories, nees: true, states: None },
            injection: self.injection.as_ref().map(Settings::load).transpose()?,
        })
    }
}

/// The faults of settings that stand in a plan.
pub fn faults_of<T: Validate>(name: &str, settings: &Settings<T>, faults: &mut ConfigFaults) {
    if let Settings::Inline(settings) = settings {
        faults.table(name, settings.faults());
    }
}

impl Validate for LoopPlan {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = ConfigFaults::default();
        faults.check(!self.noises.is_empty(), "noises", "[]", "one noise or more");
        faults.within("seeds", self.seeds, 1, 10_000);
        if let Some(to) = self.to {
            faults.positive("to", to);
        }
        let wanted = self.tracks.is_none() || (self.data.is_some() && self.camera == Camera::Tracks);
        let tracks = || self.tracks.iter().map(|dir| dir.display().to_string()).collect::<String>();
        faults.check(
            wanted,
            "tracks",
            tracks(),
            "left out where there is no `data`, or another camera than tracks",
        );
        let truth = || self.truth.iter().map(|dir| dir.display().to_string()).collect::<String>();
        let has_data = self.truth.is_none() || self.data.is_some();
        faults.check(has_data, "truth", truth(), "left out where there is no `data`");
        faults_of("estimator", &self.estimator, &mut faults);
        faults_of("simulated_tracks", &self.simulated_tracks, &mut faults);
        faults_of("images", &self.images, &mut faults);
        faults_of("flights", &self.flights, &mut faults);
        if let Some(injection) = &self.injection {
            faults_of("injection", injection, &mut faults);
        }
        faults.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn every_file_of_the_folder_reads_and_faults_are_named_all_at_once() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../configs/sweep/closed_loop.toml");
        let plan: LoopPlan = dpn_io::config::load(&path).unwrap();
        assert_eq!((plan.noises.len(), plan.seeds), (31, 10));
        let parse = |text: &str| dpn_io::config::parse::<LoopPlan>(text, Path::new("p.toml"));
        let text = "seeds = 0\nfrom = 3\nnoises = []\ntracks = \"t\"\n[estimator.window]\nkey_frames = 1";
        let error = parse(text).unwrap_err().to_string();
        for words in ["`seeds` is 0", "`noises` is []", "`tracks` is t", "`estimator.window.key_frames` is 1"]
        {
            assert!(error.contains(words), "{words}: {error}");
        }
        let error = parse("[estimator.window]\nkeyframes = 9").unwrap_err();
        assert!(error.to_string().starts_with("p.toml:2: "), "{error}");
        assert_eq!(error.hint().as_deref(), Some("did you mean `key_frames`?"));
        let plan = parse("estimator = \"vio.toml\"\nfrom = \"table\"").unwrap();
        assert_eq!(plan.estimator, Settings::File("vio.toml".into()));
    }
}
