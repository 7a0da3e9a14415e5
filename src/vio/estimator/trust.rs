//! Whether a run that went to its end is to be believed.
//!
//! Where camera and inertial sensors contradict each other (a clock, a focal length, a scale, a sign), the window finds a path between the two, and says nothing: its
//! residuals do. Of 33 faults injected into real recordings that more than doubled the error, 27 show in what is asked here, and none of the good runs does.

use super::report::RunReport;
use super::suspects::Suspect;
use super::update::RestartReason;
use crate::components::Levels;
use dpn_core::GRAVITY;
use dpn_core::imu::Sensor;
use serde::Serialize;
use thiserror::Error;

/// Mean square of the whitened inertial residual above which samples and tracks contradict each other: a run told half the noise there is has 3.
const MOST_WHITENED: f64 = 3.5;
/// More outliers a pose are not mistakes of following alone; good runs have 0.3.
const MOST_OUTLIERS: f64 = 1.0;
/// Levels of samples beyond this are no sensor's noise: good runs end at up to 7 and 13.
const MOST_LEVEL: f64 = 20.0;
/// More that an accelerometer reads of gravity than there is, or less, is a scale or a bias that nobody took out \[m/s^2\]; good runs have up to 0.25.
const MOST_VERTICAL_BIAS: f64 = 0.5;
/// Poses for longer on a clock that is found to be wrong then are told \[s\].
const LONGEST_ON_WRONG_CLOCK_S: f64 = 1.0;
/// Fewest poses whose means are judged.
const FEWEST_POSES: usize = 30;

/// A reason not to believe a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Error)]
#[serde(rename_all = "snake_case", tag = "doubt")]
pub enum Doubt {
    /// Samples and tracks contradict each other.
    #[error(
        "inertial residuals have {mean_square:.1} times the variance they should have ({MOST_WHITENED} at most in a good run)"
    )]
    Whitened {
        /// Mean square, whitened.
        mean_square: f64,
    },
    /// Tracks do not fit.
    #[error("{a_pose:.1} tracks a pose were outliers ({MOST_OUTLIERS} at most in a good run)")]
    Outliers {
        /// How many a pose.
        a_pose: f64,
    },
    /// The estimate was given up.
    #[error("it was given up and began anew {times} time(s)")]
    Restarted {
        /// How often.
        times: usize,
    },
    /// Poses rest on a clock that was found to be wrong only then.
    #[error("{seconds:.1} s of poses were made before the camera's clock was found to be off by {:.0} ms more than was known; --time-offset tells it from the start", 1e3 * off_s)]
    WrongClock {
        /// For how long \[s\].
        seconds: f64,
        /// By how much \[s\].
        off_s: f64,
    },
    /// The accelerometer reads another gravity.
    #[error(
        "the accelerometer reads {:.2} m/s^2 along the vertical where gravity is {GRAVITY}: its scale (mended by --accel-scale {:.3}) or its bias is off",
        GRAVITY + bias, GRAVITY / (GRAVITY + bias)
    )]
    Gravity {
        /// Mean of its bias along the vertical \[m/s^2\].
        bias: f64,
    },
    /// The calibration is off where turns do not show it, or by less than they show.
    #[error("{suspect}")]
    Calibration {
        /// What of it.
        suspect: Suspect,
    },
    /// The noise learned is no sensor's.
    #[error(
        "the noise learned of the {}'s {axis} is {level:.0} times what was given ({MOST_LEVEL} at most in a good run)",
        if *sensor == Sensor::Gyro { "gyroscope" } else { "accelerometer" }
    )]
    Levels {
        /// The largest level of an axis of the samples.
        level: f64,
        /// Whose it is.
        sensor: Sensor,
        /// And of which axis.
        axis: char,
    },
}

impl Doubt {
    /// The largest level, where it is no sensor's noise.
    fn of_levels(levels: &Levels) -> Option<Self> {
        let of_axes = [Sensor::Accel, Sensor::Gyro]
            .into_iter()
            .flat_map(|sensor| ['x', 'y', 'z'].map(|axis| (sensor, axis)));
        let (level, (sensor, axis)) =
            levels.inertial.0.into_iter().zip(of_axes).max_by(|a, b| a.0.total_cmp(&b.0))?;
        (level > MOST_LEVEL).then_some(Self::Levels { level, sensor, axis })
    }

    /// Whether it says itself what is to be mended; the others only say that something is.
    fn names_a_cause(&self) -> bool {
        matches!(self, Self::WrongClock { .. } | Self::Gravity { .. } | Self::Calibration { .. })
    }
}

