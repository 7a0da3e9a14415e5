//! A job with everything resolved: what `sweep.json` holds of it, so that a node needs the sweep's folder and the data alone.

use super::error::SweepError;
use crate::closed_loop::{CellFiles, SequenceSet, StartAt, Sweep, TrackSource};
use crate::injected::Injection;
use dpn_core::estimate::NoiseSpec;
use dpn_pronet::network::Network;
use dpn_sim::FlightConfig;
use dpn_train::config::TrainConfig;
use dpn_vio::EstimatorConfig;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// What a job's cells are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum JobSpec {
    /// Runs of the odometry.
    ClosedLoop(Box<LoopSpec>),
    /// Trainings: a configuration each, in the order of the cells.
    Train(Vec<TrainSpec>),
}

/// One training.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainSpec {
    /// Name of its folder.
    pub folder: String,
    /// The configuration, seed included.
    pub config: TrainConfig,
    /// Where it is computed, as `dpn train --device` names it.
    pub device: String,
}

/// A [`Sweep`] without what it borrows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoopSpec {
    /// Settings of the flights; none for recordings on disk.
    pub flights: Option<FlightConfig>,
    /// What the odometry sees.
    pub tracks: TrackSource,
    /// Folder of reconciled ground truth; none where it is the published one.
    pub truth: Option<PathBuf>,
    /// Names of the sequences.
    pub sequences: Vec<String>,
    /// As in [`Sweep`], as are all others.
    pub noises: Vec<NoiseSpec>,
    /// The seeds.
    pub seeds: Vec<u64>,
    /// More noises, and the seeds of these.
    pub others: (Vec<NoiseSpec>, Vec<u64>),
    /// Where a run begins.
    pub from: StartAt,
    /// Where it ends.
    pub to: Option<f64>,
    /// The estimator's settings.
    pub estimator: EstimatorConfig,
    /// What is kept beside rows.
    pub keep: CellFiles,
    /// What is added to recordings.
    pub injection: Option<Injection>,
}

impl LoopSpec {
    /// Of a sweep.
    pub fn of(sweep: &Sweep<'_>) -> Self {
        let names = sweep.source.names();
        Self {
            flights: match sweep.source {
                SequenceSet::Flights { config, .. } => Some(config.clone()),
                SequenceSet::Recorded { .. } | SequenceSet::Logged { .. } => None,
            },
            tracks: sweep.source.tracks().clone(),
            truth: sweep.source.reconciled_truth().map(Path::to_path_buf),
            sequences: sweep.places.iter().map(|place| names[*place].0.clone()).collect(),
            noises: sweep.noises.clone(),
            seeds: sweep.seeds.clone(),
            others: sweep.others.clone(),
            from: sweep.from,
            to: sweep.to,
            estimator: sweep.estimator.clone(),
            keep: sweep.keep.clone(),
            injection: sweep.injection,
        }
    }

    /// Its sequences, those on disk in `data`; `tracks` and `truth` in place of the folders of given tracks and of reconciled truth that the spec names.
    ///
    /// # Errors
    /// A folder that cannot be listed; recordings, and no folder of data.
    pub fn source(
        &self,
        data: Option<&Path>,
        (tracks, truth): (Option<&Path>, Option<&Path>),
    ) -> Result<SequenceSet, SweepError> {
        let tracks = match (&self.tracks, tracks) {
            (TrackSource::File(_), Some(dir)) => TrackSource::File(dir.to_path_buf()),
            (as_planned, _) => as_planned.clone(),
        };
        match &self.flights {
            Some(config) => Ok(SequenceSet::Flights { config: config.clone(), tracks }),
            None => {
                let published = SequenceSet::recorded(data.ok_or(SweepError::NoData)?, tracks)?;
                let truth = self.truth.as_deref().map(|as_planned| truth.unwrap_or(as_planned));
                Ok(published.with_reconciled_truth(truth))
            }
        }
    }

    /// The sweep over `source`.
    ///
    /// # Errors
    /// A sequence that is not there.
    pub fn sweep<'a>(
        &self,
        source: &'a SequenceSet,
        networks: &'a [Network],
        threads: usize,
    ) -> Result<Sweep<'a>, SweepError> {
        Ok(Sweep {
            source,
            places: source.select(&self.sequences.join(","))?,
            noises: self.noises.clone(),
            seeds: self.seeds.clone(),
            others: self.others.clone(),
            from: self.from,
            to: self.to,
            estimator: self.estimator.clone(),
            networks,
            threads,
            cache: None,
            keep: self.keep.clone(),
            injection: self.injection,
        })
    }
}
