//! All measurements of the window as normal equations over its states. Landmarks are taken out as they come: see [`super::schur`].

// Small fixed loops over rows and columns: with indices they read as the formulas do.
#![allow(clippy::needless_range_loop)]

use super::layout::Layout;
use super::linearisation::Linearisation;
use super::normal::Normal;
use super::part::Part;
use super::schur::Landmarks;
use super::window::Window;
use crate::factors::inertial::{inertial_jacobians, sqrt_information};
use crate::factors::rest::{self, rest_jacobians};
use crate::state::{POSE_DIM, STATE_DIM};
use nalgebra::{SMatrix, SVector};
use pulp::Arch;

impl Linearisation {
    /// Sets up the equations of `window` about its present states; depths are damped by the factor `1 + damping`.
    pub(crate) fn compute(&mut self, window: &Window, layout: &Layout, part: Part, damping: f64) {
        self.normal.reset(layout.dim());
        self.depths.clear();
        self.cost = 0.0;
        if let Some(prior) = &window.prior {
            self.cost += prior.add_to(window.estimates(), layout, &mut self.normal);
        }
        let (last, hosts) = match part {
            Part::All => (window.frames.len(), window.frames.len()),
            Part::Oldest(leaving) => (leaving + 1, leaving),
        };
        for j in 1..last {
            self.cost += add_inertial(window, layout, j, &mut self.normal);
            self.cost += add_rest(window, layout, j, &mut self.normal);
        }
        self.pairs.of(window.estimates(), hosts);
        let Self { normal, depths, pairs, .. } = self;
        self.cost += Arch::new().dispatch(Landmarks { window, layout, part, damping, pairs, normal, depths });
    }
}

/// Adds the inertial measurement that ends at frame `j` and returns its cost; none where the interval has no usable covariance.
fn add_inertial(window: &Window, layout: &Layout, j: usize, normal: &mut Normal) -> f64 {
    let i = j - 1;
    let Some(preint) = &window.frames[j].preint else { return 0.0 };
    let Some(root) = sqrt_information(preint) else { return 0.0 };
    let (state_i, state_j) = (&window.frames[i].state, &window.frames[j].state);
    let (residual, d_i, d_j) = inertial_jacobians(preint, state_i, state_j);
    let residual: SVector<f64, STATE_DIM> = root * residual;
    let (d_i, d_j) = (root * d_i, root * d_j);
    let split = |d: &SMatrix<f64, STATE_DIM, STATE_DIM>| {
        let mut pose = [[0.0; POSE_DIM]; STATE_DIM];
        let mut motion = [[0.0; STATE_DIM - POSE_DIM]; STATE_DIM];
        for r in 0..STATE_DIM {
            for c in 0..POSE_DIM {
                pose[r][c] = d[(r, c)];
            }
            for c in POSE_DIM..STATE_DIM {
                motion[r][c - POSE_DIM] = d[(r, c)];
            }
        }
        (pose, motion)
    };
    let ((pose_i, motion_i), (pose_j, motion_j)) = (split(&d_i), split(&d_j));
    let (at_pose_i, at_motion_i) = (layout.pose(i), layout.motion(i));
    let (at_pose_j, at_motion_j) = (layout.pose(j), layout.motion(j));
    normal.add_square(at_pose_i, &pose_i);
    normal.add_square(at_pose_j, &pose_j);
    normal.add_square(at_motion_i, &motion_i);
    normal.add_square(at_motion_j, &motion_j);
    normal.add_product(at_pose_j, &pose_j, at_pose_i, &pose_i);
    normal.add_product(at_motion_j, &motion_j, at_motion_i, &motion_i);
    normal.add_product(at_pose_i, &pose_i, at_motion_i, &motion_i);
    normal.add_product(at_pose_i, &pose_i, at_motion_j, &motion_j);
    normal.add_product(at_pose_j, &pose_j, at_motion_i, &motion_i);
    normal.add_product(at_pose_j, &pose_j, at_motion_j, &motion_j);
    for (frame, d) in [(i, &d_i), (j, &d_j)] {
        let g = d.tr_mul(&residual);
        for k in 0..STATE_DIM {
            normal.gradient_mut()[layout.state(frame, k)] += g[k];
        }
    }
    0.5 * residual.norm_squared()
}

/// Adds what rest says of frame `j` against the rest's first frame in the window, and returns its cost.
fn add_rest(window: &Window, layout: &Layout, j: usize, normal: &mut Normal) -> f64 {
    let Some(rest) = window.frames[j].rest else { return 0.0 };
    let Some(i) = window.frames[..j].iter().position(|frame| frame.t >= rest.from) else { return 0.0 };
    let (mut residual, mut d_i, d_j) =
        rest_jacobians(&window.frames[i].state, &window.frames[j].state, rest.angle);
    if i + 1 < j {
        // That the first does not move is said once.
        residual.fixed_rows_mut::<3>(rest::FIRST_VELOCITY).fill(0.0);
        d_i.fixed_rows_mut::<3>(rest::FIRST_VELOCITY).fill(0.0);
    }
    let places: [usize; 18] = std::array::from_fn(|k| layout.state(if k < 9 { i } else { j }, k % 9));
    let mut all = SMatrix::<f64, { rest::ROWS }, 18>::zeros();
    all.fixed_columns_mut::<9>(0).copy_from(&d_i);
    all.fixed_columns_mut::<9>(9).copy_from(&d_j);
    let (h, g) = (all.tr_mul(&all), all.tr_mul(&residual));
    for r in 0..18 {
        normal.gradient_mut()[places[r]] += g[r];
        for c in 0..=r {
            normal.add(places[r], places[c], h[(r, c)]);
        }
    }
    0.5 * residual.norm_squared()
}
