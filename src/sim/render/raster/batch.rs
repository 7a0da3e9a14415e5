//! What the lines of sight of a batch meet, and its grey value: loops over whole arrays, for the compiler's vector units.

use super::super::texture::{LOG_COARSEST, LOG_SIDE};
use super::lens::{BATCH, Lines};
use super::view::{Facet, Linear};

/// Nothing is met.
pub(crate) const NOTHING: u32 = u32::MAX;

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
    pub(crate) place: [u32; BATCH],
    /// Grey values.
    pub(crate) grey: Lines,
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
        let rows = self.x.as_chunks::<ROW>().0.iter().zip(self.y.as_chunks::<ROW>().0);
        for (to, (x, y)) in self.place.as_chunks_mut::<ROW>().0.iter_mut().zip(rows) {
            let (mut nearest, mut places) = ([0.0; ROW], [NOTHING; ROW]);
            for &place in list {
                let facet = &facets[usize::from(place)];
                let [left, right, top, bottom] = &facet.edges;
                for i in 0..ROW {
                    let (x, y) = (x[i], y[i]);
                    let near = value(&facet.near, x, y);
                    let better = (value(left, x, y) >= 0.0)
                        & (value(right, x, y) >= 0.0)
                        & (value(top, x, y) >= 0.0)
                        & (value(bottom, x, y) >= 0.0)
                        & (near > nearest[i]);
                    nearest[i] = if better { near } else { nearest[i] };
                    places[i] = if better { u32::from(place) } else { places[i] };
                }
            }
            *to = places;
        }
    }

    /// Takes `place` to be what every line meets.
    #[inline(always)]
    pub(crate) fn fill(&mut self, place: u16) {
        self.place = [u32::from(place); BATCH];
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
        let aslant = largest(&std::array::from_fn(|i| self.long2[i] / self.short2[i]));
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
        for row in 0..BATCH / ROW {
            let here: [bool; ROW] =
                self.place.as_chunks::<ROW>().0[row].map(|at| ALL | (at == u32::from(place)));
            if here.iter().fold(false, |some, here| some | *here) {
                let found =
                    aim(facet, &self.per_sample, &self.x.as_chunks().0[row], &self.y.as_chunks().0[row]);
                let to = [
                    &mut self.u,
                    &mut self.v,
                    &mut self.long_u,
                    &mut self.long_v,
                    &mut self.long2,
                    &mut self.short2,
                    &mut self.gain,
                    &mut self.lift,
                ];
                for (to, found) in to.into_iter().zip(found) {
                    let to: &mut [f32; ROW] = &mut to.as_chunks_mut().0[row];
                    for i in 0..ROW {
                        to[i] = if here[i] { found[i] } else { to[i] };
                    }
                }
                let base: &mut [u32; ROW] = &mut self.base.as_chunks_mut().0[row];
                for i in 0..ROW {
                    base[i] = if here[i] { facet.base } else { base[i] };
                }
            }
        }
    }

    /// The texture's level for every line, with `probes` samples along the long axis; returns the coarsest.
    #[inline(always)]
    fn levels(&mut self, probes: usize) -> f32 {
        let share = 1.0 / (APART * probes as f32).powi(2);
        for i in 0..BATCH {
            let width2 = self.short2[i].max(self.long2[i] * share);
            self.level[i] = (0.5 * log2(width2)).clamp(0.0, (LOG_SIDE - LOG_COARSEST) as f32 - 0.01);
        }
        largest(&self.level)
    }

    /// Adds `weight` times the texture, `along` a sample's length from its middle, interpolated in u, v and, over two levels, between
    /// them; with one, all are of the finest.
    #[inline(always)]
    fn look_up<const LEVELS: usize>(&mut self, along: f32, weight: f32, texels: &[u32]) {
        for k in 0..LEVELS {
            for i in 0..BATCH {
                let (u, v) = (self.u[i] + along * self.long_u[i], self.v[i] + along * self.long_v[i]);
                let level = if LEVELS == 1 { 0 } else { floor(self.level[i]).0 + k as i32 };
                let scale = f32::from_bits(((127 - level) as u32) << 23);
                let (x, y) = (u * scale - 0.5, v * scale - 0.5);
                let ((xi, fx), (yi, fy)) = (floor(x), floor(y));
                (self.fx[k][i], self.fy[k][i]) = (fx, fy);
                let log = LOG_SIDE - level as u32;
                let mask = (1_u32 << log) - 1;
                let start = 1_u32 << (2 * log - 1);
                self.at[k][i] = self.base[i] + start + (((yi as u32) & mask) << log) + ((xi as u32) & mask);
            }
            let Some(last) = texels.len().checked_sub(1) else { return };
            for i in 0..BATCH {
                // Never beyond the last: said so that the compiler need not ask.
                self.four[k][i] = texels[(self.at[k][i] as usize).min(last)];
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
            let found = if LEVELS == 1 { fine } else { fine + floor(self.level[i]).1 * (grey(1) - fine) };
            self.grey[i] += weight * found;
        }
    }
}

