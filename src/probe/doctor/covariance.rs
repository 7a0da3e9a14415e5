//! The covariances that a log's messages carry, held against what the log shows at rest.

use crate::finding::Finding;
use dpn_core::{Recorded, Sensor};
use dpn_logs::Log;

/// Up to this factor, up or down, they agree.
const AGREES: f64 = 3.0;

/// `at_rest` are the densities that the log has there, accelerometer and gyroscope.
pub(super) fn findings(log: &Log, at_rest: [Option<f64>; 2]) -> Vec<Finding> {
    let of = |(sensor, variances, density): (Sensor, Option<[f64; 3]>, Option<f64>)| {
        // A sample of white noise of that density.
        let has = density? * log.recording.rate().hz().sqrt();
        let said = variances?.into_iter().fold(0.0, f64::max).sqrt();
        let text = format!(
            "{sensor}: the messages say {said:.2e} {} a sample, the log has {has:.2e} at rest",
            sensor.unit()
        );
        let times = (said / has).max(has / said);
        Some(if times <= AGREES {
            Finding::note("covariance", text)
        } else {
            Finding::warning(
                "covariance",
                format!("{text}: {times:.0} times {}", if said > has { "less" } else { "more" }),
                "whoever believes the messages weighs this sensor wrongly: `dpn noise LOG --into FILE.mcap` writes them anew, or set them in the driver",
            )
        })
    };
    let ([gyro, accel], [accel_noise, gyro_noise]) = (log.variances, at_rest);
    [(Sensor::Accel, accel, accel_noise), (Sensor::Gyro, gyro, gyro_noise)]
        .into_iter()
        .filter_map(of)
        .collect()
}

#[cfg(test)]
mod tests {
    use crate::doctor::examine_log;
    use crate::doctor::values::tests::level;
    use dpn_core::ImuRecording;
    use dpn_logs::{Kind, Log};

    #[test]
    fn covariances_are_held_against_the_log_at_rest() {
        let mut log = Log::sound(Kind::Mcap, ImuRecording::new(level(20)).unwrap());
        // The log has .0024 and .028 a sample.
        log.variances = [Some([0.0024f64.powi(2); 3]), Some([0.01; 3])];
        let found = examine_log(&log).unwrap().findings;
        let of: Vec<_> = found.iter().filter(|f| f.about == "covariance").collect();
        assert!(
            of[0].text.starts_with("accel: the messages say 1.00e-1 m/s^2 a sample, the log has 2."),
            "{of:?}"
        );
        assert!(of[0].text.ends_with("4 times less") && of[0].warns() && !of[1].warns(), "{of:?}");
    }
}
