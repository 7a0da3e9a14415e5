//! One line of results.

use super::image_report::FrontEndFigures;
use dpn_core::checksum::of_parts;
use dpn_core::estimate::NoiseSpec;
use dpn_train::split::Side;
use dpn_vio::estimator::RestartReason;
use serde::{Deserialize, Serialize};

/// Wall-clock seconds by the estimator's stages.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StageSeconds {
    /// Pre-integration, sightings, bookkeeping.
    pub feed: f64,
    /// Initialisation.
    pub initialise: f64,
    /// The solver.
    pub solve: f64,
    /// Outliers.
    pub reject: f64,
    /// Sliding and marginalisation.
    pub slide: f64,
}

/// Why a run counts as failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Failure {
    /// No pose at all, or fewer than can be aligned.
    NoPose,
    /// Fewer than half of the frames since the first pose have one.
    FewPoses,
    /// The absolute error after SE(3) alignment exceeds 5 % of the true path's length.
    Diverged,
}

/// Which ground truth a run is judged against; simulated tracks and renderings follow it too.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TruthKind {
    /// As it lies beside the recording.
    Published,
    /// Reconciled with the recording's IMU (`dpn truth`).
    Reconciled,
    /// A simulation's own.
    Exact,
}

/// Why an estimator began anew.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Restart {
    /// Seconds after the first frame.
    pub at_s: f64,
    /// In words.
    pub reason: String,
}

impl Restart {
    /// The estimator's own reason, in words.
    pub fn new(at_s: f64, reason: &RestartReason) -> Self {
        Self { at_s, reason: reason.to_string() }
    }
}

/// The result of one cell: one sequence, one source of tracks, one noise, one seed, one start. What could not be computed is null.
///
/// Everything but `cpu_per_data_s`, `p95_update_ms`, `stage_s` and the front-end's times is the same in every run of the same program on the same input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Name of the sequence or flight.
    pub sequence: String,
    /// Its side of the split of the networks' training.
    pub split: Side,
    /// Checksum of everything that the row is a function of: program, settings, data, seed, what the noise is made of. Empty outside of a sweep.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub cell: String,
    /// What the odometry saw: `tracks`, `images`.
    pub camera: String,
    /// What it was judged against; null without ground truth, and in rows from before there were several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub truth: Option<TruthKind>,
    /// The noise spec, parsed where the row is read.
    pub noise: NoiseSpec,
    /// Seed of tracks and flights; 0 for given tracks.
    pub seed: u64,
    /// The run begins so long after the first frame \[s\].
    pub from_s: f64,
    /// Why the run counts as failed; null where it does not.
    pub failure: Option<Failure>,
    /// RMSE of positions after SE(3) alignment \[m\].
    pub ate_se3: Option<f64>,
    /// The same after alignment of yaw and position \[m\].
    pub ate_yaw: Option<f64>,
    /// The same after Sim(3) alignment \[m\].
    pub ate_sim3: Option<f64>,
    /// RMSE of orientations after SE(3) alignment \[deg\].
    pub rotation_deg: Option<f64>,
    /// Metres of the truth to one of the estimate, minus 1; above 0 the estimate is too small.
    pub scale_error: Option<f64>,
    /// RMSE of positions over stretches of 1 s \[m\].
    pub rpe_1s: Option<f64>,
    /// Over stretches of 5 s \[m\].
    pub rpe_5s: Option<f64>,
    /// Over stretches of 5 m \[m\].
    pub rpe_5m: Option<f64>,
    /// Over stretches of 10 m \[m\].
    pub rpe_10m: Option<f64>,
    /// Over stretches of 20 m \[m\].
    pub rpe_20m: Option<f64>,
    /// Over stretches of 40 m \[m\].
    pub rpe_40m: Option<f64>,
    /// Mean NEES of positions, 3 where the covariance is right.
    pub nees_position: Option<f64>,
    /// Mean NEES of orientations, 3 where the covariance is right.
    pub nees_orientation: Option<f64>,
    /// Share of the frames since the first pose that have one, of those that samples reach.
    pub completion: Option<f64>,
    /// From the first frame to the first pose \[s\].
    pub init_s: Option<f64>,
    /// From the first motion (2 cm or 1 degree; at the earliest the first frame) to the first pose \[s\]; 0 where the pose was first.
    pub init_in_motion_s: Option<f64>,
    /// Times the estimator began anew.
    pub restarts: usize,
    /// When and why.
    pub restart_reasons: Vec<Restart>,
    /// Mean square of the whitened inertial residual per degree of freedom, 1 where the noise told is the noise there is.
    pub whitened: Option<f64>,
    /// Linear systems solved a frame with a pose.
    pub iterations: Option<f64>,
    /// Tracks ended as outliers.
    pub outliers: usize,
    /// Frames handed over.
    pub frames: usize,
    /// Frames with a pose.
    pub poses: usize,
    /// Root mean square of the noise told over the recording: accelerometer x, y, z \[m/s^2\], gyroscope x, y, z \[rad/s\].
    #[serde(default)]
    pub noise_rms: Option<[[f64; 3]; 2]>,
    /// What the spectrum of the samples has against the noise told, where that is an estimate: sentences, one a sensor at most.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub noise_doubts: Vec<String>,
    /// CPU seconds a second of data.
    pub cpu_per_data_s: f64,
    /// 95th percentile of an update's CPU time \[ms\].
    pub p95_update_ms: f64,
    /// Where the time goes.
    pub stage_s: StageSeconds,
    /// What the front-end made of the images; null where tracks came without any. Its time is not in `cpu_per_data_s`.
    #[serde(default)]
    pub front_end: Option<FrontEndFigures>,
}

