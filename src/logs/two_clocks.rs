//! Two sensors of one log whose stamps are of two clocks: told by when their messages arrived, and brought to the gyroscope's.

use dpn_core::Stamp;

/// Clocks whose rates differ by more are two; arrival jitters by some ms over the seconds of a log.
const APART: f64 = 0.03;
/// So do those that are off by more than messages wait \[s\],
const OFF_S: f64 = 1.0;
/// and by more than this share of the log, in a queue that was emptied at its end.
const OFF_SHARE: f64 = 0.5;
/// Logs that are shorter tell nothing \[s\].
const LEAST_S: f64 = 0.2;

/// The accelerometer's clock beside the gyroscope's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TwoClocks {
    /// Seconds of the accelerometer's in one of the gyroscope's.
    factor: f64,
    /// The same instant on the accelerometer's and on the gyroscope's \[ns\].
    same: [i64; 2],
}

impl TwoClocks {
    /// By stamp and time of arrival \[ns\] of the first and the last sample of each; none where both are on one clock.
    pub(crate) fn of(gyro: [[i64; 2]; 2], accel: [[i64; 2]; 2]) -> Option<Self> {
        let between = |ends: [[i64; 2]; 2], which: usize| {
            ends[1][which].checked_sub(ends[0][which]).map(|ns| ns as f64 * 1e-9).filter(|s| *s > LEAST_S)
        };
        let rate = |ends| Some(between(ends, 0)? / between(ends, 1)?);
        let (gyro_rate, accel_rate) = (rate(gyro)?, rate(accel)?);
        let factor = accel_rate / gyro_rate;
        // When the accelerometer's first sample arrived, the gyroscope's clock said:
        let since_s = accel[0][1].checked_sub(gyro[0][1])? as f64 * 1e-9 * gyro_rate;
        let gyro_ns = Stamp::from_ns(gyro[0][0]).plus_seconds(since_s).ns();
        let off_s = accel[0][0].saturating_sub(gyro_ns) as f64 * 1e-9;
        let is_off = off_s.abs() > OFF_S.max(OFF_SHARE * between(gyro, 0)?);
        ((factor - 1.0).abs() > APART || is_off).then_some(Self { factor, same: [accel[0][0], gyro_ns] })
    }

    /// A stamp of the accelerometer's on the gyroscope's clock.
    pub(crate) fn at(self, t: Stamp) -> Stamp {
        let since_s = t.seconds_since(Stamp::from_ns(self.same[0])) / self.factor;
        Stamp::from_ns(self.same[1]).plus_seconds(since_s)
    }

    pub(crate) fn words(self, gyro: &str, accel: &str) -> String {
        let Self { factor, same: [own, other] } = self;
        let times = own as f64 / other as f64;
        format!(
            "two clocks: the stamps of {accel} are {times:.3} times those of {gyro} at one instant, and run {factor:.3} times as fast; brought together by when \
             messages arrived, which is right to some milliseconds"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    proptest::proptest! {
        /// A clock of any rate and begin is found, and one clock is left alone whatever its delays.
        #[test]
        fn a_second_clock_is_brought_to_the_first(
            factor in proptest::prop_oneof![0.2..0.95f64, 1.05..5.0f64],
            begin in -1_000_000_000_000i64..1_000_000_000_000,
            late in 0..3_000_000i64,
        ) {
            let gyro = [[0, 5_000_000], [10_000_000_000, 10_005_000_000]];
            let second = |t: i64| begin + (t as f64 * factor) as i64;
            let accel = [[second(2_000_000), 7_000_000], [second(9_990_000_000), 9_995_000_000 + late]];
            let clock = TwoClocks::of(gyro, accel).unwrap();
            for t in [2_000_000, 5_000_000_000, 9_990_000_000] {
                let found = clock.at(Stamp::from_ns(second(t))).ns();
                proptest::prop_assert!((found - t).abs() < 4_000_000, "{} for {}", found, t);
            }
            let one = [[2_000_000, 7_000_000 + late], [9_990_000_000, 9_995_000_000]];
            proptest::prop_assert_eq!(TwoClocks::of(gyro, one), None);
        }
    }

    #[test]
    fn a_bag_with_two_clocks_is_joined_and_says_so() {
        use crate::fields::Encoding;
        use crate::messages::Messages;
        use crate::topics::Topics;
        use crate::{Kind, LogOptions};
        use dpn_core::{Recorded, Samples};
        let message = |ns: i64, gyro: f64, accel: f64| {
            let mut bytes = Vec::new();
            for word in [0, (ns / 1_000_000_000) as u32, (ns % 1_000_000_000) as u32, 0] {
                bytes.extend(word.to_le_bytes());
            }
            for k in 0..37 {
                let value = match k {
                    13..16 => gyro,
                    25..28 => accel,
                    _ => 0.0,
                };
                bytes.extend(value.to_le_bytes());
            }
            bytes
        };
        let mut topics = Topics::new(&LogOptions::default());
        for (number, name) in [(0, "/camera/gyro/sample"), (1, "/camera/accel/sample")] {
            topics.declare(number, name, "sensor_msgs/Imu", Ok(Encoding::Ros1));
        }
        let start = 1_000_000_000_000;
        for i in 0..800i64 {
            let t = start + i * 5_000_000;
            topics.message(0, t + 1_000_000, &message(t, 0.1, 0.0));
            topics.message(1, t + 2_000_000, &message(t / 2, 0.0, i as f64 + 1.0));
        }
        let chosen = topics.choose(std::path::Path::new("a.bag"), None).unwrap();
        let log = chosen
            .log(std::path::Path::new("a.bag"), Kind::Rosbag1, "message", None, &LogOptions::default())
            .unwrap();
        assert!(log.recording.len() > 790 && (log.recording.rate().hz() - 200.0).abs() < 1e-6);
        let off = |i: usize| log.recording.at(i).unwrap().accel[0] - (i as f64 + 1.0);
        assert!(off(5).abs() < 1.0 && off(700).abs() < 1.0, "{} {}", off(5), off(700));
        let words = log.clocks.unwrap();
        let start = "two clocks: the stamps of /camera/accel/sample are 0.500 times those of /camera/gyro/sample at one instant, and run 0.500 times as fast";
        assert!(words.starts_with(start), "{words}");
    }
}
