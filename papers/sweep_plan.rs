//! The runs of a paper as a plan asks for them: what becomes the jobs of a sweep (`dpn_eval::sweeps`).

use super::error::PaperError;
use super::input::{CameraChoice, Cameras, Input};
use super::plan::Plan;
use dpn_core::config::{ConfigFault, ConfigFaults, Validate};
use dpn_eval::closed_loop::StartAt;
use dpn_eval::sweeps::{Settings, SweepError, faults_of};
use dpn_sim::tracks::TracksConfig;
use dpn_sim::{FlightConfig, RenderConfig};
use dpn_vio::EstimatorConfig;
use serde::Deserialize;
use std::path::PathBuf;

/// A paper's runs: the keys are the flags of `dpn paper`, and their defaults are the same.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PaperSweepPlan {
    /// `paper`.
    pub kind: String,
    /// Folder of EuRoC's sequences, or of datasets as unpacked; without it the simulated flights.
    pub data: Option<PathBuf>,
    /// Folder of trained networks; without it those that come with the program.
    pub models: Option<PathBuf>,
    /// What is run; without it the whole study, or the quick one.
    pub plan: Option<Settings<Plan>>,
    /// A few minutes' worth.
    pub quick: bool,
    /// What the odometry sees.
    pub camera: CameraChoice,
    /// Folder with camera tracks, SEQUENCE.txt each.
    pub tracks: Option<PathBuf>,
    /// `all`, or names with commas between.
    pub sequences: String,
    /// Seconds after the first frame at which runs begin; or `table`.
    pub from: StartAt,
    /// The estimator.
    pub estimator: Settings<EstimatorConfig>,
    /// Simulated tracks.
    pub simulated_tracks: Settings<TracksConfig>,
    /// Rendered images.
    pub images: Settings<RenderConfig>,
    /// Simulated flights.
    pub flights: Settings<FlightConfig>,
}

impl Default for PaperSweepPlan {
    fn default() -> Self {
        Self {
            kind: "paper".into(),
            data: None,
            models: None,
            plan: None,
            quick: false,
            camera: CameraChoice::Auto,
            tracks: None,
            sequences: "all".into(),
            from: StartAt::Seconds(0.0),
            estimator: Settings::default(),
            simulated_tracks: Settings::default(),
            images: Settings::default(),
            flights: Settings::default(),
        }
    }
}

impl Validate for PaperSweepPlan {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = ConfigFaults::default();
        faults.check(!(self.quick && self.plan.is_some()), "quick", self.quick, "left out beside `plan`");
        if let Some(plan) = &self.plan {
            faults_of("plan", plan, &mut faults);
        }
        faults_of("estimator", &self.estimator, &mut faults);
        faults_of("simulated_tracks", &self.simulated_tracks, &mut faults);
        faults_of("images", &self.images, &mut faults);
        faults_of("flights", &self.flights, &mut faults);
        faults.0
    }
}

impl PaperSweepPlan {
    /// What is run.
    ///
    /// # Errors
    /// A file that is no plan.
    pub fn plan(&self) -> Result<Plan, SweepError> {
        match &self.plan {
            Some(plan) => Ok(plan.load()?),
            None if self.quick => Ok(Plan::quick()),
            None => Ok(Plan::whole()),
        }
    }

    /// The estimator, with the covariances that a paper needs.
    ///
    /// # Errors
    /// A file that holds no settings of it.
    pub fn estimator(&self) -> Result<EstimatorConfig, SweepError> {
        Ok(EstimatorConfig { covariance: true, ..self.estimator.load()? })
    }

    /// The sequences, and why the odometry sees what it sees.
    ///
    /// # Errors
    /// Files of settings or folders of data that cannot be read; no sequence that can be used.
    pub fn input(&self) -> Result<(Input, String), PaperError> {
        let cameras = Cameras {
            given: self.tracks.clone(),
            made: self.simulated_tracks.load()?,
            rendered: self.images.load()?,
            flights: self.flights.load()?,
            quick: self.quick,
        };
        let (source, why) = self.camera.open(self.data.as_deref(), &self.sequences, &cameras)?;
        let wanted = source.select(&self.sequences)?;
        Ok((Input::check(source, &wanted, self.sequences == "all", &cameras.made)?, why))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn the_written_plan_is_that_of_a_paper_without_flags() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../configs/sweep/paper.toml");
        let plan: PaperSweepPlan = dpn_io::config::load(&path).unwrap();
        assert_eq!(plan.plan().unwrap(), Plan::whole());
        let both = dpn_io::config::parse::<PaperSweepPlan>(
            "quick = true\nplan = { seeds = 0 }",
            Path::new("p.toml"),
        );
        let error = both.unwrap_err().to_string();
        assert!(error.contains("`plan.seeds` is 0") && error.contains("`quick` is true"), "{error}");
    }
}
