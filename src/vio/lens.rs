//! What the calibration does not know of the lens, learned while the odometry runs.
//!
//! A calibrated lens is still some tenths of a pixel off, by a smooth field `f` that stays with the camera: a point is seen at `u + f(u)` where the calibration
//! has it at `u`. The error of a track changes as its point wanders over the image, and all tracks there err alike: it is no noise that averages out.
//!
//! `f` is a polynomial of the direction; its coefficients `c` are held to 0. Each time the window has been renewed, the residuals of the landmarks that its oldest
//! frame hosts are read once, as functions of `c`:
//! ```text
//! r(c) = r + K c,   K = (phi(u_target) - P phi(u_host)) / sigma
//! ```
//! with `P` the target's pixel by the host's and `sigma` a pixel's deviation. Depths, the hosts' own pixel errors and the poses of all frames but the host's are free
//! and taken out, so that only what no motion explains is laid on the lens; what remains of the normal equations is added up over the run. A shift of the
//! whole image looks like a turn and a growing image nearly like a nearer scene: of such fields little is learned, and little is to be gained.
//!
//! Source: bundle adjustment with additional parameters, D. C. Brown, "Close-range camera calibration", Photogrammetric Engineering 1971.

// Small fixed loops over rows and axes: with indices they read as the formulas do.
#![allow(clippy::needless_range_loop)]

use crate::factors::reprojection::PairGeometry;
use crate::state::POSE_DIM;
use crate::window::{Landmark, Window};
use dpn_core::Stamp;
use dpn_core::camera::CameraModel;
use nalgebra::{DMatrix, DVector, Matrix2x6, Matrix3, Vector2, Vector3};

/// Degree of the polynomials.
const DEGREE: usize = 6;
/// Coefficients of an axis.
const TERMS: usize = (DEGREE + 1) * (DEGREE + 2) / 2;
const FIELD: usize = 2 * TERMS;
/// Twice the tangent of half the angle off the optical axis at which polynomials are of 1.
const EDGE: f64 = 0.75;
/// How far the calibration may be off: deviation of a coefficient, which is what its term comes to at the image's edge \[px\].
const PRIOR_PX: f64 = 1.0;
/// Fields of degree 0 and 1, which a turn or a nearer scene looks like and noise is easily taken for, are held to 0 by this deviation \[px\].
const LIKE_MOTION: f64 = 0.1;
/// Fewest sightings of a landmark, and landmarks of a frame, that are read.
const FEWEST_SIGHTINGS: usize = 4;
const FEWEST_LANDMARKS: usize = 15;
/// A residual beyond this is another thing's \[standard deviations\].
const LARGEST: f64 = 3.0;
/// Errors of a track last over some images and reach over some tracks: so much of a row's information is its own.
const COUNTS: f64 = 0.05;

dpn_core::settings!(
    /// Settings.
    #[derive(Copy)]
    pub struct LensConfig {
        /// Whether the field is learned where points are followed through images. Tracks that err each for itself are of a camera that is as calibrated.
        pub learn: bool = true,
    }
);

/// The field so far.
#[derive(Debug, Clone)]
pub(crate) struct LensField {
    information: DMatrix<f64>,
    right: DVector<f64>,
    coefficients: DVector<f64>,
    /// Information that holds each coefficient to 0 \[1/px^2\].
    prior: DVector<f64>,
    /// Up to where residuals have been read.
    read_until: Option<Stamp>,
}

impl LensField {
    pub(crate) fn new() -> Self {
        Self {
            information: DMatrix::zeros(FIELD, FIELD),
            right: DVector::zeros(FIELD),
            coefficients: DVector::zeros(FIELD),
            prior: DVector::from_iterator(
                FIELD,
                degrees().chain(degrees()).map(|(i, j)| {
                    let deviation = if i + j < 2 { LIKE_MOTION } else { PRIOR_PX };
                    deviation.powi(-2)
                }),
            ),
            read_until: None,
        }
    }

