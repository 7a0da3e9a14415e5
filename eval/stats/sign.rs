//! The sign test of paired differences: under the null hypothesis each is as likely to be positive as negative. Differences of zero are left out.

use statrs::distribution::{Binomial, DiscreteCDF};

/// Two-sided p of so many differences of either sign: twice the smaller tail of the binomial distribution, at most 1.
pub fn sign_test(below: usize, above: usize) -> f64 {
    let fair = Binomial::new(0.5, (below + above) as u64).expect("a half is a probability");
    (2.0 * fair.cdf(below.min(above) as u64)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_are_those_of_a_fair_coin() {
        // To what the distribution's own function errs by. (1 + 8 + 28) / 2^8, twice; all eight alike; as many on either side.
        assert!((sign_test(2, 6) - 2.0 * 37.0 / 256.0).abs() < 1e-12);
        assert!((sign_test(8, 0) - 2.0 / 256.0).abs() < 1e-12);
        assert_eq!((sign_test(4, 4), sign_test(0, 0)), (1.0, 1.0));
    }
}
