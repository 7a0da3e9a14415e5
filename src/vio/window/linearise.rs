//! All measurements of the window as normal equations over its states, the depths taken out by Schur complement as they come.
//!
//! A depth meets only the frames that saw its landmark: with `w` the depth's row of the Hessian, `h` its diagonal and `g` its
//! gradient, what is left over the states is `H - w^T w / h` and `g_states - w^T g / h`.

use super::landmark::MIN_INVERSE_DEPTH;
use super::layout::Layout;
use super::normal::Normal;
use super::window::Window;
use crate::factors::inertial::{inertial_jacobians, sqrt_information};
use crate::factors::reprojection::PairGeometry;
use crate::factors::rest::{self, rest_jacobians};
use crate::state::{POSE_DIM, STATE_DIM};
use nalgebra::{SMatrix, SVector};

/// Which measurements enter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    /// All of them.
    All,
    /// Those that would be lost with the oldest frame.
    Oldest,
}

/// One landmark's depth, as it was taken out; enough to find its step afterwards.
#[derive(Debug, Clone, Copy)]
struct DepthRow {
    landmark: usize,
    inverse_h: f64,
    g: f64,
    /// Where its couplings begin in [`Linearisation::couplings`].
    start: usize,
}

/// The equations at one point, and memory for the next.
#[derive(Debug, Clone)]
pub(crate) struct Linearisation {
    pub(crate) normal: Normal,
    pub(crate) cost: f64,
    depths: Vec<DepthRow>,
    /// Place and six couplings for each frame a depth meets.
    couplings: Vec<(usize, [f64; POSE_DIM])>,
    geometry: Vec<Option<PairGeometry>>,
    first_geometry: Vec<Option<PairGeometry>>,
}

impl Default for Linearisation {
    fn default() -> Self {
        Self {
            normal: Normal::zeros(0),
            cost: 0.0,
            depths: Vec::new(),
            couplings: Vec::new(),
            geometry: Vec::new(),
            first_geometry: Vec::new(),
        }
    }
}

impl Linearisation {
    /// Sets up the equations of `window` about its present states; depths are damped by the factor `1 + damping`.
    pub(crate) fn compute(&mut self, window: &Window, layout: &Layout, part: Part, damping: f64) {
        self.normal.reset(layout.dim());
        self.depths.clear();
        self.couplings.clear();
        self.cost = 0.0;
        if let Some(prior) = &window.prior {
            self.cost += prior.add_to(window, layout, &mut self.normal);
        }
        let last = if part == Part::All { window.frames.len() } else { 2 };
        for j in 1..last {
            self.cost += add_inertial(window, layout, j, &mut self.normal);
            self.cost += add_rest(window, layout, j, &mut self.normal);
        }
        self.pairs(window);
        for index in 0..window.landmarks.len() {
            let landmark = &window.landmarks[index];
            let sightings = match part {
                Part::All => landmark.sightings.len(),
                Part::Oldest => window.handed_over(landmark),
            };
            self.add_landmark(window, layout, index, sightings, damping);
        }
    }

    fn pairs(&mut self, window: &Window) {
        let n = window.frames.len();
        self.geometry.clear();
        self.geometry.resize(n * n, None);
        self.first_geometry.clear();
        for target in 1..n {
            for host in 0..target {
                self.geometry[host * n + target] = Some(window.geometry(host, target));
            }
        }
        if window.config.first_estimates {
            self.first_geometry.resize(n * n, None);
            for target in 1..n {
                for host in 0..target {
                    self.first_geometry[host * n + target] = Some(window.first_geometry(host, target));
                }
            }
        }
    }

