//! An experiment in the closed loop: source, camera, span, noises, seeds, estimator, injection. Every command that runs the odometry is a list of them.

use super::error::ClosedLoopError;
use super::recording::StartAt;
use super::sequence_set::SequenceSet;
use super::settings::Settings;
use super::source::{Camera, RunSource};
use super::source_error::SourceError;
use super::sweep_plan::{CellFiles, Sweep};
use crate::injected::Injection;
use dpn_core::config::{ConfigFault, ConfigFaults, Validate};
use dpn_core::estimate::NoiseSpec;
use dpn_io::calibration::Calibration;
use dpn_live::settings_for;
use dpn_logs::{ImageLogOptions, LogOptions};
use dpn_pronet::network::Network;
use dpn_sim::tracks::TracksConfig;
use dpn_sim::{FlightConfig, RenderConfig};
use dpn_vio::EstimatorConfig;
use std::collections::BTreeSet;
use std::path::PathBuf;

dpn_core::settings!(
    /// An experiment: every sequence with every noise and every seed. The keys are the flags of `dpn eval --closed-loop`, and their defaults are the same.
    pub struct Experiment {
        /// `closed-loop`.
        pub kind: String = "closed-loop".into(),
        /// Folder of ASL sequences, or of datasets as unpacked, or a log with images; without it the simulated flights.
        pub data: Option<PathBuf> = None,
        /// Folder of trained networks; without it those that come with the program.
        pub models: Option<PathBuf> = None,
        /// What the odometry sees.
        pub camera: Camera = Camera::Tracks,
        /// Folder with camera tracks, SEQUENCE.txt each; without it tracks are made along the ground truth from the seed.
        pub tracks: Option<PathBuf> = None,
        /// Folder with reconciled ground truth, NAME.csv each, as `dpn truth` writes it; without it the published one. Of a log with images, also a file of true poses.
        pub truth: Option<PathBuf> = None,
        /// A calibration in place of every sequence's own; `dpn eval --closed-loop --calib` alone has it.
        #[serde(skip)]
        pub calibration: Option<Calibration> = None,
        /// Whether images that are listed but not there are passed over.
        pub skip_missing: bool = false,
        /// Where `data` is a bag: its topic of images; without it, the only one.
        pub image_topic: Option<String> = None,
        /// Where `data` is a bag: its IMU's topic; without it, the only one.
        pub topic: Option<String> = None,
        /// `all`, or names with commas between.
        pub sequences: String = "all".into(),
        /// The noises given.
        pub noises: Vec<NoiseSpec> = usual_noises(),
        /// The first seed.
        pub seed: u64 = 0,
        /// How many seeds, from the first on; 1 to 10000.
        pub seeds: u64 = 1,
        /// More noises.
        pub others: Vec<NoiseSpec> = Vec::new(),
        /// How many seeds those have, from the first on; 1 to 10000.
        pub other_seeds: u64 = 1,
        /// Seconds after the first frame at which runs begin; or `table`.
        pub from: StartAt = StartAt::default(),
        /// Seconds after the first frame at which runs end.
        pub to: Option<f64> = None,
        /// The estimator.
        pub estimator: Settings<EstimatorConfig> = Settings::default(),
        /// Simulated tracks.
        pub simulated_tracks: Settings<TracksConfig> = Settings::default(),
        /// Rendered images.
        pub images: Settings<RenderConfig> = Settings::default(),
        /// Simulated flights.
        pub flights: Settings<FlightConfig> = Settings::default(),
        /// Noise of a known course that is added to every recording.
        pub injection: Option<Settings<Injection>> = None,
        /// Whether every run's trajectory is kept.
        pub trajectories: bool = false,
        /// Whether every run's NEES is, where the estimator gives covariances.
        pub nees: bool = true,
        /// Noises whose runs' states are kept, those of the first seed.
        pub states: Vec<NoiseSpec> = Vec::new(),
    }
);

fn usual_noises() -> Vec<NoiseSpec> {
    let noises = ["x0.5", "x1", "x2", "x4", "x8", "self", "dualpronet"];
    noises.map(|noise| noise.parse().expect("a noise spec")).to_vec()
}

impl Experiment {
    /// Its sequences, on disk or simulated flights.
    ///
    /// # Errors
    /// Files of settings or folders of data that cannot be read; several seeds where nothing depends on one.
    pub fn source(&self) -> Result<SequenceSet, ClosedLoopError> {
        let source = RunSource {
            camera: Some(self.camera),
            tracks: self.tracks.clone(),
            truth: self.truth.clone(),
            log: ImageLogOptions {
                imu: LogOptions { topic: self.topic.clone(), ..LogOptions::default() },
                image_topic: self.image_topic.clone(),
                skip_missing: self.skip_missing,
            },
            calibration: None,
            simulated_tracks: self.simulated_tracks.load()?,
            images: self.images.load()?,
            flights: self.flights.load()?,
        };
        let source = source.with_calibration(self.calibration.clone())?.all(self.data.as_deref())?;
        if self.seeds.max(self.other_seeds) > 1 && !source.tracks_are_seeded() {
            return Err(SourceError::Unseeded.into());
        }
        Ok(source)
    }

