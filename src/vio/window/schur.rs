//! Landmarks as normal equations over the states, each taken out by Schur complement as it comes.
//!
//! A landmark has three unknowns: its inverse depth, and by how many deviations the host's own pixel is off in u and v, which the host's
//! measurement holds to `0 +- 1`. They meet only the frames that saw it: with `W` their rows of the Hessian, `A` their own block and
//! `g` their gradient, what is left over the states is `H - W^T A^-1 W` and `g_states - W^T A^-1 g`. With `A = L L^T` these are rank-one
//! updates by the rows of `L^-1 W`. The host's pixel is taken out at every linearisation anew, about zero: the cost is the residuals'
//! under a covariance that holds the host's error common to them, `r^T C^-1 r / 2`, and nothing of it need be kept.
//!
//! `W` is kept as three dense rows over one run of states, from the first that the landmark meets to the last, whole vectors long. A
//! frame of the run that did not see it costs a few zeros; in return, all of this is loops over neighbours in memory.

// Small fixed loops over rows and columns: with indices they read as the formulas do.
#![allow(clippy::needless_range_loop)]

use super::landmark::{Landmark, MIN_INVERSE_DEPTH};
use super::landmark_terms::{DepthRow, Depths, Pairs};
use super::layout::Layout;
use super::normal::Normal;
use super::part::Part;
use super::row_sums::{LANES, add_weighted, add_weighted_to_each, scale};
use super::window::Window;
use crate::state::POSE_DIM;
use pulp::{Simd, WithSimd};

/// Unknowns of a landmark: inverse depth, the host's pixel in u and v. The depth stands last, so that its step is read off first.
const LOCAL: usize = 3;
/// Where the depth stands.
const DEPTH: usize = 2;
/// Rows of the equations that are worked on together, so that what is added to them is read once. A divisor of [`LANES`]: rows of a
/// block end in the same vector.
const ROWS: usize = 4;

/// Two rows of a Jacobian by one block of states, filled up with zeros.
type Rows = [[f64; LANES]; 2];

/// Adds the landmarks of a window to its equations.
pub(super) struct Landmarks<'a> {
    pub(super) window: &'a Window,
    pub(super) layout: &'a Layout,
    pub(super) part: Part,
    /// Depths are damped by the factor `1 + damping`.
    pub(super) damping: f64,
    pub(super) pairs: &'a Pairs,
    pub(super) normal: &'a mut Normal,
    pub(super) depths: &'a mut Depths,
}

impl WithSimd for Landmarks<'_> {
    /// Their cost.
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> f64 {
        let mut cost = 0.0;
        for (index, landmark) in self.window.landmarks.iter().enumerate() {
            let sightings = match self.part {
                Part::All => landmark.sightings.len(),
                Part::Oldest(leaving) => landmark.handed_over(leaving),
            };
            if let Some(inverse_depth) = landmark.inverse_depth.filter(|_| sightings > 1) {
                cost += self.add(simd, index, landmark, sightings, inverse_depth);
            }
        }
        cost
    }
}

/// The part of sighting `k` of a landmark's information that is counted here.
#[inline(always)]
fn counted(window: &Window, part: Part, landmark: &Landmark, k: usize) -> f64 {
    match part {
        Part::All => landmark.sightings[k].1.left,
        Part::Oldest(leaving) => window.handed_part(landmark, k, leaving),
    }
}

