//! Levenberg-Marquardt on the Schur complement over the points.
//!
//! ```text
//! [ A   W ] [ x ]     [ a ]         S x = a - W C^-1 c,   S = A - W C^-1 W^T
//! [ W^T C ] [ l ] = - [ c ]         l   = -C^-1 (c + W^T x)
//! ```
//! `C` is block diagonal, 3 by 3 a point. Both diagonals are damped by the factor `1 + lambda`.

use super::problem::{Bundle, BundleState};
use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, Vector3};

/// First damping; a linear start is near enough for it to be small.
const FIRST_DAMPING: f64 = 1e-4;
/// Beyond this no step helps.
const LAST_DAMPING: f64 = 1e8;
/// A step that lowers the cost by less than this share ends the search.
const SMALL_GAIN: f64 = 1e-6;
/// Least damped diagonal of a point's block, over its largest entry: a point at infinity keeps an invertible one.
const POINT_FLOOR: f64 = 1e-12;

/// How a search ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Solved {
    /// Steps tried.
    pub steps: usize,
    /// Cost at the end.
    pub cost: f64,
}

/// A point's part of the normal equations.
#[derive(Debug, Clone)]
pub(super) struct PointBlock {
    pub information: Matrix3<f64>,
    pub gradient: Vector3<f64>,
    /// Frame and mixed block with its pose.
    pub mixed: Vec<(usize, SMatrix<f64, 6, 3>)>,
}

/// The normal equations at one state.
#[derive(Debug, Clone)]
pub(super) struct Linear {
    /// Upper triangle and diagonal of `A`.
    pub information: DMatrix<f64>,
    pub gradient: DVector<f64>,
    pub points: Vec<PointBlock>,
}

impl Linear {
    /// `S`, symmetric, and the right side `a - W C^-1 c`, with the diagonals damped; `None` where a point's block is singular.
    pub(crate) fn reduced(&self, bundle: &Bundle, damping: f64) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let mut s = self.information.clone();
        for at in 0..s.nrows() {
            s[(at, at)] *= 1.0 + damping;
        }
        let mut right = self.gradient.clone();
        for point in &self.points {
            let inverse = damped(&point.information, damping).try_inverse()?;
            for (k, (frame, mixed)) in point.mixed.iter().enumerate() {
                let at = bundle.layout.position(*frame);
                let gain = mixed * inverse;
                let mut rows = right.fixed_rows_mut::<6>(at);
                rows -= gain * point.gradient;
                for (other, other_mixed) in &point.mixed[k..] {
                    let mut block = s.fixed_view_mut::<6, 6>(at, bundle.layout.position(*other));
                    block -= gain * other_mixed.transpose();
                }
            }
        }
        s.fill_lower_triangle_with_upper_triangle();
        Some((s, right))
    }
}

fn damped(information: &Matrix3<f64>, damping: f64) -> Matrix3<f64> {
    let mut out = *information;
    let floor = POINT_FLOOR * information.diagonal().max();
    for k in 0..3 {
        out[(k, k)] = (out[(k, k)] * (1.0 + damping)).max(out[(k, k)] + floor);
    }
    out
}

