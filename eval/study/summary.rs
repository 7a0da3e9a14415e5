//! One noise over all its runs.

use super::compare::Comparison;
use super::rows::RowSet;
use crate::closed_loop::Row;
use crate::stats::{Bootstrap, StatsError, median_interval};
use dpn_core::estimate::NoiseSpec;
use dpn_core::random::Stream;
use dpn_core::signal::stats::median_of;
use dpn_train::split::Side;
use serde::Serialize;

/// One noise over all its runs. Medians are over runs where nothing else is said.
#[derive(Debug, Clone, Serialize)]
pub struct NoiseSummary {
    /// The noise.
    pub noise: NoiseSpec,
    /// Fewest and most seeds of a sequence.
    pub seeds: [usize; 2],
    /// Runs.
    pub runs: usize,
    /// Failed ones.
    pub failures: usize,
    /// Restarts in all.
    pub restarts: usize,
    /// Median over sequences of the absolute error \[m\].
    pub ate: Option<f64>,
    /// Its 95 % bootstrap interval over sequences.
    pub ate_interval: Option<[f64; 2]>,
    /// Means over sequences \[m\]: all, training, test.
    pub means: [Option<f64>; 3],
    /// Root mean square of the noise told over runs: accelerometer \[m/s^2\], gyroscope \[rad/s\].
    pub noise_rms: Option<[f64; 2]>,
    /// Median relative error over 1 s \[m\].
    pub rpe_1s: Option<f64>,
    /// Median relative scale error, without its sign.
    pub scale_error: Option<f64>,
    /// Lowest share of frames since initialisation with a pose.
    pub lowest_completion: Option<f64>,
    /// Longest initialisation since the first motion \[s\].
    pub longest_init_s: Option<f64>,
    /// Median NEES of position and orientation.
    pub nees: [Option<f64>; 2],
    /// Median mean square of the whitened inertial residual.
    pub whitened: Option<f64>,
    /// Median iterations a frame.
    pub iterations: Option<f64>,
    /// Median CPU seconds a second of data.
    pub cpu_per_data_s: Option<f64>,
    /// Highest 95th percentile of an update's CPU time \[ms\].
    pub p95_update_ms: Option<f64>,
    /// Against the reference; none for itself and with fewer than two sequences in common.
    pub comparison: Option<Comparison>,
}

impl NoiseSummary {
    /// Of the runs of `noise`, compared with nothing yet.
    pub(super) fn new(rows: &RowSet<'_>, noise: &NoiseSpec) -> Result<Self, StatsError> {
        let median = |f: &dyn Fn(&Row) -> Option<f64>| median_of(rows.of(noise).filter_map(f));
        let highest = |f: &dyn Fn(&Row) -> Option<f64>| rows.of(noise).filter_map(f).max_by(f64::total_cmp);
        let counts = || rows.sequences(None).map(|name| rows.cell(name, noise).count());
        let ates = rows.ates(noise, None);
        let stream = Stream::new(0).named("paper").named("median");
        let interval =
            if ates.len() < 2 { None } else { Some(median_interval(&ates, &Bootstrap::default(), &stream)?) };
        Ok(Self {
            noise: noise.clone(),
            seeds: [counts().min(), counts().max()].map(|count| count.expect("a noise is there by its rows")),
            runs: rows.of(noise).count(),
            failures: rows.of(noise).filter(|r| r.failure.is_some()).count(),
            restarts: rows.of(noise).map(|r| r.restarts).sum(),
            ate: rows.median(noise, None),
            ate_interval: interval.map(|i| [i.low, i.high]),
            means: [None, Some(Side::Train), Some(Side::Test)].map(|side| rows.mean(noise, side)),
            noise_rms: noise_rms(rows, noise),
            rpe_1s: median(&|r| r.rpe_1s),
            scale_error: median(&|r| r.scale_error.map(f64::abs)),
            lowest_completion: rows.of(noise).filter_map(|r| r.completion).min_by(f64::total_cmp),
            longest_init_s: highest(&|r| r.init_in_motion_s.or(r.init_s)),
            nees: [median(&|r| r.nees_position), median(&|r| r.nees_orientation)],
            whitened: median(&|r| r.whitened),
            iterations: median(&|r| r.iterations),
            cpu_per_data_s: median(&|r| Some(r.cpu_per_data_s)),
            p95_update_ms: highest(&|r| Some(r.p95_update_ms)),
            comparison: None,
        })
    }
}

/// Root mean square over the runs that say theirs, axes together.
fn noise_rms(rows: &RowSet<'_>, noise: &NoiseSpec) -> Option<[f64; 2]> {
    let squares: Vec<[f64; 2]> = rows
        .of(noise)
        .filter_map(|r| r.noise_rms)
        .map(|rms| rms.map(|axes| axes.iter().map(|s| s * s).sum::<f64>() / 3.0))
        .collect();
    let root = |i: usize| (squares.iter().map(|s| s[i]).sum::<f64>() / squares.len() as f64).sqrt();
    (!squares.is_empty()).then(|| [root(0), root(1)])
}
