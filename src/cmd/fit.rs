//! `dpn fit`: what `dpn noise --against` says of scale, misalignment and bias as a calibration, and the samples under it.

use super::{apart, log};
use crate::args::FitArgs;
use crate::ui::{out, outln, results, warn};
use anyhow::{Context, Result};
use dpn_core::{ImuRecording, ImuSample, Recorded, Sensor};
use dpn_io::asl::write_imu_rows;
use dpn_io::{atomic_write, read_poses};
use dpn_truth::{SensorAgainst, against};
use nalgebra::{Matrix3, Vector3};
use serde_json::json;

/// Share of a log beside which a trajectory lies, below which there is a word.
const LEAST_SHARE: f64 = 0.5;

pub(crate) fn run(args: &FitArgs) -> Result<()> {
    apart::folder(
        "--out",
        &args.out,
        &["calibration.json", "calibrated.csv"],
        &[&args.log.path, &args.against],
    )?;
    // A trajectory that cannot be read should not cost a log.
    let poses = read_poses(&args.against)?;
    let recording = log::read(&args.log)?.recording.held()?;
    let places = || format!("{} against {}", args.log.path.display(), args.against.display());
    let found = against(&recording, &poses).with_context(places)?;
    warn(&found.report.warnings);
    let share = found.seconds / recording.length_s();
    if share < LEAST_SHARE {
        warn([format!(
            "the trajectory lies beside {:.0} % of the log: matrix and bias are those of that part, and the bias of the rest may be another",
            100.0 * share
        )]);
    }
    let calibrations = found.sensors.each_ref().map(Calibration::of);
    let [accel, gyro] = &calibrations;
    let apply = |s: &ImuSample| ImuSample { t: s.t, accel: accel.apply(s.accel), gyro: gyro.apply(s.gyro) };
    let calibrated = ImuRecording::new(recording.samples().iter().map(apply).collect())?;
    let all = json!({
        "log": args.log.path, "against": args.against, "calibration": calibrations.each_ref().map(Calibration::json),
        "truth_follows_gyroscope": found.follows,
    });
    let samples = args.out.join("calibrated.csv");
    atomic_write(&samples, |out| write_imu_rows(out, &calibrated))?;
    if results(args.out.join("calibration.json"), &all, args.json)? {
        return Ok(());
    }
    if found.follows {
        warn([
            "the trajectory was made from this gyroscope: its bias is told, its scale and misalignment are the trajectory's own",
        ]);
    }
    calibrations.iter().try_for_each(|calibration| out!("{}", calibration.page()))?;
    Ok(outln!("samples:  {}", samples.display())?)
}

/// One sensor's: `matrix * reading - bias` is what it should have read.
struct Calibration<'a> {
    of: &'a SensorAgainst,
    matrix: Matrix3<f64>,
}

impl<'a> Calibration<'a> {
    /// Numbers that the motion does not tell are those of a perfect sensor.
    fn of(of: &'a SensorAgainst) -> Self {
        let off = Matrix3::from_fn(|row, column| Self::at(of, row, column).map_or(0.0, |[value, _]| value));
        let matrix =
            (Matrix3::identity() + off).try_inverse().expect("scales within some per cent have an inverse");
        Self { of, matrix }
    }

    /// What of the true axis `column` is too much in the reading of `row`, and its deviation.
    fn at(of: &SensorAgainst, row: usize, column: usize) -> Option<[f64; 2]> {
        let told = match row == column {
            true => of.scale[row],
            false => of.misalignment[row][column - usize::from(column > row)],
        };
        told.map(|told| [told.value, told.std])
    }

    fn apply(&self, reading: [f64; 3]) -> [f64; 3] {
        (self.matrix * Vector3::from(reading) - Vector3::from(self.of.bias.value)).into()
    }

    fn json(&self) -> serde_json::Value {
        let rows = |number: &dyn Fn(usize, usize) -> Option<f64>| {
            [0, 1, 2].map(|row| [0, 1, 2].map(|column| number(row, column)))
        };
        json!({
            "sensor": self.of.sensor,
            "matrix": rows(&|row, column| Some(self.matrix[(row, column)])),
            "matrix_std": rows(&|row, column| Self::at(self.of, row, column).map(|[_, std]| std)),
            "bias": self.of.bias,
        })
    }

    fn page(&self) -> String {
        let number =
            |row, column| (self.matrix[(row, column)], Self::at(self.of, row, column).map(|[_, std]| std));
        let bias = &self.of.bias;
        matrix_page(self.of.sensor, &number, &[0, 1, 2].map(|row| (bias.value[row], bias.std[row])))
    }
}

/// A calibration by rows, each number with its deviation where that is known.
pub(super) fn matrix_page(
    sensor: Sensor,
    number: &dyn Fn(usize, usize) -> (f64, Option<f64>),
    bias: &[(f64, f64); 3],
) -> String {
    let mut text = format!(
        "{sensor}: matrix * reading - bias, 95 %; a number that the motion does not tell has no interval\n"
    );
    for (row, (bias, bias_std)) in bias.iter().enumerate() {
        let numbers = [0, 1, 2].map(|column| match number(row, column) {
            (value, Some(std)) => format!("{value:8.5} +- {:.5}", 1.96 * std),
            (value, None) => format!("{value:8.5}           "),
        });
        let unit = sensor.unit();
        text += &format!("  {}   bias {bias:.5} +- {:.5} {unit}\n", numbers.join("  "), 1.96 * bias_std);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::noise::Interval;
    use dpn_truth::{Estimated, Found, Known};

    #[test]
    fn a_reading_made_by_the_sensors_faults_is_taken_back() {
        let told = |value: f64| Some(Estimated { value, std: 1e-3 });
        let found = Found { density: Interval { value: 1.0, low: 1.0, high: 1.0 }, known: Known::Figure };
        let of = SensorAgainst {
            sensor: Sensor::Gyro,
            white: [found; 3],
            walk: found,
            bias: Estimated { value: [0.01, -0.02, 0.03], std: [1e-4; 3] },
            scale: [told(0.02), told(-0.05), None],
            misalignment: [[told(0.01), None], [told(-0.004), told(0.006)], [None, told(0.003)]],
        };
        let calibration = Calibration::of(&of);
        let wrong = Matrix3::new(1.02, 0.01, 0.0, -0.004, 0.95, 0.006, 0.0, 0.003, 1.0);
        let truth = Vector3::new(0.3, -1.2, 2.0);
        let reading = wrong * (truth + Vector3::from(of.bias.value));
        assert!((Vector3::from(calibration.apply(reading.into())) - truth).norm() < 1e-12);
        assert!(calibration.page().contains("bias -0.02000 +- 0.00020 rad/s"), "{}", calibration.page());
    }
}