impl Bundle {
    /// The normal equations at the current state, robust weights frozen.
    pub(super) fn linearise(&self) -> Linear {
        let n = self.layout.len();
        let cameras = self.cameras(&self.state);
        let mut information = DMatrix::zeros(n, n);
        let mut gradient = DVector::zeros(n);
        let mut points = Vec::with_capacity(self.views.len());
        for (landmark, views) in self.state.landmarks.iter().zip(&self.views) {
            let mut point = PointBlock {
                information: Matrix3::zeros(),
                gradient: Vector3::zeros(),
                mixed: Vec::with_capacity(views.len()),
            };
            for (frame, measured) in views {
                let Some(rows) = cameras[*frame].rows(&self.origin, landmark, measured) else { continue };
                let variance = self.track_std * self.track_std;
                let weight = crate::init::robust::weight(rows.residual.norm_squared() / variance) / variance;
                let at = self.layout.position(*frame);
                let weighted_pose = weight * rows.d_pose.transpose();
                let mut block = information.fixed_view_mut::<6, 6>(at, at);
                block += weighted_pose * rows.d_pose;
                let mut part = gradient.fixed_rows_mut::<6>(at);
                part += weighted_pose * rows.residual;
                point.mixed.push((*frame, weighted_pose * rows.d_point));
                point.information += weight * rows.d_point.tr_mul(&rows.d_point);
                point.gradient += weight * rows.d_point.tr_mul(&rows.residual);
            }
            points.push(point);
        }
        for factor in &self.inertial {
            let Some(columns) = factor.columns(&self.layout) else { continue };
            let (residual, rows) = factor.rows(&self.state);
            let (square, slope) = (rows.tr_mul(&rows), rows.tr_mul(&residual));
            for (i, row) in columns.iter().enumerate() {
                gradient[*row] += slope[i];
                for (j, column) in columns.iter().enumerate() {
                    if row <= column {
                        information[(*row, *column)] += square[(i, j)];
                    }
                }
            }
        }
        let mut rows = Vec::new();
        for prior in &self.priors {
            prior.rows(&self.layout, &self.state, &mut rows);
        }
        for row in &rows {
            for (a, d_a) in &row.entries {
                gradient[*a] += d_a * row.residual;
                for (b, d_b) in row.entries.iter().filter(|(b, _)| a <= b) {
                    information[(*a, *b)] += d_a * d_b;
                }
            }
        }
        Linear { information, gradient, points }
    }

    /// The step that the normal equations ask for, of frames and of points; `None` where they are singular.
    fn step(&self, linear: &Linear, damping: f64) -> Option<(DVector<f64>, Vec<Vector3<f64>>)> {
        let (s, right) = linear.reduced(self, damping)?;
        let step = -s.cholesky()?.solve(&right);
        let mut points = Vec::with_capacity(linear.points.len());
        for point in &linear.points {
            let mut slope = point.gradient;
            for (frame, mixed) in &point.mixed {
                slope += mixed.tr_mul(&step.fixed_rows::<6>(self.layout.position(*frame)));
            }
            points.push(-(damped(&point.information, damping).try_inverse()? * slope));
        }
        Some((step, points))
    }