impl Landmarks<'_> {
    /// Adds one landmark with its first sightings and returns its cost.
    #[inline(always)]
    fn add<S: Simd>(
        &mut self,
        simd: S,
        index: usize,
        landmark: &Landmark,
        sightings: usize,
        inverse_depth: f64,
    ) -> f64 {
        let Self { window, layout, part: of, damping, pairs, normal, depths } = self;
        let host = landmark.host();
        let host_place = layout.pose(host);
        let host_sighting = landmark.host_sighting();
        let host_seen = window.sighting_at_offset(host_sighting);
        // Camera, clock and poses stand in this order without a gap.
        let at = layout.camera().or(layout.offset()).unwrap_or(host_place);
        let width = layout.pose(landmark.sightings[sightings - 1].0) + POSE_DIM - at;
        let stride = (width + LANES).next_multiple_of(LANES);
        let start = depths.w.len();
        depths.w.resize(start + LOCAL * stride, 0.0);
        let w = &mut depths.w[start..];

        let mut cost = 0.0;
        // First all that has roots and divisions, which take long but do not wait for each other.
        depths.projected.clear();
        for (k, (target, sighting)) in landmark.sightings[..sightings].iter().enumerate().skip(1) {
            let Some(geometry) = &pairs.geometry[host * pairs.frames + target] else { continue };
            let part = counted(window, *of, landmark, k);
            let projected = geometry.project(&host_seen, &window.sighting_at_offset(sighting), inverse_depth);
            let (rho, weight) = window.loss(projected.residual.norm_squared());
            cost += 0.5 * part * rho;
            depths.projected.push((k, projected, (part * weight).sqrt()));
        }
        let mut own = Own::holding(counted(window, *of, landmark, 0));
        for (k, projected, root) in &depths.projected {
            let ((target, sighting), root) = (&landmark.sightings[*k], *root);
            let sighting = window.sighting_at_offset(sighting);
            let geometry =
                pairs.geometry[host * pairs.frames + target].as_ref().expect("it was projected by it");
            let mut seen = geometry.derive(projected, &host_seen, &sighting, inverse_depth);
            seen.residual *= root;
            let pixel = seen.d_host_pixel(&host_sighting.spread);
            let place = layout.pose(*target);
            let rows = SightingRows {
                residual: [seen.residual.x, seen.residual.y],
                by_local: [0, 1].map(|r| [pixel[r][0] * root, pixel[r][1] * root, seen.depth[r] * root]),
                host_place,
                by_host: filled(&seen.host, root),
                place,
                by_target: filled(&seen.target, root),
            };
            own.add(simd, &rows);
            rows.add(simd, normal);
            for m in 0..LOCAL {
                let factors = [rows.by_local[0][m], rows.by_local[1][m]];
                add_weighted(simd, block(&mut w[m * stride..], place - at), factors, both(&rows.by_target));
            }
            let clock = layout.offset().map(|place| {
                let clock = geometry.d_offset(&seen, host_sighting, &sighting).map(|v| [v * root]);
                rows.add_shared(normal, &mut w[place - at..], stride, place, &clock);
                (place, clock)
            });
            if let Some(place) = layout.camera() {
                let camera =
                    geometry.d_camera(&seen, &host_seen.ray, inverse_depth).map(|row| row.map(|v| v * root));
                rows.add_shared(normal, &mut w[place - at..], stride, place, &camera);
                if let Some((clock_place, clock)) = &clock {
                    normal.add_product(*clock_place, clock, place, &camera);
                }
            }
        }
        own.add_host(simd, normal, host_place, &mut w[host_place - at..], stride);
        own.block[DEPTH][DEPTH] *= 1.0 + *damping;
        let own = own.factor(inverse_depth <= MIN_INVERSE_DEPTH);
        own.take_out(simd, normal, w, stride, at, width);
        if own.unknowns == LOCAL {
            let start = start + DEPTH * stride;
            let (g, pivot) = (own.g[DEPTH], own.l[DEPTH][DEPTH]);
            depths.rows.push(DepthRow { landmark: index, g, pivot, start, at, width });
        } else {
            depths.w.truncate(start);
        }
        // What the host's pixel explains is no cost.
        cost - 0.5 * (own.g[0] * own.g[0] + own.g[1] * own.g[1])
    }
}

/// One sighting: residual and derivatives, weighted.
struct SightingRows {
    residual: [f64; 2],
    by_local: [[f64; LOCAL]; 2],
    host_place: usize,
    by_host: Rows,
    place: usize,
    by_target: Rows,
}

