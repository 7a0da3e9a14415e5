//! What the lines of sight of a batch meet, and its grey value: loops over whole arrays, for the compiler's vector units.

use super::super::texture::{LOG_COARSEST, LOG_SIDE};
use super::lens::{BATCH, Lines};
use super::view::{Facet, Linear};

/// Nothing is met.
pub(crate) const NOTHING: u16 = u16::MAX;

/// Most texture samples side by side where a surface is seen aslant.
const MOST_PROBES: usize = 4;

/// How far texture samples may lie apart, in widths of one: a bilinear look-up reaches over its neighbours'.
const APART: f32 = 1.5;

/// Lines that are worked on together: what meets a facet lies together too.
const ROW: usize = 16;

/// Lines of sight and what becomes of them. Only numbers, so that one is made once.
#[derive(Debug, Clone)]
pub(crate) struct Batch {
    pub(crate) x: Lines,
    pub(crate) y: Lines,
    /// d(x, y) / d(u, v) \[1/px\], times the width of a sample \[px\].
    pub(crate) per_sample: [[f32; 2]; 2],
    /// The nearest facet's place, or [`NOTHING`].
    pub(crate) place: [u16; BATCH],
    /// Grey values.
    pub(crate) grey: Lines,
    near: Lines,
    u: Lines,
    v: Lines,
    /// The long axis of a sample on the texture \[texels\], and its short one's length squared.
    long_u: Lines,
    long_v: Lines,
    long2: Lines,
    short2: Lines,
    gain: Lines,
    lift: Lines,
    base: [u32; BATCH],
    level: Lines,
    at: [[u32; BATCH]; 2],
    fx: [Lines; 2],
    fy: [Lines; 2],
    four: [[u32; BATCH]; 2],
}

impl Default for Batch {
    fn default() -> Self {
        let zero = [0.0; BATCH];
        Self {
            x: zero,
            y: zero,
            per_sample: [[0.0; 2]; 2],
            place: [NOTHING; BATCH],
            grey: zero,
            near: zero,
            u: zero,
            v: zero,
            long_u: zero,
            long_v: zero,
            long2: zero,
            short2: zero,
            gain: zero,
            lift: zero,
            base: [0; BATCH],
            level: zero,
            at: [[0; BATCH]; 2],
            fx: [zero; 2],
            fy: [zero; 2],
            four: [[0; BATCH]; 2],
        }
    }
}

#[inline(always)]
fn value(linear: &Linear, x: f32, y: f32) -> f32 {
    linear[0] * x + linear[1] * y + linear[2]
}

impl Batch {
    /// Finds the nearest of the facets in `list` on every line.
    #[inline(always)]
    pub(crate) fn find(&mut self, facets: &[Facet], list: &[u16]) {
        self.near = [0.0; BATCH];
        self.place = [NOTHING; BATCH];
        for &place in list {
            let facet = &facets[usize::from(place)];
            let [left, right, top, bottom] = &facet.edges;
            for i in 0..BATCH {
                let (x, y) = (self.x[i], self.y[i]);
                let near = value(&facet.near, x, y);
                let inside =
                    value(left, x, y).min(value(right, x, y)).min(value(top, x, y).min(value(bottom, x, y)));
                let better = (inside >= 0.0) & (near > self.near[i]);
                self.near[i] = if better { near } else { self.near[i] };
                self.place[i] = if better { place } else { self.place[i] };
            }
        }
    }

    /// Takes `place` to be what every line meets.
    #[inline(always)]
    pub(crate) fn fill(&mut self, place: u16) {
        self.place = [place; BATCH];
    }

    /// The grey values of what was found; `list` has its places.
    #[inline(always)]
    pub(crate) fn shade(&mut self, facets: &[Facet], list: &[u16], texels: &[u32]) {
        match list {
            [only] => self.surface::<true>(&facets[usize::from(*only)], *only),
            _ => {
                (self.gain, self.lift) = ([0.0; BATCH], [0.0; BATCH]);
                (self.long2, self.short2) = ([1.0; BATCH], [1.0; BATCH]);
                for &place in list {
                    self.surface::<false>(&facets[usize::from(place)], place);
                }
            }
        }
        let aslant = (0..BATCH).fold(1.0_f32, |most, i| most.max(self.long2[i] / self.short2[i]));
        let probes =
            [1, 2].into_iter().find(|n| aslant <= (APART * *n as f32).powi(2)).unwrap_or(MOST_PROBES);
        let coarsest = self.levels(probes);
        self.grey = [0.0; BATCH];
        for probe in 0..probes {
            let (along, weight) = ((probe as f32 + 0.5) / probes as f32 - 0.5, 1.0 / probes as f32);
            if coarsest > 0.0 {
                self.look_up::<2>(along, weight, texels);
            } else {
                self.look_up::<1>(along, weight, texels);
            }
        }
        for i in 0..BATCH {
            self.grey[i] = self.gain[i] * self.grey[i] + self.lift[i];
        }
    }

