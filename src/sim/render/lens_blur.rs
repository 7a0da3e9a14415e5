//! The blur of lens and pixel: a Gaussian over five pixels, first along rows, then along columns.

use pulp::{Arch, Simd, WithSimd};

/// A blur, and room for it.
#[derive(Debug, Clone)]
pub(super) struct LensBlur {
    /// Weights of the middle, of its neighbours, of theirs.
    weights: Option<[f32; 3]>,
    other: Vec<f32>,
}

impl LensBlur {
    /// A blur of that standard deviation \[px\]; 0 for none.
    pub(super) fn new(sigma: f64) -> Self {
        let weights = (sigma > 0.0).then(|| {
            let weight = |step: f64| (-0.5 * (step / sigma).powi(2)).exp();
            let sum = 1.0 + 2.0 * (weight(1.0) + weight(2.0));
            [1.0, weight(1.0), weight(2.0)].map(|w| (w / sum) as f32)
        });
        Self { weights, other: Vec::new() }
    }

    /// Blurs an image of `width` columns; at the border its last pixel goes on.
    pub(super) fn apply(&mut self, grey: &mut [f32], width: usize) {
        let Some(weights) = self.weights else { return };
        self.other.resize(grey.len(), 0.0);
        Arch::new().dispatch(Blur { weights, grey, other: &mut self.other, width });
    }
}

struct Blur<'a> {
    weights: [f32; 3],
    grey: &'a mut [f32],
    other: &'a mut [f32],
    width: usize,
}

impl WithSimd for Blur<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { weights, grey, other, width } = self;
        let height = grey.len() / width;
        for (from, to) in grey.chunks_exact(width).zip(other.chunks_exact_mut(width)) {
            let inner = width.saturating_sub(4);
            if let Some(middle) = to.get_mut(2..2 + inner).filter(|middle| !middle.is_empty()) {
                sum(
                    weights,
                    [&from[2..], &from[1..], &from[3..], from, &from[4..]].map(|s| &s[..inner]),
                    middle,
                );
            }
            let at = |x: usize, step: isize| from[x.saturating_add_signed(step).min(width - 1)];
            for x in (0..width.min(2)).chain(width.saturating_sub(2)..width) {
                let [a, b, c] = weights;
                to[x] = a * at(x, 0) + b * (at(x, -1) + at(x, 1)) + c * (at(x, -2) + at(x, 2));
            }
        }
        for (y, to) in grey.chunks_exact_mut(width).enumerate() {
            let row = |step: isize| &other[y.saturating_add_signed(step).min(height - 1) * width..][..width];
            sum(weights, [row(0), row(-1), row(1), row(-2), row(2)], to);
        }
    }
}

#[inline(always)]
fn sum([a, b, c]: [f32; 3], from: [&[f32]; 5], to: &mut [f32]) {
    let [middle, left, right, farther_left, farther_right] = from;
    let neighbours = left.iter().zip(right).zip(farther_left.iter().zip(farther_right));
    for ((to, middle), ((l, r), (ll, rr))) in to.iter_mut().zip(middle).zip(neighbours) {
        *to = a * middle + b * (l + r) + c * (ll + rr);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_spreads_by_the_deviation_asked_for_and_keeps_its_light() {
        let mut blur = LensBlur::new(0.6);
        let mut grey = vec![0.0; 21 * 11];
        grey[5 * 21 + 10] = 100.0;
        blur.apply(&mut grey, 21);
        let sum: f32 = grey.iter().sum();
        assert!((sum - 100.0).abs() < 1e-3);
        for axis in [0, 1] {
            let spread = |(i, grey): (usize, &f32)| {
                let step =
                    if axis == 0 { i % 21 } else { i / 21 } as f32 - if axis == 0 { 10.0 } else { 5.0 };
                grey * step * step
            };
            let variance = grey.iter().enumerate().map(spread).sum::<f32>() / sum;
            assert!((variance - 0.36).abs() < 0.03, "{variance}");
        }
    }

    #[test]
    fn an_even_image_stays_even_whatever_its_size() {
        for (width, height) in [(1, 1), (2, 3), (3, 1), (7, 5), (4, 4)] {
            let mut grey = vec![50.0; width * height];
            LensBlur::new(1.0).apply(&mut grey, width);
            assert!(grey.iter().all(|g| (g - 50.0).abs() < 1e-4), "{width} x {height}");
        }
        let mut grey = vec![1.0, 2.0];
        LensBlur::new(0.0).apply(&mut grey, 2);
        assert_eq!(grey, [1.0, 2.0]);
    }
}