    /// By how much the calibration misses what is seen in a direction \[px\].
    fn at(&self, bearing: &Vector3<f64>) -> Vector2<f64> {
        let powers = powers(bearing);
        let of = |first: usize| {
            powers.iter().zip(&self.coefficients.as_slice()[first..]).map(|(p, c)| p * c).sum()
        };
        Vector2::new(of(0), of(TERMS))
    }

    /// Its root mean square where `window` sees something, both axes \[px\].
    fn rms_px(&self, window: &Window) -> Option<f64> {
        let seen = window.landmarks().iter().map(|landmark| &landmark.host_sighting().bearing);
        let squares: Vec<f64> = seen.map(|bearing| self.at(bearing).norm_squared()).collect();
        (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
    }

    /// Where the calibration has what is seen at `px`; `None` outside what the odometry uses of the lens.
    pub(crate) fn calibrated(&self, camera: &CameraModel, px: &Vector2<f64>) -> Option<Vector2<f64>> {
        Some(px - self.at(&camera.sight(px)?))
    }

    /// Reads what is about to leave the window with its oldest frame, where the window has been renewed: how far off the calibration is then \[px\], root mean
    /// square over the points seen.
    pub(crate) fn read(&mut self, window: &Window) -> Option<f64> {
        let [first, .., last] = window.frames() else { return None };
        if self.read_until.is_some_and(|end| first.t < end) {
            return None;
        }
        let (information, right) = window.lens_equations(&self.coefficients)?;
        self.read_until = Some(last.t);
        self.information += information * COUNTS;
        self.right += right * COUNTS;
        let held = &self.information + DMatrix::from_diagonal(&self.prior);
        if let Some(factor) = held.cholesky() {
            self.coefficients = factor.solve(&self.right);
        }
        self.rms_px(window)
    }
}

/// Degrees in x and y of the terms of an axis, in their order.
fn degrees() -> impl Iterator<Item = (usize, usize)> {
    (0..=DEGREE).flat_map(|i| (0..=DEGREE - i).map(move |j| (i, j)))
}

/// Products of Legendre polynomials of the direction, the largest degree [`DEGREE`].
fn powers(bearing: &Vector3<f64>) -> [f64; TERMS] {
    let scale = 2.0 / (EDGE * (1.0 + bearing.z));
    let of = |x: f64| {
        let mut p = [1.0; DEGREE + 1];
        p[1] = x;
        for n in 1..DEGREE {
            let k = n as f64;
            p[n + 1] = ((2.0 * k + 1.0) * x * p[n] - k * p[n - 1]) / (k + 1.0);
        }
        p
    };
    let (x, y) = (of(bearing.x * scale), of(bearing.y * scale));
    let mut all = [0.0; TERMS];
    for (term, (i, j)) in all.iter_mut().zip(degrees()) {
        *term = x[i] * y[j];
    }
    all
}

impl Window {
    /// Normal equations of the field over the landmarks that the oldest frame hosts, whose sightings were corrected by `now`; `None` where they are too few.
    fn lens_equations(&self, now: &DVector<f64>) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let poses = POSE_DIM * (self.frames.len() - 1);
        // The field's columns, and last what is told.
        let mut all = DMatrix::<f64>::zeros(poses + FIELD + 1, poses + FIELD + 1);
        let hosted = |l: &&Landmark| l.host() == 0 && l.sightings.len() >= FEWEST_SIGHTINGS;
        let targets: Vec<PairGeometry> =
            (1..self.frames.len()).map(|frame| self.geometry(0, frame)).collect();
        let rows = self.landmarks.iter().filter(hosted).filter_map(|l| self.lens_rows(l, &targets, now));
        if rows.map(|rows| rows.add_to(&mut all, poses)).count() < FEWEST_LANDMARKS {
            return None;
        }
        // The scale of all ways is free: what holds it here is far below any sighting.
        let largest = (0..poses).map(|k| all[(k, k)]).fold(0.0, f64::max);
        let own = all.view((0, 0), (poses, poses)) + DMatrix::identity(poses, poses) * (1e-9 * largest);
        let shared = all.view((0, poses), (poses, FIELD + 1)).into_owned();
        let left =
            all.view((poses, poses), (FIELD + 1, FIELD + 1)) - shared.tr_mul(&own.cholesky()?.solve(&shared));
        let information = left.view((0, 0), (FIELD, FIELD)).into_owned();
        let right = -left.column(FIELD).rows(0, FIELD).into_owned();
        right.iter().all(|v| v.is_finite()).then_some((information, right))
    }