    /// The same with every file of settings read and every sequence named: what a node needs besides the data.
    ///
    /// # Errors
    /// Files of settings that cannot be read; sequences that are not in `source`.
    pub fn resolved(&self, source: &SequenceSet) -> Result<Self, ClosedLoopError> {
        let names = source.names();
        let places = source.select(&self.sequences)?;
        Ok(Self {
            sequences: places.iter().map(|place| names[*place].0.as_str()).collect::<Vec<_>>().join(","),
            estimator: self.estimator.load()?.into(),
            simulated_tracks: self.simulated_tracks.load()?.into(),
            images: self.images.load()?.into(),
            flights: self.flights.load()?.into(),
            injection: self.injection.as_ref().map(Settings::load).transpose()?.map(Settings::from),
            ..self.clone()
        })
    }

    /// What settings that are allowed do not do together, for people: of each noise under which it is so, said once.
    ///
    /// # Errors
    /// A file of settings that cannot be read.
    pub fn warnings(&self) -> Result<BTreeSet<String>, ClosedLoopError> {
        let estimator = self.estimator.load()?;
        let noises = self.noises.iter().chain(&self.others);
        Ok(noises.flat_map(|noise| settings_for(&estimator, noise).warnings()).collect())
    }

    /// Its runs over `source`, on one thread and without a cache.
    ///
    /// # Errors
    /// Files of settings that cannot be read; sequences that are not there.
    pub fn sweep<'a>(
        &self,
        source: &'a SequenceSet,
        networks: &'a [Network],
    ) -> Result<Sweep<'a>, ClosedLoopError> {
        let seeds = |count: u64| (self.seed..self.seed.saturating_add(count)).collect();
        Ok(Sweep {
            source,
            places: source.select(&self.sequences)?,
            noises: self.noises.clone(),
            seeds: seeds(self.seeds),
            other_seeds: if self.others.is_empty() { Vec::new() } else { seeds(self.other_seeds) },
            others: self.others.clone(),
            from: self.from,
            to: self.to,
            estimator: self.estimator.load()?,
            networks,
            threads: 1,
            cache: None,
            keep: CellFiles {
                trajectories: self.trajectories,
                nees: self.nees,
                states: (!self.states.is_empty()).then(|| (self.states.clone(), self.seed)),
            },
            injection: self.injection.as_ref().map(Settings::load).transpose()?,
        })
    }
}

impl Validate for Experiment {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = ConfigFaults::default();
        faults.check(!self.noises.is_empty(), "noises", "[]", "one noise or more");
        faults.within("seeds", self.seeds, 1, 10_000);
        faults.within("other_seeds", self.other_seeds, 1, 10_000);
        if let Some(to) = self.to {
            faults.positive("to", to);
        }
        let shown = |path: &Option<PathBuf>| path.iter().map(|p| p.display().to_string()).collect::<String>();
        faults.check(
            self.tracks.is_none() || (self.data.is_some() && self.camera == Camera::Tracks),
            "tracks",
            shown(&self.tracks),
            "left out where there is no `data`, or another camera than tracks",
        );
        let has_data = self.truth.is_none() || self.data.is_some();
        faults.check(has_data, "truth", shown(&self.truth), "left out where there is no `data`");
        self.estimator.faults("estimator", &mut faults);
        self.simulated_tracks.faults("simulated_tracks", &mut faults);
        self.images.faults("images", &mut faults);
        self.flights.faults("flights", &mut faults);
        if let Some(injection) = &self.injection {
            injection.faults("injection", &mut faults);
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
        let plan: Experiment = dpn_io::config::load(&path).unwrap();
        assert_eq!((plan.noises.len(), plan.seeds), (31, 10));
        let parse = |text: &str| dpn_io::config::parse::<Experiment>(text, Path::new("p.toml"));
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

    #[test]
    fn a_resolved_experiment_comes_back_from_json_as_it_was() {
        let asked = Experiment {
            sequences: "hover,f02".into(),
            others: vec!["self".parse().unwrap()],
            from: StartAt::Table,
            to: Some(0.1 + 0.2),
            camera: Camera::Rendered,
            injection: Some(Injection::default().into()),
            states: vec!["x1".parse().unwrap()],
            ..Experiment::default()
        };
        let resolved = asked.resolved(&asked.source().unwrap()).unwrap();
        assert_eq!(resolved.sequences, "f02-hall-calm,f09-hover");
        let text = serde_json::to_string(&resolved).unwrap();
        assert_eq!(serde_json::from_str::<Experiment>(&text).unwrap(), resolved);
    }
}
