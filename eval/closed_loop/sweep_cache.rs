//! What the cells of a sweep share: recordings, tracks, noise tracks, means over the training sequences.

use super::error::ClosedLoopError;
use super::lazy::Shared;
use super::recording::Recording;
use super::tracked::TrackedSequence;
use crate::noise::{NoiseError, Recorded, Sources, of_recording};
use dpn_core::estimate::NoiseSpec;
use dpn_core::{ImuNoise, NoiseTrack};
use dpn_pronet::network::Network;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Place and seed of a sequence; seed 0 where it matters not.
type Place = (usize, u64);

/// What a cell needs.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Needs {
    /// The recording.
    pub(super) recording: Place,
    /// Its tracks.
    pub(super) frames: Place,
    /// The spec whose noise track is the source of the cell's noise.
    pub(super) noise: String,
}

impl Needs {
    fn track(&self) -> (Place, String) {
        (self.recording, self.noise.clone())
    }
}

/// Everything that is shared, made when first needed.
#[derive(Debug)]
pub(super) struct SweepCache {
    recordings: BTreeMap<Place, Shared<Recording>>,
    frames: BTreeMap<Place, Shared<TrackedSequence>>,
    tracks: BTreeMap<(Place, String), Shared<NoiseTrack>>,
    means: BTreeMap<String, ImuNoise>,
}

impl SweepCache {
    /// For cells with these needs, each of which will be [`done`](Self::done) once; `means` by the spec they are of.
    pub(super) fn new(needs: &[Needs], means: BTreeMap<String, ImuNoise>) -> Self {
        Self {
            recordings: counted(needs.iter().map(|n| n.recording)),
            frames: counted(needs.iter().map(|n| n.frames)),
            tracks: counted(needs.iter().map(Needs::track)),
            means,
        }
    }

    /// The recording, by `make` if there is none yet.
    pub(super) fn recording(
        &self,
        needs: &Needs,
        make: impl FnOnce() -> Result<Recording, ClosedLoopError>,
    ) -> Result<Arc<Recording>, ClosedLoopError> {
        counted_before(&self.recordings, &needs.recording).get(make)
    }

    /// The tracks, by `make` if there are none yet.
    pub(super) fn frames(
        &self,
        needs: &Needs,
        make: impl FnOnce() -> Result<TrackedSequence, ClosedLoopError>,
    ) -> Result<Arc<TrackedSequence>, ClosedLoopError> {
        counted_before(&self.frames, &needs.frames).get(make)
    }

    /// Sources of noise for one cell.
    pub(super) fn sources<'a>(
        &'a self,
        needs: &'a Needs,
        recorded: Recorded<'a>,
        networks: &'a [Network],
    ) -> impl Sources + 'a {
        OfCell { cache: self, needs, recorded, networks }
    }

    /// A cell is over.
    pub(super) fn done(&self, needs: &Needs) {
        counted_before(&self.recordings, &needs.recording).done();
        counted_before(&self.frames, &needs.frames).done();
        counted_before(&self.tracks, &needs.track()).done();
    }
}

/// A value for every key, with as many uses as the key comes.
fn counted<K: Ord, T>(keys: impl Iterator<Item = K>) -> BTreeMap<K, Shared<T>> {
    let mut counts: BTreeMap<K, usize> = BTreeMap::new();
    for key in keys {
        *counts.entry(key).or_default() += 1;
    }
    counts.into_iter().map(|(key, uses)| (key, Shared::new(uses))).collect()
}

fn counted_before<'a, K: Ord, T>(values: &'a BTreeMap<K, Shared<T>>, key: &K) -> &'a Shared<T> {
    values.get(key).expect("every cell's needs were counted before the first cell began")
}

struct OfCell<'a> {
    cache: &'a SweepCache,
    needs: &'a Needs,
    recorded: Recorded<'a>,
    networks: &'a [Network],
}

impl Sources for OfCell<'_> {
    fn track(&self, source: &NoiseSpec) -> Result<Arc<NoiseTrack>, NoiseError> {
        let make = || of_recording(source, &self.recorded, self.networks);
        counted_before(&self.cache.tracks, &(self.needs.recording, source.to_string())).get(make)
    }

    fn training_mean(&self, source: &NoiseSpec) -> Result<ImuNoise, NoiseError> {
        let mean = self.cache.means.get(&source.to_string()).copied();
        mean.ok_or_else(|| NoiseError::NoTraining { spec: format!("mean-of-train({source})") })
    }
}