    /// Lowers the cost in at most `max_steps` steps.
    pub(crate) fn solve(&mut self, max_steps: usize) -> Solved {
        let mut cost = self.cost(&self.state);
        let mut damping = FIRST_DAMPING;
        let mut linear = self.linearise();
        let mut steps = 0;
        while steps < max_steps && damping < LAST_DAMPING {
            steps += 1;
            let tried = self.step(&linear, damping).map(|(frames, points)| {
                let state: BundleState = self.state.plus(&self.layout, &frames, &points);
                let cost = self.cost(&state);
                (state, cost)
            });
            match tried {
                Some((state, lower)) if lower.is_finite() && lower < cost && state.is_finite() => {
                    let gain = (cost - lower) / cost.max(f64::MIN_POSITIVE);
                    self.state = state;
                    cost = lower;
                    damping = (0.2 * damping).max(1e-9);
                    if gain < SMALL_GAIN {
                        break;
                    }
                    linear = self.linearise();
                }
                // The minimum is reached when even a step that is hardly damped lowers nothing.
                Some((_, higher)) if (higher - cost).abs() <= SMALL_GAIN * 1e-3 * cost => break,
                _ => damping *= 8.0,
            }
        }
        Solved { steps, cost }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::{Bundle, BundleState, Landmark, Layout, Prior};
    use crate::state::ImuBias;
    use dpn_core::geometry::so3::exp;
    use dpn_core::random::Stream;
    use nalgebra::{DMatrix, DVector, Isometry3, Vector3};
    use rand::Rng;

    /// Five cameras, forty points, exact views, the gauge held; then everything is moved a little.
    pub(in super::super) fn disturbed(seed: u64) -> (Bundle, BundleState) {
        let mut rng = Stream::new(seed).named("solve-test").rng();
        let mut vector = |size: f64| Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0) * size);
        let poses: Vec<Isometry3<f64>> =
            (0..5).map(|_| Isometry3::from_parts(vector(0.5).into(), exp(&vector(0.2)))).collect();
        let points: Vec<Vector3<f64>> = (0..40)
            .map(|_| {
                let d = vector(0.6);
                Vector3::new(d.x, d.y, 1.0) * (5.0 + 4.0 * d.z)
            })
            .collect();
        let truth = BundleState {
            velocities: vec![Vector3::zeros(); poses.len()],
            bias: ImuBias::zero(),
            landmarks: points
                .iter()
                .map(|p| Landmark { direction: p.normalize(), inverse_distance: 1.0 / p.norm() })
                .collect(),
            poses,
        };
        let views = points
            .iter()
            .map(|p| {
                (0..5)
                    .map(|f| (f, truth.poses[f].inverse_transform_point(&(*p).into()).coords.normalize()))
                    .collect()
            })
            .collect();
        let (a, b) = (truth.poses[0], truth.poses[4]);
        let priors = vec![
            Prior::Position { frame: 0, value: a.translation.vector, std: 1e-4 },
            Prior::Rotation { frame: 0, value: a.rotation, std: 1e-4 },
            Prior::Distance {
                from: 0,
                to: 4,
                value: (b.translation.vector - a.translation.vector).norm(),
                std: 1e-4,
            },
        ];
        let layout = Layout::visual(5);
        let push = DVector::from_fn(layout.len(), |_, _| rng.random_range(-0.03..0.03));
        let moves: Vec<_> = (0..40).map(|_| Vector3::from_fn(|_, _| rng.random_range(-0.02..0.02))).collect();
        let bundle = Bundle {
            layout,
            body_from_cam: Isometry3::identity(),
            origin: Vector3::zeros(),
            state: truth.plus(&layout, &push, &moves),
            views,
            track_std: 2e-3,
            inertial: Vec::new(),
            priors,
        };
        (bundle, truth)
    }

    #[test]
    fn exact_views_bring_every_frame_and_point_back() {
        for seed in 0..5 {
            let (mut bundle, truth) = disturbed(seed);
            let solved = bundle.solve(30);
            assert!(solved.cost < 1e-8, "seed {seed}: cost {} after {} steps", solved.cost, solved.steps);
            for (found, pose) in bundle.state.poses.iter().zip(&truth.poses) {
                assert!((found.translation.vector - pose.translation.vector).norm() < 1e-5);
            }
            for (found, point) in bundle.state.landmarks.iter().zip(&truth.landmarks) {
                assert!((found.inverse_distance - point.inverse_distance).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn the_reduced_system_is_the_schur_complement_of_the_dense_one() {
        let (bundle, _) = disturbed(9);
        let linear = bundle.linearise();
        let (n, m) = (bundle.layout.len(), 3 * bundle.views.len());
        let mut dense = DMatrix::zeros(n + m, n + m);
        let mut upper = linear.information.clone();
        upper.fill_lower_triangle_with_upper_triangle();
        dense.view_mut((0, 0), (n, n)).copy_from(&upper);
        let mut right = DVector::zeros(n + m);
        right.rows_mut(0, n).copy_from(&linear.gradient);
        for (k, point) in linear.points.iter().enumerate() {
            let at = n + 3 * k;
            dense.view_mut((at, at), (3, 3)).copy_from(&point.information);
            right.rows_mut(at, 3).copy_from(&point.gradient);
            for (frame, mixed) in &point.mixed {
                let row = bundle.layout.position(*frame);
                dense.view_mut((row, at), (6, 3)).copy_from(mixed);
                dense.view_mut((at, row), (3, 6)).copy_from(&mixed.transpose());
            }
        }
        let full = -dense.lu().solve(&right).unwrap();
        let (step, points) = bundle.step(&linear, 0.0).unwrap();
        assert!((full.rows(0, n) - &step).norm() < 1e-6 * step.norm().max(1.0));
        assert!((full.fixed_rows::<3>(n + 6) - points[2]).norm() < 1e-6);
    }
}
