//! A paper as it is asked for, by a plan's TOML or by flags.

use super::error::PaperError;
use super::input::{CameraChoice, Input};
use super::plan::Plan;
use dpn_core::config::{ConfigFault, ConfigFaults, Validate};
use dpn_eval::closed_loop::{Experiment, Settings};
use dpn_io::config::ConfigError;
use dpn_vio::EstimatorConfig;

dpn_core::settings!(
    /// A paper as it is asked for.
    pub struct PaperPlan {
        /// `paper`.
        pub kind: String = "paper".into(),
        /// What is run; without it the whole study, or the quick one.
        pub plan: Option<Settings<Plan>> = None,
        /// A few minutes' worth.
        pub quick: bool = false,
        /// What the odometry sees.
        pub camera: CameraChoice = CameraChoice::Auto,
        /// Data, sequences, start, estimator and what is simulated; camera, noises and seeds are the paper's.
        pub run: Experiment = Experiment::default(),
    }
);

impl Validate for PaperPlan {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = ConfigFaults::default();
        faults.check(!(self.quick && self.plan.is_some()), "quick", self.quick, "left out beside `plan`");
        if let Some(plan) = &self.plan {
            plan.faults("plan", &mut faults);
        }
        faults.table("run", self.run.faults());
        faults.0
    }
}

impl PaperPlan {
    /// What is run.
    ///
    /// # Errors
    /// A file that is no plan.
    pub fn plan(&self) -> Result<Plan, ConfigError> {
        match &self.plan {
            Some(plan) => plan.load(),
            None if self.quick => Ok(Plan::quick()),
            None => Ok(Plan::whole()),
        }
    }

    /// Opens what is asked for.
    ///
    /// # Errors
    /// Files of settings or folders of data that cannot be read; no sequence that can be used.
    pub fn open(&self) -> Result<Opened, PaperError> {
        let plan = self.plan()?;
        // NEES and the error's band need covariances.
        let estimator = EstimatorConfig { covariance: true, ..self.run.estimator.load()? };
        let asked = Experiment { estimator: estimator.clone().into(), nees: false, ..self.run.clone() };
        let (run, source, camera) = self.camera.open(&asked, self.quick)?;
        let wanted = source.select(&run.sequences)?;
        let input = Input::check(source, &wanted, run.sequences == "all", &run.simulated_tracks.load()?)?;
        Ok(Opened { plan, run, estimator, input, camera })
    }
}

/// A paper that was opened.
#[derive(Debug)]
pub struct Opened {
    /// What is run.
    pub plan: Plan,
    /// What every closed loop is made from, but for noises and seeds.
    pub run: Experiment,
    /// Its estimator.
    pub estimator: EstimatorConfig,
    /// On what.
    pub input: Input,
    /// Why the odometry sees what it sees.
    pub camera: String,
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn the_written_plan_is_that_of_a_paper_without_flags() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../configs/sweep/paper.toml");
        let plan: PaperPlan = dpn_io::config::load(&path).unwrap();
        assert_eq!(plan.plan().unwrap(), Plan::whole());
        let both =
            dpn_io::config::parse::<PaperPlan>("quick = true\nplan = { seeds = 0 }", Path::new("p.toml"));
        let error = both.unwrap_err().to_string();
        assert!(error.contains("`plan.seeds` is 0") && error.contains("`quick` is true"), "{error}");
    }
}