    /// Texture coordinates, footprint and light on one facet: of all lines, or of those that meet it.
    #[inline(always)]
    fn surface<const ALL: bool>(&mut self, facet: &Facet, place: u16) {
        let [[xa, xb], [ya, yb]] = self.per_sample;
        let [c0, c1, c2, c3, c4, c5] = facet.light;
        for row in 0..BATCH / ROW {
            let lines = row * ROW..(row + 1) * ROW;
            if !ALL && !self.place[lines.clone()].iter().fold(false, |seen, at| seen | (*at == place)) {
                continue;
            }
            for i in lines {
                let (x, y) = (self.x[i], self.y[i]);
                let depth = 1.0 / value(&facet.near, x, y);
                let (u, v) = (value(&facet.u, x, y) * depth, value(&facet.v, x, y) * depth);
                // d(u, v) / d(x, y), then by the sample's own sides.
                let (ux, uy) =
                    ((facet.u[0] - u * facet.near[0]) * depth, (facet.u[1] - u * facet.near[1]) * depth);
                let (vx, vy) =
                    ((facet.v[0] - v * facet.near[0]) * depth, (facet.v[1] - v * facet.near[1]) * depth);
                let (a, b) = (ux * xa + uy * ya, ux * xb + uy * yb);
                let (c, d) = (vx * xa + vy * ya, vx * xb + vy * yb);
                // Axes of the ellipse that a round sample covers on the texture.
                let (p, q, r) = (a * a + b * b, a * c + b * d, c * c + d * d);
                let sum = p + r;
                let det = a * d - b * c;
                let root = ((p - r) * (p - r) + 4.0 * q * q).sqrt();
                let long2 = 0.5 * (sum + root);
                let short2 = (det * det / long2).max(1e-12);
                let (du, dv) = if p >= r { (long2 - r, q) } else { (q, long2 - p) };
                let scale = (long2 / (du * du + dv * dv).max(1e-20)).sqrt();
                let light = c0 + u * (c1 + c3 * u + c4 * v) + v * (c2 + c5 * v);
                let new = [
                    u + facet.offset[0],
                    v + facet.offset[1],
                    du * scale,
                    dv * scale,
                    long2,
                    short2,
                    facet.gain * light,
                    facet.lift * light,
                ];
                let here = ALL | (self.place[i] == place);
                let arrays = [
                    &mut self.u[i],
                    &mut self.v[i],
                    &mut self.long_u[i],
                    &mut self.long_v[i],
                    &mut self.long2[i],
                    &mut self.short2[i],
                    &mut self.gain[i],
                    &mut self.lift[i],
                ];
                for (to, new) in arrays.into_iter().zip(new) {
                    *to = if here { new } else { *to };
                }
                self.base[i] = if here { facet.base } else { self.base[i] };
            }
        }
    }

    /// The texture's level for every line, with `probes` samples along the long axis; returns the coarsest.
    #[inline(always)]
    fn levels(&mut self, probes: usize) -> f32 {
        let share = 1.0 / (APART * probes as f32).powi(2);
        let mut coarsest = 0.0_f32;
        for i in 0..BATCH {
            let width2 = self.short2[i].max(self.long2[i] * share);
            self.level[i] = (0.5 * log2(width2)).clamp(0.0, (LOG_SIDE - LOG_COARSEST) as f32 - 0.01);
            coarsest = coarsest.max(self.level[i]);
        }
        coarsest
    }

    /// Adds `weight` times the texture, `along` a sample's length from its middle, interpolated in u, v and, over two levels, between
    /// them; with one, all are of the finest.
    #[inline(always)]
    fn look_up<const LEVELS: usize>(&mut self, along: f32, weight: f32, texels: &[u32]) {
        for k in 0..LEVELS {
            for i in 0..BATCH {
                let (u, v) = (self.u[i] + along * self.long_u[i], self.v[i] + along * self.long_v[i]);
                let level = if LEVELS == 1 { 0 } else { self.level[i] as i32 + k as i32 };
                let scale = f32::from_bits(((127 - level) as u32) << 23);
                let (x, y) = (u * scale - 0.5, v * scale - 0.5);
                // Not negative but by the half texel, and then it wraps as it should: floor by way of a whole number more.
                let (xi, yi) = ((x + 1.0) as i32 - 1, (y + 1.0) as i32 - 1);
                (self.fx[k][i], self.fy[k][i]) = (x - xi as f32, y - yi as f32);
                let log = LOG_SIDE - level as u32;
                let mask = (1_u32 << log) - 1;
                let start = 1_u32 << (2 * log - 1);
                self.at[k][i] = self.base[i] + start + (((yi as u32) & mask) << log) + ((xi as u32) & mask);
            }
            for i in 0..BATCH {
                self.four[k][i] = texels.get(self.at[k][i] as usize).copied().unwrap_or(0);
            }
        }
        for i in 0..BATCH {
            let grey = |k: usize| {
                let four = self.four[k][i];
                let byte = |shift: u32| ((four >> shift) & 255) as i32 as f32;
                let (fx, fy) = (self.fx[k][i], self.fy[k][i]);
                let top = byte(0) + fx * (byte(8) - byte(0));
                let bottom = byte(16) + fx * (byte(24) - byte(16));
                top + fy * (bottom - top)
            };
            let fine = grey(0);
            let found = if LEVELS == 1 {
                fine
            } else {
                let between = self.level[i] - (self.level[i] as i32) as f32;
                fine + between * (grey(1) - fine)
            };
            self.grey[i] += weight * found;
        }
    }
}

/// log2 of a positive number within .09, without a step and never falling: exact at powers of 2, a straight line between.
#[inline(always)]
fn log2(value: f32) -> f32 {
    let bits = value.to_bits() as i32;
    (bits - (127 << 23)) as f32 * (1.0 / (1 << 23) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quick_logarithm_is_near_the_true_one() {
        for i in 1..4000 {
            let value = 1.003_f32.powi(i) * 0.01;
            assert!((log2(value) - value.log2()).abs() < 0.0861, "{value}");
        }
    }
}
