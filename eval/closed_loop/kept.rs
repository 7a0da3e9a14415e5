//! What the cells of a sweep share: recordings, tracks, noise tracks, means over the training sequences.

use super::error::ClosedLoopError;
use super::lazy::Shared;
use super::recording::Recording;
use super::sight::Seen;
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
pub(super) struct Kept {
    recordings: BTreeMap<Place, Shared<Recording>>,
    frames: BTreeMap<Place, Shared<Seen>>,
    tracks: BTreeMap<(Place, String), Shared<NoiseTrack>>,
    means: BTreeMap<String, ImuNoise>,
}

impl Kept {
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
        shared(&self.recordings, &needs.recording, make)
    }

    /// The tracks, by `make` if there are none yet.
    pub(super) fn frames(
        &self,
        needs: &Needs,
        make: impl FnOnce() -> Result<Seen, ClosedLoopError>,
    ) -> Result<Arc<Seen>, ClosedLoopError> {
        shared(&self.frames, &needs.frames, make)
    }

    /// Sources of noise for one cell.
    pub(super) fn sources<'a>(
        &'a self,
        needs: &'a Needs,
        recorded: Recorded<'a>,
        networks: &'a [Network],
    ) -> impl Sources + 'a {
        OfCell { kept: self, needs, recorded, networks }
    }

    /// A cell is over.
    pub(super) fn done(&self, needs: &Needs) {
        if let Some(recording) = self.recordings.get(&needs.recording) {
            recording.done();
        }
        if let Some(frames) = self.frames.get(&needs.frames) {
            frames.done();
        }
        if let Some(track) = self.tracks.get(&needs.track()) {
            track.done();
        }
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

fn shared<K: Ord, T, E>(
    values: &BTreeMap<K, Shared<T>>,
    key: &K,
    make: impl FnOnce() -> Result<T, E>,
) -> Result<Arc<T>, E> {
    match values.get(key) {
        Some(value) => value.get(make),
        None => make().map(Arc::new),
    }
}

struct OfCell<'a> {
    kept: &'a Kept,
    needs: &'a Needs,
    recorded: Recorded<'a>,
    networks: &'a [Network],
}

impl Sources for OfCell<'_> {
    fn track(&self, source: &NoiseSpec) -> Result<Arc<NoiseTrack>, NoiseError> {
        let make = || of_recording(source, &self.recorded, self.networks);
        shared(&self.kept.tracks, &(self.needs.recording, source.to_string()), make)
    }

    fn training_mean(&self, source: &NoiseSpec) -> Result<ImuNoise, NoiseError> {
        let mean = self.kept.means.get(&source.to_string()).copied();
        mean.ok_or_else(|| NoiseError::NoTraining { spec: format!("mean-of-train({source})") })
    }
}