/// Where lines of sight meet the plane of a facet: u, v, the long axis of a sample in u and v, its length squared, the short one's
/// squared \[texels\], and gain and lift in the light there.
#[inline(always)]
fn aim(facet: &Facet, per_sample: &[[f32; 2]; 2], x: &[f32; ROW], y: &[f32; ROW]) -> [[f32; ROW]; 8] {
    let [[xa, xb], [ya, yb]] = *per_sample;
    let [c0, c1, c2, c3, c4, c5] = facet.light;
    let mut found = [[0.0; ROW]; 8];
    let [to_u, to_v, to_long_u, to_long_v, to_long2, to_short2, to_gain, to_lift] = &mut found;
    for i in 0..ROW {
        let (x, y) = (x[i], y[i]);
        let depth = 1.0 / value(&facet.near, x, y);
        let (u, v) = (value(&facet.u, x, y) * depth, value(&facet.v, x, y) * depth);
        // d(u, v) / d(x, y), then by the sample's own sides.
        let (ux, uy) = ((facet.u[0] - u * facet.near[0]) * depth, (facet.u[1] - u * facet.near[1]) * depth);
        let (vx, vy) = ((facet.v[0] - v * facet.near[0]) * depth, (facet.v[1] - v * facet.near[1]) * depth);
        let (a, b) = (ux * xa + uy * ya, ux * xb + uy * yb);
        let (c, d) = (vx * xa + vy * ya, vx * xb + vy * yb);
        // Axes of the ellipse that a round sample covers on the texture.
        let (p, q, r) = (a * a + b * b, a * c + b * d, c * c + d * d);
        let det = a * d - b * c;
        let root = ((p - r) * (p - r) + 4.0 * q * q).sqrt();
        let long2 = 0.5 * (p + r + root);
        // Of two expressions for the long axis the one that does not cancel.
        let steep = p < r;
        let (du, dv) = (if steep { q } else { long2 - r }, if steep { long2 - p } else { q });
        let scale = (long2 / (du * du + dv * dv).max(1e-20)).sqrt();
        let light = c0 + u * (c1 + c3 * u + c4 * v) + v * (c2 + c5 * v);
        to_u[i] = u + facet.offset[0];
        to_v[i] = v + facet.offset[1];
        to_long_u[i] = du * scale;
        to_long_v[i] = dv * scale;
        to_long2[i] = long2;
        to_short2[i] = (det * det / long2).max(1e-12);
        to_gain[i] = facet.gain * light;
        to_lift[i] = facet.lift * light;
    }
    found
}

/// The whole number below a value of size 2^22 at most, and what is left; a whole number may come as the one below it and 1.
///
/// Adding 1.5 * 2^23 leaves a whole number in the lowest bits: no conversion that asks for infinities.
#[inline(always)]
fn floor(value: f32) -> (i32, f32) {
    const SHIFT: f32 = 12_582_912.0;
    let shifted = (value - 0.5) + SHIFT;
    ((shifted.to_bits() as i32).wrapping_sub(SHIFT.to_bits() as i32), value - (shifted - SHIFT))
}

/// The largest of numbers that are not negative: their bits are in the same order.
#[inline(always)]
fn largest(values: &Lines) -> f32 {
    f32::from_bits(values.iter().fold(0, |most, value| most.max(value.to_bits())))
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
    fn floors_are_whole_numbers_and_shares() {
        for i in -3000..3000 {
            let value = i as f32 * 0.37;
            let (whole, share) = floor(value);
            assert!((0.0..=1.0).contains(&share) && (whole as f32 + share - value).abs() < 1e-4, "{value}");
        }
        assert_eq!((floor(0.0), floor(-0.25), floor(7.0)), ((0, 0.0), (-1, 0.75), (6, 1.0)));
    }

    #[test]
    fn the_quick_logarithm_is_near_the_true_one() {
        for i in 1..4000 {
            let value = 1.003_f32.powi(i) * 0.01;
            assert!((log2(value) - value.log2()).abs() < 0.0861, "{value}");
        }
    }
}