    /// Of a landmark of the oldest frame; `targets` are all frames after it.
    fn lens_rows(
        &self,
        landmark: &Landmark,
        targets: &[PairGeometry],
        now: &DVector<f64>,
    ) -> Option<LensRows> {
        let inverse_depth = landmark.inverse_depth?;
        let host = landmark.host_sighting();
        let seen_by_host = self.sighting_at_offset(host);
        let at_host = powers(&host.bearing);
        let others = &landmark.sightings[1..];
        let mut rows = LensRows {
            by_pose: Vec::with_capacity(others.len()),
            by_field: DMatrix::zeros(2 * others.len(), FIELD + 1),
            by_own: DMatrix::zeros(2 * others.len(), 3),
        };
        for (k, (frame, sighting)) in others.iter().enumerate() {
            let geometry = &targets[frame - 1];
            let seen = geometry.linearise(&seen_by_host, &self.sighting_at_offset(sighting), inverse_depth);
            if seen.residual.norm() > LARGEST {
                return None;
            }
            let pixel = seen.d_host_pixel(&host.spread);
            let at_target = powers(&sighting.bearing);
            for r in 0..2 {
                let row = 2 * k + r;
                for axis in 0..2 {
                    let target = if axis == r { 1.0 } else { 0.0 };
                    for term in 0..TERMS {
                        let moved = target * at_target[term] - pixel[r][axis] * at_host[term];
                        rows.by_field[(row, axis * TERMS + term)] = moved / self.config.pixel_std;
                    }
                    rows.by_own[(row, axis)] = pixel[r][axis];
                }
                rows.by_own[(row, 2)] = seen.depth[r];
                // As it would be had nothing been corrected.
                let corrected = rows.by_field.row(row).columns(0, FIELD).transpose().dot(now);
                rows.by_field[(row, FIELD)] = seen.residual[r] - corrected;
            }
            rows.by_pose.push((POSE_DIM * (frame - 1), Matrix2x6::from_fn(|r, c| seen.target[r][c])));
        }
        Some(rows)
    }
}

/// Residuals of one landmark, two for each target, and their derivatives.
struct LensRows {
    /// By the target's pose, and where that stands.
    by_pose: Vec<(usize, Matrix2x6<f64>)>,
    /// By the field's coefficients; the last column is the residual.
    by_field: DMatrix<f64>,
    /// By the host's pixel and the inverse depth.
    by_own: DMatrix<f64>,
}