    fn add_landmark(
        &mut self,
        window: &Window,
        layout: &Layout,
        index: usize,
        sightings: usize,
        damping: f64,
    ) {
        let landmark = &window.landmarks[index];
        let Some(inverse_depth) = landmark.inverse_depth.filter(|_| sightings > 1) else {
            return;
        };
        let n = window.frames.len();
        let host = landmark.host();
        let host_place = layout.pose(host);
        let host_sighting = landmark.host_sighting();
        let ray = window.ray_at_offset(host_sighting);
        let (mut h, mut g) = (0.0, 0.0);
        let start = self.couplings.len();
        self.couplings.push((host_place, [0.0; POSE_DIM]));
        let camera_coupling = layout.camera().map(|place| {
            self.couplings.push((place, [0.0; POSE_DIM]));
            self.couplings.len() - 1
        });
        let mut offset_coupling = 0.0;
        for (target, sighting) in &landmark.sightings[1..sightings] {
            let target_place = layout.pose(*target);
            let sighting = window.sighting_at_offset(sighting);
            let Some(geometry) = &self.geometry[host * n + target] else { continue };
            let mut at = match self.first_geometry.get(host * n + target) {
                Some(Some(first)) => {
                    let mut at = first.linearise(&ray, &sighting, inverse_depth);
                    at.residual = geometry.residual(&ray, &sighting, inverse_depth);
                    at
                }
                _ => geometry.linearise(&ray, &sighting, inverse_depth),
            };
            let squared = at.residual.norm_squared();
            let (rho, weight) = window.config.loss.evaluate(squared, window.config.loss_scale);
            self.cost += 0.5 * rho;
            let camera = layout.camera().map(|_| geometry.d_camera(&at, &ray, inverse_depth));
            let offset = layout.offset().map(|_| geometry.d_offset(&at, host_sighting, &sighting));
            let root = weight.sqrt();
            at.residual *= root;
            for r in 0..2 {
                for k in 0..POSE_DIM {
                    at.host[r][k] *= root;
                    at.target[r][k] *= root;
                }
                at.depth[r] *= root;
            }
            let residual = [at.residual.x, at.residual.y];
            let normal = &mut self.normal;
            normal.add_square(host_place, &at.host);
            normal.add_square(target_place, &at.target);
            normal.add_product(target_place, &at.target, host_place, &at.host);
            add_gradient(normal, host_place, &at.host, &residual);
            add_gradient(normal, target_place, &at.target, &residual);
            h += at.depth[0] * at.depth[0] + at.depth[1] * at.depth[1];
            g += at.depth[0] * residual[0] + at.depth[1] * residual[1];
            couple(&mut self.couplings[start].1, &at.host, &at.depth);
            let mut coupling = [0.0; POSE_DIM];
            couple(&mut coupling, &at.target, &at.depth);
            self.couplings.push((target_place, coupling));
            if let (Some(mut rows), Some(place), Some(entry)) = (camera, layout.camera(), camera_coupling) {
                scale(&mut rows, root);
                normal.add_square(place, &rows);
                normal.add_product(place, &rows, host_place, &at.host);
                normal.add_product(place, &rows, target_place, &at.target);
                add_gradient(normal, place, &rows, &residual);
                couple(&mut self.couplings[entry].1, &rows, &at.depth);
            }
            if let (Some(column), Some(place)) = (offset, layout.offset()) {
                let column = [[column[0] * root], [column[1] * root]];
                normal.add_square(place, &column);
                normal.add_product(place, &column, host_place, &at.host);
                normal.add_product(place, &column, target_place, &at.target);
                if let (Some(rows), Some(camera_place)) = (camera, layout.camera()) {
                    let mut rows = rows;
                    scale(&mut rows, root);
                    normal.add_product(place, &column, camera_place, &rows);
                }
                add_gradient(normal, place, &column, &residual);
                offset_coupling += column[0][0] * at.depth[0] + column[1][0] * at.depth[1];
            }
        }
        let at_bound = inverse_depth <= MIN_INVERSE_DEPTH;
        let row = DepthRow { landmark: index, inverse_h: h, g, start };
        self.take_out(layout, row, damping, offset_coupling, at_bound);
    }

    /// The Schur complement of one depth; `row.inverse_h` comes in as `h`.
    fn take_out(
        &mut self,
        layout: &Layout,
        mut row: DepthRow,
        damping: f64,
        offset_coupling: f64,
        at_bound: bool,
    ) {
        let h = row.inverse_h * (1.0 + damping);
        // A depth at its bound that would go on beyond it stands still: no unknown. One that nothing was said of has no couplings
        // worth the name either.
        if h < 1e-9 || (at_bound && row.g >= 0.0) {
            self.couplings.truncate(row.start);
            return;
        }
        row.inverse_h = 1.0 / h;
        if let Some(place) = layout.offset() {
            let mut coupling = [0.0; POSE_DIM];
            coupling[0] = offset_coupling;
            self.couplings.push((place, coupling));
        }
        let offset = layout.offset();
        let couplings = &self.couplings[row.start..];
        for (k, (place, w)) in couplings.iter().enumerate() {
            let size = if Some(*place) == offset { 1 } else { POSE_DIM };
            for i in 0..size {
                let factor = w[i] * row.inverse_h;
                self.normal.gradient_mut()[place + i] -= factor * row.g;
                for (other_place, other) in &couplings[..=k] {
                    let other_size = if Some(*other_place) == offset { 1 } else { POSE_DIM };
                    subtract(
                        &mut self.normal,
                        place + i,
                        *other_place,
                        other,
                        other_size,
                        factor,
                        i,
                        place == other_place,
                    );
                }
            }
        }
        self.depths.push(row);
    }

