//! Whether the accelerometer's usual force is gravity's: the first sign of a wrong unit.

use dpn_core::ImuSample;
use dpn_core::signal::stats::median_of;
use nalgebra::Vector3;

/// Median length of the specific force of a flight \[m/s^2\]; outside, units or axes are not what they should be.
const RANGE: std::ops::Range<f64> = 8.0..12.0;
/// No vehicle has so much for long \[m/s^2\]: such numbers are no m/s^2.
const COUNTS: f64 = 100.0;

/// What is to be said of samples whose median force is far from gravity's; `None` where it is not, or there are none.
pub fn gravity_warning<'a>(samples: impl IntoIterator<Item = &'a ImuSample>) -> Option<String> {
    let force = median_of(samples.into_iter().map(|s| Vector3::from(s.accel).norm()))?;
    if RANGE.contains(&force) {
        return None;
    }
    let question = match force > COUNTS {
        true => "are these raw counts? a log's are mended by --sensor-scale or --accel-scale",
        false => {
            "is the accelerometer in g (a log's is mended by --accel-scale 9.80665), or gravity taken out?"
        }
    };
    Some(format!("the median specific force is {force:.2} m/s^2, not near 9.81: {question}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::Stamp;

    #[test]
    fn units_that_are_none_are_named_and_flights_are_not() {
        let said = |accel: [f64; 3]| {
            gravity_warning(&[ImuSample { t: Stamp::from_ns(0), gyro: [0.0; 3], accel }; 3])
        };
        assert_eq!((said([1.0, -2.0, 9.5]), gravity_warning(&[])), (None, None));
        assert!(said([0.0, 0.0, 1.0]).unwrap().contains("--accel-scale 9.80665"));
        assert!(said([0.0, 0.0, -4096.0]).unwrap().contains("raw counts"));
    }
}
