//! All measurements of the window as normal equations over its states, each landmark taken out by Schur complement as it comes.
//!
//! A landmark has three unknowns: its inverse depth, and by how many deviations the host's own pixel is off in u and v, which the host's
//! measurement holds to `0 +- 1`. They meet only the frames that saw it: with `W` their rows of the Hessian, `A` their own block and
//! `g` their gradient, what is left over the states is `H - W^T A^-1 W` and `g_states - W^T A^-1 g`. With `A = L L^T` these are rank-one
//! updates by the rows of `L^-1 W`. The host's pixel is taken out at every linearisation anew, about zero: the cost is the residuals'
//! under a covariance that holds the host's error common to them, `r^T C^-1 r / 2`, and nothing of it need be kept.

// Small fixed loops over rows and columns: with indices they read as the formulas do.
#![allow(clippy::needless_range_loop)]

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

/// Unknowns of a landmark: inverse depth, the host's pixel in u and v. The depth stands last, so that its step is read off first.
const LOCAL: usize = 3;
/// Where the depth stands.
const DEPTH: usize = 2;

/// One landmark as it was taken out; enough to find its depth's step afterwards.
#[derive(Debug, Clone, Copy)]
struct DepthRow {
    landmark: usize,
    /// `L^-1 g` of the depth, and its pivot.
    g: f64,
    pivot: f64,
    /// Where its couplings begin in [`Linearisation::couplings`].
    start: usize,
}

/// What a landmark's three unknowns have in common with one block of the states.
type Coupling = [[f64; POSE_DIM]; LOCAL];