impl LensRows {
    /// Adds their squares, what the landmark's own unknowns explain taken out.
    fn add_to(&self, all: &mut DMatrix<f64>, poses: usize) {
        let held = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 1e-12));
        let own = self.by_own.tr_mul(&self.by_own).fixed_view::<3, 3>(0, 0) + held;
        let columns = all.ncols();
        let mut shared = DMatrix::<f64>::zeros(3, columns);
        shared.columns_mut(poses, FIELD + 1).copy_from(&self.by_own.tr_mul(&self.by_field));
        for (k, (place, by_pose)) in self.by_pose.iter().enumerate() {
            let (by_field, by_own) = (self.by_field.rows(2 * k, 2), self.by_own.rows(2 * k, 2));
            shared.columns_mut(*place, POSE_DIM).copy_from(&by_own.tr_mul(by_pose));
            let mut square = all.view_mut((*place, *place), (POSE_DIM, POSE_DIM));
            square += by_pose.tr_mul(by_pose);
            let mut coupling = all.view_mut((*place, poses), (POSE_DIM, FIELD + 1));
            coupling += by_pose.tr_mul(&by_field);
        }
        let mut field = all.view_mut((poses, poses), (FIELD + 1, FIELD + 1));
        field.gemm(1.0, &self.by_field.transpose(), &self.by_field, 1.0);
        let factor = own.cholesky().expect("squares, and something on the diagonal");
        let explained =
            factor.l().solve_lower_triangular(&shared).expect("a factor's diagonal is above zero");
        all.gemm(-1.0, &explained.transpose(), &explained, 1.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::factors::reprojection::Sighting;
    use crate::init::tests::{Scene, body_from_cam, gentle_flight};
    use crate::state::NavState;
    use crate::window::{Seen, WindowConfig};

    /// A flight seen without noise through a lens that is off by `field`.
    fn window(field: &LensField) -> Window {
        let scene = Scene::new(&gentle_flight(4), 8, 0.15, 0.0, 4);
        let camera = CameraModel::euroc_cam0();
        let mut window =
            Window::new(WindowConfig { pixel_std: 0.5, ..WindowConfig::default() }, body_from_cam());
        for k in 0..8 {
            let sighting = |bearing: &Vector3<f64>| {
                Sighting::new(&camera, &(camera.project(bearing)? + field.at(bearing)), 0.5)
            };
            let seen: Vec<Seen> = scene.frames[k]
                .bearings()
                .iter()
                .filter_map(|(id, bearing)| Some(Seen { id: *id, sighting: sighting(bearing)? }))
                .collect();
            let state = NavState {
                world_from_body: scene.cameras[k] * body_from_cam().inverse(),
                vel_in_world: scene.velocities[k],
                bias: scene.bias,
            };
            window.add_frame(scene.frames[k].t, state, None, &seen);
        }
        window.triangulate();
        window
    }

    fn field(largest: f64) -> LensField {
        let mut field = LensField::new();
        for (k, c) in field.coefficients.iter_mut().enumerate() {
            *c = largest * (1.7 * k as f64).sin();
        }
        field
    }

    #[test]
    fn polynomials_are_legendre_s() {
        let x = 0.4_f64;
        let angle = 2.0 * (0.5 * EDGE * x).atan();
        let powers = powers(&Vector3::new(angle.sin(), 0.0, angle.cos()));
        // Of y alone up to the largest degree, then x times those, and so on.
        let of_x = powers[DEGREE + 1];
        assert!((of_x - x).abs() < 1e-12 && powers[0] == 1.0 && powers[1].abs() < 1e-12);
        let second = powers[2 * DEGREE + 1];
        assert!((second - 0.5 * (3.0 * x * x - 1.0)).abs() < 1e-12, "{second}");
    }

    #[test]
    fn the_equations_tell_the_field_that_moved_the_sightings() {
        let moved = field(2e-3);
        let (still, mut window) = (window(&field(0.0)), window(&moved));
        for (landmark, as_it_was) in window.landmarks.iter_mut().zip(&still.landmarks) {
            assert_eq!(landmark.id, as_it_was.id);
            landmark.inverse_depth = as_it_was.inverse_depth;
        }
        let nothing = DVector::zeros(FIELD);
        let (_, before) = still.lens_equations(&nothing).unwrap();
        let (information, after) = window.lens_equations(&nothing).unwrap();
        let expected = &information * &moved.coefficients;
        let missed = (&after - &before - &expected).norm();
        assert!(missed < 0.01 * expected.norm(), "{missed:.1e} of {:.1e}", expected.norm());
        assert!((&information - information.transpose()).amax() < 1e-9 * information.amax());
        // Said to have been corrected by it, the same sightings tell as much once more.
        let (_, twice) = window.lens_equations(&moved.coefficients).unwrap();
        assert!((twice - &after - &expected).norm() < 1e-6 * expected.norm());
    }

    #[test]
    fn a_window_is_read_once() {
        let window = window(&field(0.1));
        let mut learned = LensField::new();
        learned.read(&window);
        let once = learned.clone();
        learned.read(&window);
        assert_eq!(learned.information, once.information);
        assert!(
            learned.coefficients.norm() > 0.0
                && learned.read_until == Some(window.frames().last().unwrap().t)
        );
    }
}