/// What speaks against a run; `levels` are those learned last.
pub fn doubts(report: &RunReport, levels: Option<&Levels>) -> Vec<Doubt> {
    // Whoever finds the clock, or passes a gap, has begun anew for a reason that is no contradiction.
    let times = report.restarts.iter().filter(|(_, reason)| reason.is_contradiction()).count();
    let restarted = (times > 0).then_some(Doubt::Restarted { times });
    if report.poses < FEWEST_POSES {
        return restarted.into_iter().collect();
    }
    let mut found = Vec::new();
    let mean_square = report.whitened_mean().filter(|mean_square| *mean_square > MOST_WHITENED);
    found.extend(mean_square.map(|mean_square| Doubt::Whitened { mean_square }));
    let a_pose = report.outliers as f64 / report.poses as f64;
    found.extend((a_pose > MOST_OUTLIERS).then_some(Doubt::Outliers { a_pose }));
    found.extend(restarted);
    let on_wrong_clock = report.restarts.iter().find_map(|(t, reason)| {
        let RestartReason::CameraClock { seconds: off_s } = *reason else { return None };
        let seconds = t.seconds_since(report.initialised?);
        (seconds > LONGEST_ON_WRONG_CLOCK_S).then_some(Doubt::WrongClock { seconds, off_s })
    });
    found.extend(on_wrong_clock);
    let bias = report.vertical_bias_mean().filter(|bias| bias.abs() > MOST_VERTICAL_BIAS);
    found.extend(bias.map(|bias| Doubt::Gravity { bias }));
    found.extend(report.suspect.map(|suspect| Doubt::Calibration { suspect }));
    found.extend(levels.and_then(Doubt::of_levels));
    found
}

/// Doubts as a warning, with the cause where one is known; `None` where there are none.
pub fn doubts_warning(doubts: &[Doubt], cause_is_known: bool) -> Option<String> {
    if doubts.is_empty() {
        return None;
    }
    let reasons: Vec<String> = doubts.iter().map(ToString::to_string).collect();
    let cause = if doubts.iter().any(Doubt::names_a_cause) {
        ""
    } else if cause_is_known {
        "; another warning names a cause"
    } else if doubts.iter().any(|doubt| matches!(doubt, Doubt::Levels { sensor: Sensor::Gyro, .. })) {
        "; the images turn otherwise than the gyroscope by more than its noise, though on the whole alike: look at the lens's calibration, at a rolling shutter, at exposures \
         that change (an image's time is the middle of its exposure), at blur, at stamps of arrival"
    } else {
        "; camera and gyroscope turn together, so look at what turns do not show: the accelerometer's scale and signs (`dpn check`), the calibration's principal \
         point and distance from camera to IMU, images that repeat, blur or show little"
    };
    Some(format!("this run is not to be trusted: {}{cause}", reasons.join("; ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::components::Levels;
    use crate::preint::NoiseLevels;
    use dpn_core::Stamp;

    #[test]
    fn each_doubt_is_named_and_what_a_sensor_left_out_is_none() {
        let t = Stamp::from_ns(5);
        let good = RunReport { poses: 100, outliers: 30, whitened: (900.0, 900), ..RunReport::default() };
        let levels = |level| Levels {
            inertial: NoiseLevels([level, 1.0, 1.0, 1.0, 1.0, 1.0, 9e3, 9e3]),
            pixel: 1.0,
            unsure: [0.1; 8],
        };
        assert_eq!(doubts(&good, Some(&levels(7.0))), []);
        assert_eq!(doubts_warning(&[], false), None);
        let gap = vec![
            (t, RestartReason::ImuGap { seconds: 0.2 }),
            (t, RestartReason::CameraClock { seconds: 0.1 }),
        ];
        let late = RunReport { restarts: gap, initialised: Some(Stamp::from_ns(0)), ..good.clone() };
        assert_eq!(doubts(&late, None), []);
        let late = RunReport { initialised: Some(t.plus_seconds(-14.0)), ..late };
        assert_eq!(doubts(&late, None), [Doubt::WrongClock { seconds: 14.0, off_s: 0.1 }]);
        // What names its cause needs no other hint.
        assert!(!doubts_warning(&doubts(&late, None), false).unwrap().contains("`dpn check`"));
        let bad = RunReport {
            outliers: 250,
            whitened: (4500.0, 900),
            restarts: vec![(t, RestartReason::Jump { distance: 2.0 })],
            vertical_bias: -98.1,
            suspect: Some(Suspect::Place { off: [0.0, 0.12, -0.16] }),
            ..good
        };
        let found = doubts(&bad, Some(&levels(34.0)));
        let expected = [
            Doubt::Whitened { mean_square: 5.0 },
            Doubt::Outliers { a_pose: 2.5 },
            Doubt::Restarted { times: 1 },
            Doubt::Gravity { bias: -0.981 },
            Doubt::Calibration { suspect: Suspect::Place { off: [0.0, 0.12, -0.16] } },
            Doubt::Levels { level: 34.0, sensor: Sensor::Accel, axis: 'x' },
        ];
        assert_eq!(found, expected);
        let said = doubts_warning(&found, false).unwrap();
        assert!(
            said.contains("5.0 times the variance")
                && said.contains("--accel-scale 1.111")
                && said.contains("the camera 0.20 m elsewhere on the body, by (0.00, 0.12, -0.16) m"),
            "{said}"
        );
        // Few poses have no means, and were given up all the same.
        let few = RunReport { poses: 20, ..bad };
        assert_eq!(doubts(&few, None), [Doubt::Restarted { times: 1 }]);
        let unnamed = &found[..1];
        assert!(doubts_warning(unnamed, true).unwrap().ends_with("another warning names a cause"));
        assert!(doubts_warning(unnamed, false).unwrap().contains("`dpn check`"));
    }
}