/// What names a cell among the rows of a run.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct CellKey {
    /// Name of the sequence.
    pub sequence: String,
    /// The seed.
    pub seed: u64,
    /// The noise spec.
    pub noise: String,
}

impl Row {
    /// Which cell it is of.
    pub fn key(&self) -> CellKey {
        CellKey { sequence: self.sequence.clone(), seed: self.seed, noise: self.noise.to_string() }
    }
}

impl CellKey {
    /// Name of a file of this cell: `MH_01_easy.x4.seed0.tum`. A spec with characters of its own, those of a path, has a checksum behind it, so that no
    /// two share a file.
    pub fn file_name(&self, extension: &str) -> String {
        let plain = |c: char| c.is_ascii_alphanumeric() || "-.".contains(c);
        let noise: String = self.noise.chars().map(|c| if plain(c) { c } else { '_' }).collect();
        let noise = noise.trim_end_matches('_');
        let sum = if self.noise.chars().all(|c| plain(c) || "(),".contains(c)) {
            String::new()
        } else {
            format!(".{}", &of_parts([&self.noise])[..8])
        };
        format!("{}.{noise}{sum}.seed{}.{extension}", self.sequence, self.seed)
    }
}

#[cfg(any(test, feature = "testing"))]
pub mod testing {
    //! Rows for tests.
    use super::*;

    /// A row with these figures and round ones elsewhere.
    pub fn row(sequence: &str, noise: &str, seed: u64, ate: Option<f64>) -> Row {
        let row = serde_json::json!({
            "sequence": sequence, "split": if sequence.starts_with("MH_01") { Side::Train } else { Side::Test },
            "cell": format!("{sequence}-{noise}-{seed}"), "camera": "tracks", "truth": TruthKind::Published,
            "noise": noise, "seed": seed, "from_s": 0.0, "failure": ate.is_none().then_some(Failure::NoPose),
            "ate_se3": ate, "scale_error": -0.01, "completion": 1.0 - 0.1 * seed as f64, "init_s": 2.0,
            "restarts": 1, "restart_reasons": [], "whitened": 0.9, "iterations": 2.0, "outliers": 0,
            "frames": 100, "poses": 90, "cpu_per_data_s": 0.02, "p95_update_ms": 3.0,
            "stage_s": StageSeconds::default(),
        });
        serde_json::from_value(row).expect("a row of a test")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_a_cell_have_plain_names() {
        let key = |noise: &str| CellKey { sequence: "f09-hover".into(), seed: 3, noise: noise.into() };
        assert_eq!(key("x0.5").file_name("tum"), "f09-hover.x0.5.seed3.tum");
        assert_eq!(key("shuffled(sg(11,2))").file_name("csv"), "f09-hover.shuffled_sg_11_2.seed3.csv");
        let name = key("file(\"../a b.csv\")").file_name("csv");
        assert!(name.starts_with("f09-hover.file__.._a_b.csv.") && name.ends_with(".seed3.csv"), "{name}");
    }

    #[test]
    fn no_two_specs_share_a_file() {
        let name =
            |noise: &str| CellKey { sequence: "a".into(), seed: 0, noise: noise.into() }.file_name("tum");
        for (one, other) in [
            ("file(\"sub/n.csv\")", "file(\"sub_n.csv\")"),
            ("dualpronet(a,b)", "dualpronet(a_b)"),
            ("file(\"a b\")", "file(\"a(b\")"),
        ] {
            assert_ne!(name(one), name(other));
        }
    }
}
