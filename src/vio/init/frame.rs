//! What the initialisation sees of the camera: directions to tracked points, and what two frames share.

use crate::factors::reprojection::Sighting;
use crate::window::Landmark;
use dpn_core::time::Stamp;
use nalgebra::Vector3;

/// One frame's tracks as directions.
#[derive(Debug, Clone, PartialEq)]
pub struct InitFrame {
    /// When the image was taken, in the IMU's clock.
    pub t: Stamp,
    /// Track id and unit vector towards the point in the camera's frame; each id at most once, in increasing order.
    bearings: Vec<(u64, Vector3<f64>)>,
}

impl InitFrame {
    /// A frame of unit `bearings` in any order; of an id that comes twice the first stays, what is not finite goes.
    pub fn new(t: Stamp, mut bearings: Vec<(u64, Vector3<f64>)>) -> Self {
        bearings.retain(|(_, b)| b.iter().all(|x| x.is_finite()));
        bearings.sort_by_key(|(id, _)| *id);
        bearings.dedup_by_key(|(id, _)| *id);
        Self { t, bearings }
    }

    /// Id and unit direction, by increasing id.
    pub(crate) fn bearings(&self) -> &[(u64, Vector3<f64>)] {
        &self.bearings
    }

    /// The direction in which this frame sees the track `id`.
    pub fn bearing(&self, id: u64) -> Option<Vector3<f64>> {
        self.bearings.binary_search_by_key(&id, |(known, _)| *known).ok().map(|at| self.bearings[at].1)
    }
}

/// The directions in which two frames see the tracks that both hold.
pub(super) fn shared(a: &InitFrame, b: &InitFrame) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let (mut i, mut j) = (0, 0);
    let mut pairs = Vec::new();
    while let (Some((id_a, in_a)), Some((id_b, in_b))) = (a.bearings.get(i), b.bearings.get(j)) {
        match id_a.cmp(id_b) {
            std::cmp::Ordering::Less => i += 1,
            std::cmp::Ordering::Greater => j += 1,
            std::cmp::Ordering::Equal => {
                pairs.push((*in_a, *in_b));
                i += 1;
                j += 1;
            }
        }
    }
    pairs
}

/// The tracks that at least two of `frames` see, by increasing id, their directions good to `std` \[rad\]; no depth is known.
pub(super) fn tracks(frames: &[&InitFrame], std: f64) -> Vec<Landmark> {
    let mut all: Vec<(u64, usize, Sighting)> = frames
        .iter()
        .enumerate()
        .flat_map(|(at, frame)| frame.bearings().iter().map(move |(id, b)| (id, at, b)))
        .filter_map(|(id, at, bearing)| Some((*id, at, Sighting::from_bearing(bearing, std)?)))
        .collect();
    all.sort_by_key(|(id, at, _)| (*id, *at));
    all.chunk_by(|a, b| a.0 == b.0)
        .filter(|seen| seen.len() > 1)
        .map(|seen| Landmark {
            id: seen[0].0,
            sightings: seen.iter().map(|(_, at, sighting)| (*at, *sighting)).collect(),
            inverse_depth: None,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(ids: &[u64]) -> InitFrame {
        let bearings = ids.iter().map(|id| (*id, Vector3::new(*id as f64 * 0.01, 0.0, 1.0).normalize()));
        InitFrame::new(Stamp::from_ns(0), bearings.collect())
    }

    #[test]
    fn frames_share_the_ids_that_both_hold_whatever_their_order() {
        let pairs = shared(&frame(&[7, 1, 3, 9]), &frame(&[9, 2, 3]));
        let expected = [3, 9].map(|id: u64| Vector3::new(id as f64 * 0.01, 0.0, 1.0).normalize());
        assert_eq!(pairs, expected.map(|b| (b, b)));
    }

    #[test]
    fn a_frame_keeps_one_finite_bearing_an_id() {
        let bad = Vector3::new(f64::NAN, 0.0, 1.0);
        let frame = InitFrame::new(Stamp::from_ns(0), vec![(2, Vector3::z()), (1, bad), (2, Vector3::x())]);
        assert_eq!(frame.bearings(), [(2, Vector3::z())]);
        assert_eq!(frame.bearing(2), Some(Vector3::z()));
        assert_eq!(frame.bearing(1), None);
    }

    #[test]
    fn tracks_are_what_two_frames_see() {
        let frames = [frame(&[1, 2]), frame(&[2, 3]), frame(&[2, 3])];
        let found = tracks(&frames.iter().collect::<Vec<_>>(), 1e-3);
        assert_eq!(found.iter().map(|l| (l.id, l.sightings.len())).collect::<Vec<_>>(), [(2, 3), (3, 2)]);
        assert_eq!(found[1].host(), 1);
    }
}