impl SightingRows {
    /// Adds all that it says of the two poses but the host's own block, which [`Own`] gathers.
    #[inline(always)]
    fn add<S: Simd>(&self, simd: S, normal: &mut Normal) {
        let (host, target) = (both(&self.by_host), both(&self.by_target));
        for i in 0..POSE_DIM {
            let factors = [self.by_target[0][i], self.by_target[1][i]];
            let row = normal.whole_row_mut(self.place + i);
            add_weighted(simd, block(row, self.host_place), factors, host);
            add_weighted(simd, block(row, self.place), factors, target);
        }
        add_weighted(simd, block(normal.whole_gradient_mut(), self.place), self.residual, target);
    }

    /// Adds its derivatives `rows` by what all sightings share, at place `at`: the camera's place or its clock. `w` begins there.
    fn add_shared<const N: usize>(
        &self,
        normal: &mut Normal,
        w: &mut [f64],
        stride: usize,
        at: usize,
        rows: &[[f64; N]; 2],
    ) {
        normal.add_square(at, rows);
        for (pose, by_pose) in [(self.host_place, &self.by_host), (self.place, &self.by_target)] {
            let by_pose: [[f64; POSE_DIM]; 2] =
                std::array::from_fn(|r| std::array::from_fn(|k| by_pose[r][k]));
            normal.add_product(at, rows, pose, &by_pose);
        }
        for k in 0..N {
            normal.gradient_mut()[at + k] += rows[0][k] * self.residual[0] + rows[1][k] * self.residual[1];
            for m in 0..LOCAL {
                w[m * stride + k] += rows[0][k] * self.by_local[0][m] + rows[1][k] * self.by_local[1][m];
            }
        }
    }
}

/// What a landmark's sightings add up to in its own unknowns and in its host.
struct Own {
    /// Lower triangle.
    block: [[f64; LOCAL]; LOCAL],
    g: [f64; LOCAL],
    host_square: [[f64; LANES]; POSE_DIM],
    host_gradient: [f64; LANES],
    host_coupling: [[f64; LANES]; LOCAL],
}

impl Own {
    /// A part of the host's measurement alone: the whole holds its pixel to zero, by one deviation.
    #[inline(always)]
    fn holding(part: f64) -> Self {
        Self {
            block: [[part, 0.0, 0.0], [0.0, part, 0.0], [0.0, 0.0, 0.0]],
            g: [0.0; LOCAL],
            host_square: [[0.0; LANES]; POSE_DIM],
            host_gradient: [0.0; LANES],
            host_coupling: [[0.0; LANES]; LOCAL],
        }
    }
}

impl Own {
    #[inline(always)]
    fn add<S: Simd>(&mut self, simd: S, rows: &SightingRows) {
        let local = &rows.by_local;
        for r in 0..2 {
            for i in 0..LOCAL {
                self.g[i] += local[r][i] * rows.residual[r];
                for k in 0..=i {
                    self.block[i][k] += local[r][i] * local[r][k];
                }
            }
        }
        let host = both(&rows.by_host);
        for i in 0..POSE_DIM {
            add_weighted(simd, &mut self.host_square[i], [rows.by_host[0][i], rows.by_host[1][i]], host);
        }
        add_weighted(simd, &mut self.host_gradient, rows.residual, host);
        for m in 0..LOCAL {
            add_weighted(simd, &mut self.host_coupling[m], [local[0][m], local[1][m]], host);
        }
    }

    /// Adds the host's part to the equations and to `W`, which begins at the host's columns.
    #[inline(always)]
    fn add_host<S: Simd>(&self, simd: S, normal: &mut Normal, place: usize, w: &mut [f64], stride: usize) {
        for i in 0..POSE_DIM {
            let row = normal.whole_row_mut(place + i);
            add_weighted(simd, block(row, place), [1.0], [&self.host_square[i]]);
        }
        add_weighted(simd, block(normal.whole_gradient_mut(), place), [1.0], [&self.host_gradient]);
        for m in 0..LOCAL {
            add_weighted(simd, block(&mut w[m * stride..], 0), [1.0], [&self.host_coupling[m]]);
        }
    }

