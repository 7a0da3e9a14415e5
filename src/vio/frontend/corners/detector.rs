//! New points beside those that are tracked already.

use super::config::CornerConfig;
use super::mask::Mask;
use super::response::{Candidate, Find, Rows};
use crate::frontend::image::Plane;
use pulp::Arch;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A new point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// Where it is \[px\].
    pub px: [f32; 2],
    /// Its response \[(grey/px)^2\].
    pub response: f32,
}

/// Finds corners in plane after plane; its memory is kept.
#[derive(Debug, Clone)]
pub struct Detector {
    config: CornerConfig,
    rows: Rows,
    candidates: Vec<Candidate>,
}

/// Strongest first; of two as strong, the one nearer the image's end, as OpenCV has it.
#[derive(Debug, Clone, Copy)]
struct Strongest(Candidate);

impl PartialEq for Strongest {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Strongest {}

impl PartialOrd for Strongest {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Strongest {
    fn cmp(&self, other: &Self) -> Ordering {
        let (a, b) = (&self.0, &other.0);
        a.response.total_cmp(&b.response).then((a.y, a.x).cmp(&(b.y, b.x)))
    }
}

impl Detector {
    /// A detector with `config`, which [validates](dpn_core::config::Validate).
    pub fn new(config: CornerConfig) -> Self {
        Self { config, rows: Rows::default(), candidates: Vec::new() }
    }

    /// Corners that bring the points of a frame up to `most`, strongest first, given those it has.
    ///
    /// # After the call
    /// `mask`, which said where corners may be, has also the discs around tracked points and around those found.
    pub fn detect(&mut self, plane: &Plane, mask: &mut Mask, tracked: &[[f32; 2]]) -> Vec<Corner> {
        let CornerConfig { most, quality, least, distance_px, edge_px, cells } = self.config;
        let room = most.saturating_sub(tracked.len());
        if room == 0 {
            return Vec::new();
        }
        tracked.iter().for_each(|px| mask.take_disc(*px, distance_px));
        Arch::new().dispatch(Find {
            plane,
            mask,
            quality: quality as f32,
            least: least as f32,
            edge: edge_px,
            rows: &mut self.rows,
            found: &mut self.candidates,
        });

        let mut cells = Cells::new(plane, cells, most);
        tracked.iter().for_each(|px| cells.count(*px));
        let mut corners = Vec::with_capacity(room);
        let mut waiting = Vec::new();
        let mut heap: BinaryHeap<Strongest> = self.candidates.drain(..).map(Strongest).collect();
        let mut take = |Candidate { response, x, y }: Candidate, corners: &mut Vec<Corner>| {
            if mask.is_free(x as usize, y as usize) {
                let px = [x as f32, y as f32];
                mask.take_disc(px, distance_px);
                corners.push(Corner { px, response });
            }
        };
        while corners.len() < room
            && let Some(Strongest(candidate)) = heap.pop()
        {
            let place = [candidate.x as f32, candidate.y as f32];
            if cells.is_full(place) {
                waiting.push(candidate);
                continue;
            }
            let before = corners.len();
            take(candidate, &mut corners);
            if corners.len() > before {
                cells.count(place);
            }
        }
        for candidate in waiting {
            if corners.len() >= room {
                break;
            }
            take(candidate, &mut corners);
        }
        self.candidates = heap.into_vec().into_iter().map(|strongest| strongest.0).collect();
        corners
    }
}

/// How many points each cell of the image has.
struct Cells {
    size: f32,
    columns: usize,
    counts: Vec<usize>,
    most: usize,
}

impl Cells {
    /// `columns` cells in a row; none when 0.
    fn new(plane: &Plane, columns: usize, most: usize) -> Self {
        if columns == 0 {
            return Self { size: 1.0, columns: 0, counts: Vec::new(), most: 0 };
        }
        let size = plane.width() as f32 / columns as f32;
        let rows = (plane.height() as f32 / size).ceil().max(1.0) as usize;
        let cells = columns * rows;
        Self { size, columns, counts: vec![0; cells], most: (3 * most).div_ceil(2 * cells) }
    }

    fn index(&self, px: [f32; 2]) -> Option<usize> {
        if self.columns == 0 {
            return None;
        }
        let [x, y] = px.map(|c| (c / self.size) as usize);
        Some((y * self.columns + x.min(self.columns - 1)).min(self.counts.len() - 1))
    }

    fn count(&mut self, px: [f32; 2]) {
        if let Some(index) = self.index(px) {
            self.counts[index] += 1;
        }
    }

    fn is_full(&self, px: [f32; 2]) -> bool {
        self.index(px).is_some_and(|index| self.counts[index] >= self.most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::GrayImage;

    /// Squares of rising contrast from left to right.
    fn squares() -> Plane {
        let image = GrayImage::from_fn(320, 240, |x, y| {
            let on = (x / 10 + y / 10) % 2 == 0;
            if on { 100 + (x / 3) as u8 } else { 100 }
        });
        Plane::new(image.unwrap().view())
    }

    fn nearest(corners: &[Corner], px: [f32; 2]) -> f32 {
        corners.iter().map(|c| (c.px[0] - px[0]).hypot(c.px[1] - px[1])).fold(f32::INFINITY, f32::min)
    }

    #[test]
    fn points_keep_their_distance_and_the_strongest_come_first() {
        let plane = squares();
        let config = CornerConfig { most: 60, distance_px: 14.0, cells: 0, ..CornerConfig::default() };
        let tracked = [[300.0, 200.0], [200.0, 100.0]];
        let corners = Detector::new(config).detect(&plane, &mut Mask::free(320, 240), &tracked);
        assert_eq!(corners.len(), 58);
        assert!(corners.is_sorted_by(|a, b| a.response >= b.response));
        for (i, corner) in corners.iter().enumerate() {
            assert!(nearest(&corners[..i], corner.px) >= 14.0);
            assert!(tracked.iter().all(|t| nearest(&[*corner], *t) >= 14.0));
        }
        // The strongest are all at the right.
        assert!(corners.iter().all(|c| c.px[0] > 150.0));
    }

    #[test]
    fn cells_spread_points_over_the_image() {
        let plane = squares();
        let config = CornerConfig { most: 60, distance_px: 14.0, cells: 8, ..CornerConfig::default() };
        let corners = Detector::new(config).detect(&plane, &mut Mask::free(320, 240), &[]);
        assert_eq!(corners.len(), 60);
        let left = corners.iter().filter(|c| c.px[0] < 155.0).count();
        assert!(left >= 12, "{left} of 60 in the left half");
        let mut cells = Cells::new(&plane, 8, 60);
        corners.iter().for_each(|c| cells.count(c.px));
        assert!(cells.counts.iter().all(|count| *count <= 2), "{:?}", cells.counts);
    }

    #[test]
    fn a_full_frame_and_a_flat_image_get_nothing() {
        let plane = squares();
        let mut detector = Detector::new(CornerConfig { most: 1, ..CornerConfig::default() });
        assert!(detector.detect(&plane, &mut Mask::free(320, 240), &[[5.0, 5.0]]).is_empty());
        let flat = GrayImage::from_fn(320, 240, |x, y| 20 + ((x * 7 + y * 3) % 2) as u8).unwrap();
        let mut detector = Detector::new(CornerConfig::default());
        assert!(detector.detect(&Plane::new(flat.view()), &mut Mask::free(320, 240), &[]).is_empty());
        assert!(detector.detect(&plane, &mut Mask::free(3, 3), &[]).is_empty(), "a mask of another size");
    }
}
