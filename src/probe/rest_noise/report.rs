//! What a rest says, for people.

use super::{AxisNoise, LowPass, RestNoise, SensorNoise};
use crate::finding::Finding;
use crate::text::{aligned, listed};
use dpn_core::noise::Interval;
use std::fmt::Write;

impl RestNoise {
    /// A table of densities, then what else shows.
    pub fn page(&self) -> String {
        let head = format!("at rest, {:.0} to {:.0} s, by the spectrum", self.from_s, self.to_s);
        let mut rows = vec![[&head, "density (95 %)", "x", "y", "z"].map(str::to_owned)];
        for sensor in self.sensors.iter().filter(|sensor| !sensor.silent) {
            let unit = format!("{}/sqrt(Hz)", sensor.sensor.unit());
            let [x, y, z] =
                sensor.axes.each_ref().map(|axis| axis.as_ref().map_or("constant".to_owned(), words));
            rows.push([format!("  {}", sensor.sensor), unit, x, y, z]);
        }
        let mut text = aligned(&rows);
        for line in self.sensors.iter().flat_map(SensorNoise::notes) {
            let _ = writeln!(text, "  {line}");
        }
        if self.bridged > 0 {
            let _ = writeln!(text, "  {} lost samples are bridged by straight lines", self.bridged);
        }
        text
    }
}

impl RestNoise {
    /// What stands between the noise and the log, a line each: low passes, held values, steps.
    pub fn between(&self) -> Vec<String> {
        let of = |sensor: &SensorNoise| [sensor.held_words(), sensor.filter_words(), sensor.step_words()];
        self.sensors.iter().flat_map(of).flatten().collect()
    }

    /// What an estimator should know of: low passes, and values that are held.
    pub fn findings(&self) -> Vec<Finding> {
        let mut findings = Vec::new();
        for sensor in &self.sensors {
            if let Some(text) = sensor.held_words() {
                let remedy = "log each sensor at its own rate; noise per row is wrong like this, and every value counts more than once";
                findings.push(Finding::warning("held", text, remedy));
            }
            findings.extend(sensor.filter_words().map(|text| Finding::note("low-pass", text)));
        }
        findings
    }
}

fn words(axis: &AxisNoise) -> String {
    match axis.density {
        Some(Interval { value, low, high }) => format!("{value:.2e} ({low:.2e} to {high:.2e})"),
        None => format!("not known, below {:.2e}", axis.below),
    }
}

impl SensorNoise {
    fn held_words(&self) -> Option<String> {
        let held = self.held?;
        Some(format!(
            "{}: values of {:.0} Hz are held on rows of {:.0} Hz; each counts once",
            self.sensor, held.values_hz, held.rows_hz
        ))
    }

    fn filter_words(&self) -> Option<String> {
        let filter = self.filter()?;
        let Interval { value, low, high } = filter.corner_hz;
        let what = match filter.low_pass {
            LowPass::MovingMean { samples } => format!("a moving mean of {samples} samples"),
            other => format!("a low pass, {other}, corner {value:.1} Hz ({low:.1} to {high:.1})"),
        };
        Some(format!("{}: behind {what}, on all axes", self.sensor))
    }

    fn step_words(&self) -> Option<String> {
        let step = self.coarse_step()?;
        Some(format!(
            "{}: values in steps of {step:.2e} {}, whose rounding is not the sensor's noise",
            self.sensor,
            self.sensor.unit()
        ))
    }

    /// Its held values, low pass and lines; a line each.
    fn notes(&self) -> Vec<String> {
        let mut notes: Vec<String> = self.held_words().into_iter().chain(self.filter_words()).collect();
        let named =
            || self.axes.iter().zip(["x", "y", "z"]).filter_map(|(axis, name)| Some((axis.as_ref()?, name)));
        let unseen: Vec<&str> =
            named().filter(|(axis, _)| axis.density.is_none()).map(|(_, name)| name).collect();
        if !unseen.is_empty() {
            notes.push(format!(
                "{} {}: no plateau between drift and corner; rest for longer, or with a wider filter",
                self.sensor,
                unseen.join(", ")
            ));
        }
        let of = |lines: &[f64]| listed(&lines.iter().map(|hz| format!("{hz:.1}")).collect::<Vec<_>>());
        let lines: Vec<String> = named()
            .filter(|(axis, _)| !axis.lines.is_empty())
            .map(|(axis, name)| format!("{name} {}", of(&axis.lines)))
            .collect();
        if !lines.is_empty() {
            notes.push(format!("{}: lines are left out [Hz]: {}", self.sensor, lines.join("; ")));
        }
        notes
    }
}

#[cfg(test)]
mod tests {
    use crate::phases::phases;
    use crate::rest_noise::{LowPass, RestNoise};
    use dpn_core::random::Stream;
    use dpn_core::{ImuRecording, ImuSample, Stamp};
    use rand::Rng;
    use rand_distr::StandardNormal;
    use std::f64::consts::{PI, SQRT_2};

