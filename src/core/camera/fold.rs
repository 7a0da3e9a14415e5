//! Where a lens' polynomial stops rising: beyond, it folds back into the image.

/// Steps in which the range is walked.
const STEPS: u32 = 512;

/// Halvings of the step that holds the fold.
const HALVINGS: u32 = 40;

fn does_not_rise(slope: f64) -> bool {
    slope <= 0.0 || slope.is_nan()
}

/// The first argument in `0..end` at which `slope` is not positive; `None` where it always is.
pub(super) fn first_fold(slope: impl Fn(f64) -> f64, end: f64) -> Option<f64> {
    let at = |i: u32| end * f64::from(i) / f64::from(STEPS);
    let first = (0..=STEPS).find(|i| does_not_rise(slope(at(*i))))?;
    let (mut low, mut high) = (at(first.saturating_sub(1)), at(first));
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if slope(middle) > 0.0 { low = middle } else { high = middle }
    }
    Some(low)
}
