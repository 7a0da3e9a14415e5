//! What a calibration does not know of a lens, seen in how tracks miss their epipolar lines.
//!
//! A lens that sends a point w(u) aside of where its calibration has it moves the track's distance from its epipolar line by the line's normals times w at
//! both ends. w is a polynomial of the image, the same over all frames; what a frame's own fundamental matrix could take up is left out of both sides.

use dpn_core::signal::stats::median;
use dpn_vio::frontend::ransac::Pair;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// Degree of the polynomials.
const DEGREE: i32 = 8;
/// What powers are of is about 1 at the image's edge, as a tangent.
const EDGE: f64 = 0.9;
/// Tracks farther from their line are another motion's \[px\].
const WITHIN_PX: f64 = 0.3;
/// Fewest tracks of a frame that its own matrix leaves something of.
const FEWEST: usize = 40;
/// Of a fundamental matrix.
const FREEDOMS: usize = 8;
const REWEIGHTED: usize = 8;
/// Keeps corners of the image without tracks at nothing.
const RIDGE: f64 = 1e-6;

/// A frame's tracks with those of the frame before, and the fundamental matrix that most of them agree on.
#[derive(Debug, Clone)]
pub(crate) struct Matched {
    pub pairs: Vec<Pair>,
    pub matrix: Matrix3<f64>,
    pub px_per_rad: f64,
}

impl Matched {
    /// Distances from the epipolar lines \[px\].
    pub(crate) fn distances_px(&self) -> impl Iterator<Item = f64> {
        self.pairs.iter().map(|pair| self.px_per_rad * pair.distance_squared(&self.matrix).sqrt())
    }

    /// Signed distances, what w's coefficients do to them, what the matrix's own do.
    fn rows(&self) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let near = |pair: &&Pair| self.px_per_rad * pair.distance_squared(&self.matrix).sqrt() < WITHIN_PX;
        let pairs: Vec<&Pair> = self.pairs.iter().filter(near).collect();
        if pairs.len() < FEWEST {
            return None;
        }
        let terms = powers(&Vector3::z()).len();
        let mut missed = DVector::zeros(pairs.len());
        let mut by_field = DMatrix::zeros(pairs.len(), 2 * terms);
        let mut by_matrix = DMatrix::zeros(pairs.len(), 9);
        for (row, pair) in pairs.iter().enumerate() {
            let (at_cur, at_prev) = (self.matrix * pair.prev, self.matrix.tr_mul(&pair.cur));
            let scale = (at_cur.norm_squared() + at_prev.norm_squared()).sqrt();
            let off = pair.cur.dot(&at_cur) / scale;
            missed[row] = self.px_per_rad * off;
            // Where they would meet their lines: a field that only makes the image smaller, and distances with it, has no part in what follows.
            let (prev, cur) = (pair.prev - at_prev * (off / scale), pair.cur - at_cur * (off / scale));
            let (at_cur, at_prev) = (self.matrix * prev, self.matrix.tr_mul(&cur));
            for (ray, normal) in [(&prev, at_prev), (&cur, at_cur)] {
                let normal = normal * (ray.z / scale);
                for (k, power) in powers(ray).into_iter().enumerate() {
                    by_field[(row, k)] += normal.x * power;
                    by_field[(row, terms + k)] += normal.y * power;
                }
            }
            for (k, product) in (cur * prev.transpose()).iter().enumerate() {
                by_matrix[(row, k)] = self.px_per_rad * product / scale;
            }
        }
        let basis = by_matrix.svd(true, false).u?.columns(0, FREEDOMS).into_owned();
        missed -= &basis * basis.tr_mul(&missed);
        by_field -= &basis * basis.tr_mul(&by_field);
        Some((missed, by_field))
    }
}

