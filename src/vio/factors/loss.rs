//! Robust losses: how much a large visual residual may still pull.
//!
//! `rho(s)` of the squared, whitened residual `s`; the cost is `rho / 2`, the weight of the row `rho'(s)`, 1 at zero and never rising.

use serde::{Deserialize, Serialize};

/// A robust loss.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Loss {
    /// None: `rho = s`.
    Squared,
    /// Quadratic, then linear: `rho = s` up to `c^2`, then `2 c sqrt(s) - c^2`.
    Huber,
    /// `rho = c^2 ln(1 + s / c^2)`.
    Cauchy,
}

impl Loss {
    /// `rho` and `rho'` at the squared residual `s`; `scale` is c, in standard deviations.
    #[inline]
    pub(crate) fn evaluate(self, s: f64, scale: f64) -> (f64, f64) {
        let c2 = scale * scale;
        match self {
            Self::Squared => (s, 1.0),
            Self::Huber if s <= c2 => (s, 1.0),
            Self::Huber => {
                let root = s.sqrt();
                (2.0 * scale * root - c2, scale / root)
            }
            Self::Cauchy => {
                let ratio = 1.0 + s / c2;
                (c2 * ratio.ln(), 1.0 / ratio)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ALL: [Loss; 3] = [Loss::Squared, Loss::Huber, Loss::Cauchy];

    proptest! {
        #[test]
        fn the_weight_is_the_derivative_and_never_rises(s in 0.01..100.0f64, scale in 0.5..3.0f64) {
            for loss in ALL {
                let step = 1e-6 * s;
                let slope = (loss.evaluate(s + step, scale).0 - loss.evaluate(s - step, scale).0) / (2.0 * step);
                let (_, weight) = loss.evaluate(s, scale);
                prop_assert!((slope - weight).abs() < 1e-6);
                prop_assert!(loss.evaluate(s * 1.1, scale).1 <= weight);
            }
        }
    }

    #[test]
    fn a_perfect_measurement_has_weight_one() {
        for loss in ALL {
            assert_eq!(loss.evaluate(0.0, 1.5), (0.0, 1.0));
        }
    }
}
