//! The world that the camera looks at: points on the inside of a box around the flight, its faces in relief.

use super::path::Bounds;
use dpn_core::random::Stream;
use nalgebra::Vector3;
use rand::Rng;
use rand_distr::{Distribution, Exp};
use serde::{Deserialize, Serialize};

/// Kind of world.
///
/// | | beside the flight | below | above | mean relief | points |
/// |---|---|---|---|---|---|
/// | room | 2 m | .8 m | 1.5 m | .12 m | 6000 |
/// | hall | 4 m | 1 m | 4 m | .25 m | 9000 |
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum World {
    /// A hall for flights of 8 m and more along x or y, else a room: EuRoC's rooms are flown over up to 6.1 m, its hall from 11.2 m on.
    Auto,
    /// A room: walls near.
    Room,
    /// A hall: walls far, deeper relief.
    Hall,
}

/// Horizontal size of a flight from which on [`World::Auto`] is a hall \[m\].
const HALL_FROM_M: f64 = 8.0;

/// A world's figures \[m\].
pub(crate) struct Figures {
    /// From the flight to the walls.
    pub(crate) side: f64,
    /// From the flight to the floor.
    pub(crate) down: f64,
    /// From the flight to the ceiling.
    pub(crate) up: f64,
    /// Mean relief.
    pub(crate) relief: f64,
    /// Points on its faces.
    points: usize,
}

impl World {
    /// Room or hall for a flight within `bounds`.
    #[must_use]
    pub fn settled(self, bounds: &Bounds) -> Self {
        match self {
            Self::Auto if (bounds.high - bounds.low).xy().max() >= HALL_FROM_M => Self::Hall,
            Self::Auto => Self::Room,
            settled => settled,
        }
    }

    /// The figures of the world around a flight within `bounds`.
    pub(crate) fn figures(self, bounds: &Bounds) -> Figures {
        match self.settled(bounds) {
            Self::Hall => Figures { side: 4.0, down: 1.0, up: 4.0, relief: 0.25, points: 9000 },
            Self::Auto | Self::Room => Figures { side: 2.0, down: 0.8, up: 1.5, relief: 0.12, points: 6000 },
        }
    }
}

/// The points of a world \[m, world frame\], one array an axis so that loops over them vectorise.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Points {
    pub(super) x: Vec<f64>,
    pub(super) y: Vec<f64>,
    pub(super) z: Vec<f64>,
}

impl Points {
    /// Covers the box around a flight within `bounds`, every face as densely as the others.
    pub(super) fn around(bounds: &Bounds, world: World, stream: &Stream) -> Self {
        let figures = world.figures(bounds);
        let low = bounds.low - Vector3::new(figures.side, figures.side, figures.down);
        let high = bounds.high + Vector3::new(figures.side, figures.side, figures.up);
        let size = high - low;
        // Faces in pairs: across x, across y, across z.
        let areas = [size.y * size.z, size.x * size.z, size.x * size.y];
        let all: f64 = 2.0 * areas.iter().sum::<f64>();
        let mut rng = stream.named("world").rng();
        let mut points = Self { x: Vec::new(), y: Vec::new(), z: Vec::new() };
        for _ in 0..figures.points {
            let mut place = rng.random::<f64>() * all;
            let mut face = 0;
            while face < 5 && place >= areas[face / 2] {
                place -= areas[face / 2];
                face += 1;
            }
            let mut point = low + size.component_mul(&Vector3::from_fn(|_, _| rng.random::<f64>()));
            let relief = relief(figures.relief, &mut rng);
            let axis = face / 2;
            point[axis] = if face % 2 == 1 { high[axis] - relief } else { low[axis] + relief };
            let point = point.sup(&low).inf(&high);
            points.x.push(point.x);
            points.y.push(point.y);
            points.z.push(point.z);
        }
        points
    }

    pub(super) fn len(&self) -> usize {
        self.x.len()
    }
}

/// How far a point stands out of its face \[m\]: exponential of that mean.
fn relief(mean: f64, rng: &mut impl Rng) -> f64 {
    Exp::new(1.0 / mean).expect("a positive mean").sample(rng)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds(size: f64) -> Bounds {
        Bounds { low: Vector3::new(-1.0, 2.0, 0.0), high: Vector3::new(size - 1.0, 4.0, 2.0) }
    }

    #[test]
    fn auto_tells_rooms_from_halls_by_the_flights_size() {
        assert_eq!(World::Auto.settled(&bounds(6.1)), World::Room);
        assert_eq!(World::Auto.settled(&bounds(11.2)), World::Hall);
        assert_eq!(World::Room.settled(&bounds(20.0)), World::Room);
    }

    #[test]
    fn points_lie_near_the_six_faces_as_many_as_their_areas_ask_for() {
        let points = Points::around(&bounds(5.0), World::Room, &Stream::new(1));
        assert_eq!(points.len(), 6000);
        let (low, high) = (Vector3::new(-3.0, 0.0, -0.8), Vector3::new(6.0, 6.0, 3.5));
        let mut near = [0.0_f64; 6];
        let mut depth = 0.0;
        for i in 0..points.len() {
            let point = Vector3::new(points.x[i], points.y[i], points.z[i]);
            let distances: Vec<f64> = (0..6)
                .map(|f| if f % 2 == 1 { high[f / 2] - point[f / 2] } else { point[f / 2] - low[f / 2] })
                .collect();
            let (face, least) =
                distances.iter().copied().enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
            assert!(least >= 0.0, "outside: {point}");
            near[face] += 1.0;
            depth += least;
        }
        // Areas 6 x 4.3, 9 x 4.3, 9 x 6, each twice. A point in a corner may be nearer to a face that is not its own, hence 10 %; the
        // standard deviation of the counts is 3 % or less.
        let areas = [25.8, 25.8, 38.7, 38.7, 54.0, 54.0];
        for (count, area) in near.iter().zip(areas) {
            let expected = 6000.0 * area / 237.0;
            assert!((count / expected - 1.0).abs() < 0.12, "{near:?}");
        }
        let mean = depth / 6000.0;
        assert!((mean - 0.12).abs() < 0.02, "{mean}");
    }
}