    /// White noise of 1 a sample behind two poles at 42 Hz of 200 Hz.
    fn behind_42_hz(axis: u64, count: usize) -> Vec<f64> {
        let mut rng = Stream::new(5).named("low-pass").index(axis).rng();
        let k = (PI * 42.0 / 200.0).tan();
        let g = 1.0 / (1.0 + k * SQRT_2 + k * k);
        let (mut x, mut y) = ([0.0; 2], [0.0; 2]);
        let mut next = || {
            let now: f64 = rng.sample(StandardNormal);
            let out = g
                * (k * k * (now + 2.0 * x[0] + x[1])
                    - 2.0 * (k * k - 1.0) * y[0]
                    - (1.0 - k * SQRT_2 + k * k) * y[1]);
            (x, y) = ([now, x[0]], [out, y[0]]);
            out
        };
        (0..count + 200).map(|_| next()).skip(200).collect()
    }

    /// At 200 Hz; accelerometer .05, gyroscope .004 a sample before the filter, the accelerometer's values on `rows` rows each.
    fn log(seconds: usize, rows: usize) -> ImuRecording {
        let axes: Vec<Vec<f64>> = (0..6).map(|axis| behind_42_hz(axis, 200 * seconds)).collect();
        let sample = |i: usize| ImuSample {
            t: Stamp::from_ns(i as i64 * 5_000_000),
            accel: [0, 1, 2].map(|axis| 0.05 * axes[axis][i / rows] + if axis == 2 { 9.8 } else { 0.0 }),
            gyro: [3, 4, 5].map(|axis| 0.004 * axes[axis][i]),
        };
        ImuRecording::new((0..200 * seconds).map(sample).collect()).unwrap()
    }

    fn found(log: &ImuRecording) -> RestNoise {
        RestNoise::of(log, &phases(log).unwrap()).unwrap().unwrap()
    }

    #[test]
    fn the_density_below_a_low_pass_is_found_with_its_corner() {
        let found = found(&log(40, 1));
        for (sensor, sigma) in found.sensors.iter().zip([0.05, 0.004]) {
            let truth = sigma / 200.0_f64.sqrt();
            for axis in sensor.axes.iter().flatten() {
                let density = axis.density.unwrap();
                assert!(
                    (density.low..density.high).contains(&truth)
                        || (density.value / truth - 1.0).abs() < 0.06,
                    "{axis:?}"
                );
                assert!(density.width() < 1.2, "{density:?}");
                let filter = axis.filter.unwrap();
                assert!(matches!(filter.low_pass, LowPass::SecondOrder { .. }), "{filter:?}");
                assert!((filter.corner_hz.value / 42.0 - 1.0).abs() < 0.05, "{filter:?}");
            }
        }
        let page = found.page();
        assert!(page.contains("behind a low pass, 2nd order, corner 4"), "{page}");
        assert_eq!(found.findings().len(), 2);
    }

    #[test]
    fn values_held_on_several_rows_count_once() {
        let found = found(&log(40, 2));
        let held = found.sensors[0].held.unwrap();
        assert!((held.values_hz - 100.0).abs() < 0.1 && found.sensors[1].held.is_none(), "{held:?}");
        // 100 values a second of the same deviation: the density is larger by the square root of two.
        let density = found.sensors[0].axes[0].as_ref().unwrap().density.unwrap();
        assert!((density.value / (0.05 / 10.0) - 1.0).abs() < 0.1, "{density:?}");
        assert!(found.findings().iter().any(|f| f.about == "held"));
    }

    #[test]
    fn steps_so_coarse_that_one_axis_alone_leaves_them_now_and_then_are_not_held_values() {
        // Degrees a second in whole numbers, as flight controllers write them.
        let step = std::f64::consts::PI / 180.0;
        let mut samples = log(40, 1).samples().to_vec();
        for s in &mut samples {
            s.gyro = [s.gyro[0] + 0.006, s.gyro[1] - 0.005, s.gyro[2]].map(|v| (v / step).round() * step);
        }
        let same = samples.windows(2).filter(|w| w[0].gyro == w[1].gyro).count();
        assert!(same > samples.len() / 2, "{same}");
        let coarse = found(&ImuRecording::new(samples).unwrap());
        assert!(coarse.sensors[1].held.is_none(), "{:?}", coarse.sensors[1].held);
    }

    #[test]
    fn knocks_at_a_rest_are_none_of_its_noise() {
        let mut samples = log(40, 1).samples().to_vec();
        for (at, by) in [(2000, 2.0), (2004, -1.5), (6500, 1.0), (6503, -1.0)] {
            samples[at].accel[1] += by;
            samples[at].gyro[2] += 0.2 * by;
        }
        let knocked = found(&ImuRecording::new(samples).unwrap());
        assert!(
            knocked.from_s > 10.0 && knocked.to_s < 32.5 && knocked.to_s - knocked.from_s > 21.0,
            "{knocked:?}"
        );
        for (sensor, sigma) in knocked.sensors.iter().zip([0.05, 0.004]) {
            for axis in sensor.axes.iter().flatten() {
                let value = axis.density.unwrap().value;
                assert!((value / (sigma / 200.0_f64.sqrt()) - 1.0).abs() < 0.12, "{axis:?}");
            }
        }
    }

    #[test]
    fn of_a_rest_longer_than_is_looked_at_nothing_is_lost() {
        let long = found(&log(1400, 1));
        assert!(long.to_s - long.from_s < 1320.0 && long.bridged == 0, "{} {}", long.to_s, long.bridged);
    }

    #[test]
    fn a_second_of_rest_says_nothing() {
        let log = log(3, 1);
        assert_eq!(RestNoise::of(&log, &phases(&log).unwrap()).unwrap(), None);
    }
}