/// The equations at one point, and memory for the next.
#[derive(Debug, Clone)]
pub(crate) struct Linearisation {
    pub(crate) normal: Normal,
    pub(crate) cost: f64,
    depths: Vec<DepthRow>,
    /// Place and couplings for each block of states that a landmark meets; after its turn, those of `L^-1 W`.
    couplings: Vec<(usize, Coupling)>,
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
        // The host's measurement holds its pixel to zero, by one deviation.
        let mut own = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]];
        let mut g = [0.0; LOCAL];
        let start = self.couplings.len();
        self.couplings.push((host_place, Coupling::default()));
        let camera_coupling = layout.camera().map(|place| {
            self.couplings.push((place, Coupling::default()));
            self.couplings.len() - 1
        });
        let mut offset_coupling = Coupling::default();
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
            let pixel = geometry.d_host_pixel(&at, &host_sighting.spread);
            let camera = layout.camera().map(|_| geometry.d_camera(&at, &ray, inverse_depth));
            let offset = layout.offset().map(|_| geometry.d_offset(&at, host_sighting, &sighting));
            let root = weight.sqrt();
            at.residual *= root;
            scale(&mut at.host, root);
            scale(&mut at.target, root);
            let mut local = [[0.0; LOCAL]; 2];
            for r in 0..2 {
                local[r] = [pixel[r][0] * root, pixel[r][1] * root, at.depth[r] * root];
            }
            let residual = [at.residual.x, at.residual.y];
            let normal = &mut self.normal;
            normal.add_square(host_place, &at.host);
            normal.add_square(target_place, &at.target);
            normal.add_product(target_place, &at.target, host_place, &at.host);
            add_gradient(normal, host_place, &at.host, &residual);
            add_gradient(normal, target_place, &at.target, &residual);
            for r in 0..2 {
                for i in 0..LOCAL {
                    g[i] += local[r][i] * residual[r];
                    for k in 0..=i {
                        own[i][k] += local[r][i] * local[r][k];
                    }
                }
            }
            couple(&mut self.couplings[start].1, &at.host, &local);
            let mut coupling = Coupling::default();
            couple(&mut coupling, &at.target, &local);
            self.couplings.push((target_place, coupling));
            if let (Some(mut rows), Some(place), Some(entry)) = (camera, layout.camera(), camera_coupling) {
                scale(&mut rows, root);
                normal.add_square(place, &rows);
                normal.add_product(place, &rows, host_place, &at.host);
                normal.add_product(place, &rows, target_place, &at.target);
                add_gradient(normal, place, &rows, &residual);
                couple(&mut self.couplings[entry].1, &rows, &local);
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
                for i in 0..LOCAL {
                    offset_coupling[i][0] += column[0][0] * local[0][i] + column[1][0] * local[1][i];
                }
            }
        }
        if let Some(place) = layout.offset() {
            self.couplings.push((place, offset_coupling));
        }
        own[DEPTH][DEPTH] *= 1.0 + damping;
        let at_bound = inverse_depth <= MIN_INVERSE_DEPTH;
        self.take_out(layout, index, start, &own, &g, at_bound);
    }

    /// The Schur complement of one landmark, whose block is `own` (lower triangle) and whose gradient is `g`.
    fn take_out(
        &mut self,
        layout: &Layout,
        landmark: usize,
        start: usize,
        own: &[[f64; LOCAL]; LOCAL],
        g: &[f64; LOCAL],
        at_bound: bool,
    ) {
        let offset = layout.offset();
        let mut l = [[0.0; LOCAL]; LOCAL];
        let mut whitened = [0.0; LOCAL];
        let mut unknowns = LOCAL;
        for i in 0..LOCAL {
            for k in 0..=i {
                let sum: f64 = (0..k).map(|m| l[i][m] * l[k][m]).sum();
                let value = own[i][k] - sum;
                l[i][k] = if i == k { value.max(0.0).sqrt() } else { value / l[k][k] };
            }
            let sum: f64 = (0..i).map(|m| l[i][m] * whitened[m]).sum();
            let rest = g[i] - sum;
            // A depth that nothing was said of is no unknown; nor is one at its bound that would go on beyond it.
            if i == DEPTH && (l[i][i] < 3e-5 || (at_bound && rest >= 0.0)) {
                unknowns = DEPTH;
                break;
            }
            whitened[i] = rest / l[i][i];
        }
        // What the host's pixel explains is no cost.
        self.cost -= 0.5 * (whitened[0] * whitened[0] + whitened[1] * whitened[1]);
        for (_, w) in &mut self.couplings[start..] {
            for i in 0..unknowns {
                for k in 0..POSE_DIM {
                    let sum: f64 = (0..i).map(|m| l[i][m] * w[m][k]).sum();
                    w[i][k] = (w[i][k] - sum) / l[i][i];
                }
            }
        }
        let couplings = &self.couplings[start..];
        for (k, (place, w)) in couplings.iter().enumerate() {
            let size = if Some(*place) == offset { 1 } else { POSE_DIM };
            for i in 0..size {
                let mut factors = [0.0; LOCAL];
                for m in 0..unknowns {
                    factors[m] = w[m][i];
                    self.normal.gradient_mut()[place + i] -= w[m][i] * whitened[m];
                }
                for (other_place, other) in &couplings[..=k] {
                    let other_size = if Some(*other_place) == offset { 1 } else { POSE_DIM };
                    let of = Subtrahend { place: *other_place, rows: other, size: other_size };
                    subtract(&mut self.normal, place + i, &factors, &of, (place == other_place).then_some(i));
                }
            }
        }
        if unknowns == LOCAL {
            self.depths.push(DepthRow { landmark, g: whitened[DEPTH], pivot: l[DEPTH][DEPTH], start });
        } else {
            self.couplings.truncate(start);
        }
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
                    sum += w[DEPTH][i] * d[place + i];
                }
            }
            (row.landmark, -sum / row.pivot)
        })
    }
}

/// One block of columns to take away from.
struct Subtrahend<'a> {
    place: usize,
    rows: &'a Coupling,
    size: usize,
}

/// Takes `factors^T rows` off row `row`; on the diagonal, up to column `diagonal` of the block.
#[inline]
fn subtract(
    normal: &mut Normal,
    row: usize,
    factors: &[f64; LOCAL],
    of: &Subtrahend<'_>,
    diagonal: Option<usize>,
) {
    let mut values = [0.0; POSE_DIM];
    for (factor, w) in factors.iter().zip(of.rows) {
        for (value, w) in values.iter_mut().zip(w) {
            *value += factor * w;
        }
    }
    let size = diagonal.map_or(of.size, |i| i + 1);
    if diagonal.is_some() || row > of.place {
        for (h, value) in normal.row_mut(row)[of.place..of.place + size].iter_mut().zip(&values) {
            *h -= value;
        }
    } else {
        for (k, value) in values[..size].iter().enumerate() {
            normal.add(row, of.place + k, -value);
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
fn couple(to: &mut Coupling, rows: &[[f64; POSE_DIM]; 2], local: &[[f64; LOCAL]; 2]) {
    for (i, to) in to.iter_mut().enumerate() {
        for k in 0..POSE_DIM {
            to[k] += rows[0][k] * local[0][i] + rows[1][k] * local[1][i];
        }
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
