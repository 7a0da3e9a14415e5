//! Eight numbers at a time, said outright: of loops over eight the compiler makes single numbers, and a search takes twice as long.
//!
//! Sums are taken eight columns at a time on every machine, and nothing is fused, so that the same numbers come out on all of them.

use pulp::{Arch, NullaryFnOnce, Scalar256b, Simd, f32x8};

/// Columns at a time.
pub(super) const LANES: usize = 8;

/// Vectors of [`LANES`] numbers.
pub(super) trait Lanes: Simd<f32s = f32x8> {
    /// Grey values as numbers.
    fn widen(self, pixels: [u8; LANES]) -> f32x8;

    /// Grey values of [`LANES`] columns, each `weight` of the way to its right neighbour; `pixels` are one more.
    #[inline(always)]
    fn between_columns(self, pixels: &[u8], weight: f32x8) -> f32x8 {
        let (left, right) = (first_chunk(pixels), first_chunk(&pixels[1..]));
        self.between(self.widen(left), self.widen(right), weight)
    }

    /// `weight` of the way from `a` to `b`.
    #[inline(always)]
    fn between(self, a: f32x8, b: f32x8, weight: f32x8) -> f32x8 {
        self.add_f32s(a, self.mul_f32s(weight, self.sub_f32s(b, a)))
    }

    /// Adds the product of `a` and `b`, rounded by itself, to `sum`.
    #[inline(always)]
    fn add_product(self, sum: &mut f32x8, a: f32x8, b: f32x8) {
        *sum = self.add_f32s(*sum, self.mul_f32s(a, b));
    }

    /// Adds to `sum`.
    #[inline(always)]
    fn add_to(self, sum: &mut f32x8, what: f32x8) {
        *sum = self.add_f32s(*sum, what);
    }
}

#[cfg(target_arch = "x86_64")]
impl Lanes for pulp::x86::V3 {
    #[inline(always)]
    fn widen(self, pixels: [u8; LANES]) -> f32x8 {
        let bytes = pulp::cast(pulp::u64x2(u64::from_le_bytes(pixels), 0));
        pulp::cast(self.avx._mm256_cvtepi32_ps(self.avx2._mm256_cvtepu8_epi32(bytes)))
    }
}

impl Lanes for Scalar256b {
    #[inline(always)]
    fn widen(self, pixels: [u8; LANES]) -> f32x8 {
        pulp::cast(pixels.map(f32::from))
    }
}

#[inline(always)]
fn first_chunk(pixels: &[u8]) -> [u8; LANES] {
    *pixels.first_chunk().expect("a window's row and its right neighbour")
}

/// [`LANES`] numbers of a row from `first` on.
#[inline(always)]
pub(super) fn part(row: &[f32], first: usize) -> f32x8 {
    let numbers: &[f32; LANES] = row[first..].first_chunk().expect("rows are whole vectors");
    pulp::cast(*numbers)
}

/// Writes them.
#[inline(always)]
pub(super) fn put(row: &mut [f32], first: usize, numbers: f32x8) {
    let to: &mut [f32; LANES] = row[first..].first_chunk_mut().expect("rows are whole vectors");
    *to = pulp::cast(numbers);
}

/// The sum of the lanes, in one order.
#[inline(always)]
pub(super) fn sum_of(lanes: f32x8) -> f32 {
    let f32x8(a, b, c, d, e, f, g, h) = lanes;
    ((a + e) + (b + f)) + ((c + g) + (d + h))
}

/// `N` sums over a window's columns.
#[derive(Clone, Copy)]
pub(super) struct Sums<S, const N: usize> {
    simd: S,
    lanes: [f32x8; N],
}

impl<S: Lanes, const N: usize> Sums<S, N> {
    /// All of them 0.
    #[inline(always)]
    pub(super) fn new(simd: S) -> Self {
        Self { simd, lanes: [simd.splat_f32s(0.0); N] }
    }

    /// Adds what some columns sum to, as far as these count.
    #[inline(always)]
    pub(super) fn add(&mut self, sums: &[f32x8; N], columns: f32x8) {
        for (lanes, sum) in self.lanes.iter_mut().zip(sums) {
            self.simd.add_product(lanes, *sum, columns);
        }
    }

    /// Over all columns.
    #[inline(always)]
    pub(super) fn totals(&self) -> [f32; N] {
        let mut totals = [0.0; N];
        for (total, lanes) in totals.iter_mut().zip(&self.lanes) {
            *total = sum_of(*lanes);
        }
        totals
    }
}

/// What is done with vectors.
pub(super) trait OnLanes {
    /// Does it.
    fn run<S: Lanes>(self, simd: S);
}

struct On<S, O>(S, O);

impl<S: Lanes, O: OnLanes> NullaryFnOnce for On<S, O> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.1.run(self.0);
    }
}

/// Does `what` with this machine's vectors.
pub(super) fn dispatch(what: impl OnLanes) {
    match Arch::new() {
        #[cfg(target_arch = "x86_64")]
        Arch::V3(simd) => simd.vectorize(On(simd, what)),
        #[cfg(target_arch = "x86_64")]
        Arch::V4(simd) => simd.vectorize(On(*simd, what)),
        _ => what.run(Scalar256b),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    struct Compare {
        pixels: [u8; LANES + 1],
        weight: f32,
        numbers: [f32; LANES],
    }

    impl OnLanes for Compare {
        fn run<S: Lanes>(self, simd: S) {
            let done = |grey: f32x8, sum: f32x8| (pulp::cast::<_, [u32; LANES]>(grey), sum_of(sum).to_bits());
            let numbers = part(&self.numbers, 0);
            let grey = simd.between_columns(&self.pixels, simd.splat_f32s(self.weight));
            let mut sum = simd.splat_f32s(0.25);
            simd.add_product(&mut sum, grey, numbers);
            let plain = Scalar256b.between_columns(&self.pixels, Scalar256b.splat_f32s(self.weight));
            let mut plain_sum = Scalar256b.splat_f32s(0.25);
            Scalar256b.add_product(&mut plain_sum, plain, numbers);
            assert_eq!(done(grey, sum), done(plain, plain_sum));
        }
    }

    proptest! {
        #[test]
        fn this_machines_vectors_give_the_plain_numbers(
            pixels in any::<[u8; LANES + 1]>(), weight in 0.0..1.0f32, numbers in prop::array::uniform8(-200.0..200.0f32),
        ) {
            dispatch(Compare { pixels, weight, numbers });
        }
    }
}