    /// Each landmark's step after the states' step `d`.
    pub(crate) fn depth_steps<'a>(
        &'a self,
        layout: &Layout,
        d: &'a [f64],
    ) -> impl Iterator<Item = (usize, f64)> + 'a {
        let offset = layout.offset();
        self.depths.iter().enumerate().map(move |(k, row)| {
            let end = self.depths.get(k + 1).map_or(self.couplings.len(), |next| next.start);
            let mut sum = row.g;
            for (place, w) in &self.couplings[row.start..end] {
                let size = if Some(*place) == offset { 1 } else { POSE_DIM };
                for i in 0..size {
                    sum += w[i] * d[place + i];
                }
            }
            (row.landmark, -sum * row.inverse_h)
        })
    }
}

#[allow(clippy::too_many_arguments)]
#[inline]
fn subtract(
    normal: &mut Normal,
    row: usize,
    place: usize,
    other: &[f64; POSE_DIM],
    size: usize,
    factor: f64,
    i: usize,
    diagonal: bool,
) {
    if diagonal {
        for (h, o) in normal.row_mut(row)[place..=place + i].iter_mut().zip(other) {
            *h -= factor * o;
        }
    } else if row > place {
        for (h, o) in normal.row_mut(row)[place..place + size].iter_mut().zip(other) {
            *h -= factor * o;
        }
    } else {
        for (k, o) in other[..size].iter().enumerate() {
            normal.add(row, place + k, -factor * o);
        }
    }
}

#[inline]
fn scale<const A: usize>(rows: &mut [[f64; A]; 2], factor: f64) {
    for row in rows {
        for v in row {
            *v *= factor;
        }
    }
}

#[inline]
fn couple<const A: usize>(to: &mut [f64; A], rows: &[[f64; A]; 2], depth: &[f64; 2]) {
    for k in 0..A {
        to[k] += rows[0][k] * depth[0] + rows[1][k] * depth[1];
    }
}

#[inline]
fn add_gradient<const A: usize>(
    normal: &mut Normal,
    place: usize,
    rows: &[[f64; A]; 2],
    residual: &[f64; 2],
) {
    for (k, g) in normal.gradient_mut()[place..place + A].iter_mut().enumerate() {
        *g += rows[0][k] * residual[0] + rows[1][k] * residual[1];
    }
}

/// Adds the inertial measurement that ends at frame `j` and returns its cost; none where the interval has no usable covariance.
fn add_inertial(window: &Window, layout: &Layout, j: usize, normal: &mut Normal) -> f64 {
    let i = j - 1;
    let Some(preint) = &window.frames[j].preint else { return 0.0 };
    let Some(root) = sqrt_information(preint) else { return 0.0 };
    let (state_i, state_j) = (&window.frames[i].state, &window.frames[j].state);
    let (mut residual, mut d_i, mut d_j) = inertial_jacobians(preint, state_i, state_j);
    if window.config.first_estimates && (window.frames[i].first.is_some() || window.frames[j].first.is_some())
    {
        let at = (window.first_or_now(i), window.first_or_now(j));
        let now = residual;
        (residual, d_i, d_j) = inertial_jacobians(preint, at.0, at.1);
        residual.copy_from(&now);
    }
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
    let gradient = |at: usize,
                    d: &SMatrix<f64, STATE_DIM, STATE_DIM>,
                    from: usize,
                    count: usize,
                    normal: &mut Normal| {
        let g = d.tr_mul(&residual);
        for k in 0..count {
            normal.gradient_mut()[at + k] += g[from + k];
        }
    };
    gradient(at_pose_i, &d_i, 0, POSE_DIM, normal);
    gradient(at_motion_i, &d_i, POSE_DIM, STATE_DIM - POSE_DIM, normal);
    gradient(at_pose_j, &d_j, 0, POSE_DIM, normal);
    gradient(at_motion_j, &d_j, POSE_DIM, STATE_DIM - POSE_DIM, normal);
    0.5 * residual.norm_squared()
}

/// Adds what rest between frame `j` and the one before says, and returns its cost.
fn add_rest(window: &Window, layout: &Layout, j: usize, normal: &mut Normal) -> f64 {
    if !window.frames[j].at_rest {
        return 0.0;
    }
    let (residual, d_i, d_j) = rest_jacobians(&window.frames[j - 1].state, &window.frames[j].state);
    let places: [usize; 18] = std::array::from_fn(|k| layout.state(j - 1 + k / 9, k % 9));
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