/// The products of powers of a point's place up to [`DEGREE`].
fn powers(ray: &Vector3<f64>) -> Vec<f64> {
    let [x, y] = [ray.x, ray.y].map(|side| side / (ray.z * EDGE));
    let of = |i: i32| (0..=DEGREE - i).map(move |j| x.powi(i) * y.powi(j));
    (0..=DEGREE).flat_map(of).collect()
}

/// Medians of the distances of `judged`'s tracks from their epipolar lines \[px\], without a field and with the one that fits `fitted` best; `None` where
/// either has too few tracks.
pub(crate) fn lens_error(fitted: &[Matched], judged: &[Matched]) -> Option<[f64; 2]> {
    let all = |frames: &[Matched]| -> Vec<_> { frames.iter().filter_map(Matched::rows).collect() };
    let (fitted, judged) = (all(fitted), all(judged));
    let terms = fitted.first()?.1.ncols();
    let mut field = DVector::zeros(terms);
    let left = |rows: &[(DVector<f64>, DMatrix<f64>)], field: &DVector<f64>| -> Vec<f64> {
        rows.iter()
            .flat_map(|(missed, by)| (missed - by * field).iter().map(|d| d.abs()).collect::<Vec<_>>())
            .collect()
    };
    for _ in 0..REWEIGHTED {
        let width = 2.0 * 1.4826 * median(&left(&fitted, &field));
        let mut normal = DMatrix::identity(terms, terms) * RIDGE;
        let mut right = DVector::zeros(terms);
        for (missed, by) in &fitted {
            let weights = (missed - by * &field).map(|d| 1.0 / (1.0 + (d / width).powi(2)));
            let weighted = DMatrix::from_fn(by.nrows(), terms, |row, k| by[(row, k)] * weights[row]);
            normal += weighted.tr_mul(by);
            right += weighted.tr_mul(missed);
        }
        field = normal.cholesky()?.solve(&right);
    }
    (!judged.is_empty()).then(|| [DVector::zeros(terms), field].map(|field| median(&left(&judged, &field))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;
    use nalgebra::Rotation3;
    use rand::Rng;

    /// Frames of a camera that moves through points, each ray aside by a wave of `amplitude` radians.
    fn frames(amplitude: f64, seed: u64) -> Vec<Matched> {
        let mut rng = Stream::new(seed).named("lens error").rng();
        let mut side = move |reach: f64| reach * (2.0 * rng.random::<f64>() - 1.0);
        let aside = |at: Vector3<f64>| {
            let (x, y) = (at.x / at.z, at.y / at.z);
            Vector3::new(x + amplitude * (9.0 * y + 1.0).sin(), y + amplitude * (8.0 * x).sin(), 1.0)
                .normalize()
        };
        let frame = |_| {
            let (turn, step) = (Vector3::from_fn(|_, _| side(0.03)), Vector3::from_fn(|_, _| side(0.2)));
            let rotation = Rotation3::new(turn);
            let pairs = (0..150).map(|_| {
                let depth = 3.0 + side(2.0);
                let point = Vector3::new(side(0.7) * depth, side(0.45) * depth, depth);
                let noise = Vector3::new(side(1e-4), side(1e-4), 0.0);
                Pair { prev: aside(point), cur: (aside(rotation * point + step) + noise).normalize() }
            });
            Matched {
                pairs: pairs.collect(),
                matrix: step.cross_matrix() * rotation.matrix(),
                px_per_rad: 460.0,
            }
        };
        (0..12).map(frame).collect()
    }

    #[test]
    fn a_field_that_stays_with_the_camera_is_found_and_none_is_not() {
        let [without, with] = lens_error(&frames(6e-4, 1), &frames(6e-4, 2)).unwrap();
        assert!(with < 0.6 * without, "{without} {with}");
        let [without, with] = lens_error(&frames(0.0, 1), &frames(0.0, 2)).unwrap();
        assert!(with > 0.97 * without, "{without} {with}");
        assert_eq!(lens_error(&[], &frames(0.0, 1)), None);
    }
}