    /// Factors its block; `at_bound`: the depth may not become smaller.
    #[inline(always)]
    fn factor(&self, at_bound: bool) -> OwnFactor {
        let (own, g) = (&self.block, &self.g);
        let mut factor = OwnFactor { l: [[0.0; LOCAL]; LOCAL], g: [0.0; LOCAL], unknowns: LOCAL };
        for i in 0..LOCAL {
            for k in 0..=i {
                let mut value = own[i][k];
                for m in 0..k {
                    value -= factor.l[i][m] * factor.l[k][m];
                }
                factor.l[i][k] = if i == k { value.max(0.0).sqrt() } else { value / factor.l[k][k] };
            }
            let mut rest = g[i];
            for m in 0..i {
                rest -= factor.l[i][m] * factor.g[m];
            }
            // A depth that nothing was said of is no unknown; nor is one at its bound that would go on beyond it.
            if i == DEPTH && (factor.l[i][i] < 3e-5 || (at_bound && rest >= 0.0)) {
                factor.unknowns = DEPTH;
                break;
            }
            factor.g[i] = rest / factor.l[i][i];
        }
        factor
    }
}

/// A landmark's own block, factored, and `L^-1 g`.
struct OwnFactor {
    l: [[f64; LOCAL]; LOCAL],
    g: [f64; LOCAL],
    /// How many of its unknowns are unknowns: all, or all but the depth.
    unknowns: usize,
}

impl OwnFactor {
    /// Makes `W` into `L^-1 W` and takes `W^T A^-1 W` and `W^T A^-1 g` off the `width` states from `at` on.
    #[inline(always)]
    fn take_out<S: Simd>(
        &self,
        simd: S,
        normal: &mut Normal,
        w: &mut [f64],
        stride: usize,
        at: usize,
        width: usize,
    ) {
        let (w0, rest) = w.split_at_mut(stride);
        let (w1, w2) = rest.split_at_mut(stride);
        let pivot = |i: usize| if i < self.unknowns { 1.0 / self.l[i][i] } else { 0.0 };
        scale(simd, w0, pivot(0));
        add_weighted(simd, w1, [-self.l[1][0]], [w0]);
        scale(simd, w1, pivot(1));
        add_weighted(simd, w2, [-self.l[2][0], -self.l[2][1]], [w0, w1]);
        scale(simd, w2, pivot(2));
        let gradient = &mut normal.whole_gradient_mut()[at..];
        let whole = width.next_multiple_of(LANES);
        add_weighted(
            simd,
            &mut gradient[..whole],
            self.g.map(|g| -g),
            [&w0[..whole], &w1[..whole], &w2[..whole]],
        );
        let factors = |i: usize| [-w0[i], -w1[i], -w2[i]];
        let by_blocks = width - width % ROWS;
        for i in (0..by_blocks).step_by(ROWS) {
            let whole = (i + ROWS).next_multiple_of(LANES);
            let rows = normal.whole_rows_mut::<ROWS>(at + i).map(|row| &mut row[at..][..whole]);
            let factors = std::array::from_fn(|r| factors(i + r));
            add_weighted_to_each(simd, rows, factors, [&w0[..whole], &w1[..whole], &w2[..whole]]);
        }
        for i in by_blocks..width {
            let whole = (i + 1).next_multiple_of(LANES);
            let row = &mut normal.whole_row_mut(at + i)[at..][..whole];
            add_weighted(simd, row, factors(i), [&w0[..whole], &w1[..whole], &w2[..whole]]);
        }
    }
}

#[inline(always)]
fn both(rows: &Rows) -> [&[f64]; 2] {
    [&rows[0], &rows[1]]
}

/// A vector's worth of a row.
#[inline(always)]
fn block(row: &mut [f64], at: usize) -> &mut [f64] {
    &mut row[at..at + LANES]
}

/// The rows times `factor`, filled up with zeros.
#[inline(always)]
fn filled(rows: &[[f64; POSE_DIM]; 2], factor: f64) -> Rows {
    let mut all = Rows::default();
    for r in 0..2 {
        for k in 0..POSE_DIM {
            all[r][k] = rows[r][k] * factor;
        }
    }
    all
}
