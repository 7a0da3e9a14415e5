//! The covariances of ROS's `sensor_msgs/Imu`, as `rostopic echo` and `ros2 topic echo` print a message: variances of one sample, nine
//! numbers row by row about x, y, z. All zeros say "not known", -1 in the first place says "this is not measured". No walks.

use super::calibration::{Given, NoiseCalibration, Zero};
use super::error::FormatError;
use super::format::Format;
use super::key_fault::KeyFault;
use super::keyed::{self, Line};
use super::layout::Key;
use super::number::number;
use super::step::{Remark, Step};
use super::tree::{Entry, Tree};
use dpn_core::noise::units::BadNoise;
use dpn_core::noise::{Axes, Figure, ImuFigures, Meaning};
use dpn_core::time::SampleRate;
use std::path::Path;

/// Accelerometer, gyroscope.
pub(super) const KEYS: [&str; 2] = ["linear_acceleration_covariance", "angular_velocity_covariance"];

const FIGURES: [Figure; 2] = [Figure::AccelWhite, Figure::GyroWhite];

pub(super) fn read(tree: &Tree, path: &Path, given: &Given) -> Result<NoiseCalibration, FormatError> {
    let mut source = NoiseCalibration::new(Format::Ros);
    source.figures.rate = given.rate;
    let missing = |lacking: Vec<usize>| FormatError::Missing {
        path: path.to_path_buf(),
        from: Format::Ros,
        missing: lacking.iter().map(|i| KEYS[*i].to_owned()).collect(),
        figures: lacking.iter().map(|i| FIGURES[*i]).collect(),
        nearest: keyed::slip(tree, KEYS.into_iter(), &KEYS),
        rather: None,
    };
    let Some((block, _)) = keyed::block(tree, &KEYS) else {
        return Err(missing(vec![0, 1]));
    };
    for (i, (name, figure)) in KEYS.into_iter().zip(FIGURES).enumerate() {
        let Some(entry) = block.get(name) else {
            if given.quantity(figure).is_none() {
                return Err(missing(vec![i]));
            }
            continue;
        };
        let Some(variances) = diagonal(entry, path, given.keep_zeros, &mut source.remarks)? else {
            source.zeros.push(Zero { figure, key: name.to_owned(), line: entry.line });
            continue;
        };
        let rate = given.rate.ok_or(FormatError::NeedsRate { format: Format::Ros })?;
        let bad =
            |bad: BadNoise| FormatError::key(path, entry.line, name, KeyFault::NotPositive { value: bad.0 });
        source.figures.set(figure, Meaning::SampleVariance, variances, rate).map_err(bad)?;
        source.steps.push(Step::to_density(
            name,
            figure,
            Meaning::SampleVariance,
            variances,
            &source.figures,
            rate,
        ));
    }
    Ok(source)
}

/// The diagonal of a message's covariance; none where it has a zero and `keep_zeros`.
fn diagonal(
    entry: &Entry,
    path: &Path,
    keep_zeros: bool,
    remarks: &mut Vec<Remark>,
) -> Result<Option<Axes<f64>>, FormatError> {
    let bad = |fault| FormatError::key(path, entry.line, &entry.key, fault);
    let says = |says| bad(KeyFault::NotInMessage { says });
    match entry.value.numbers().as_deref() {
        Some(nine) if nine.len() == 9 && nine.iter().all(|v| *v == 0.0) && !keep_zeros => {
            Err(says("is all zeros, which in a message means that the noise is not known"))
        }
        Some([first, ..]) if *first == -1.0 => {
            Err(says("begins with -1, which means that this is not measured"))
        }
        Some(nine) if nine.len() == 9 => keyed::axes(entry, path, keep_zeros, remarks),
        _ => {
            Err(bad(KeyFault::NotNumbers { found: entry.value.shown(), expected: "a list of nine numbers" }))
        }
    }
}

/// The keys as lines, for writing.
pub(super) fn lines(figures: &ImuFigures, rate: SampleRate) -> Vec<Line> {
    let meaning = Meaning::SampleVariance;
    (0..2)
        .map(|i| Line {
            key: Key { name: KEYS[1 - i], figure: FIGURES[1 - i], meaning },
            values: figures.get(FIGURES[1 - i], meaning, rate),
            note: None,
        })
        .collect()
}

pub(super) fn write(lines: &[Line], rate: &str) -> String {
    let mut text = format!("# sensor_msgs/Imu: variances of one sample at {rate} Hz, row by row\n");
    for Line { key, values, .. } in lines {
        let unit = key.meaning.unit(key.figure);
        match values {
            Some(values) => {
                let [x, y, z] = values.each().map(number);
                text.push_str(&format!(
                    "{}: [{x}, 0.0, 0.0, 0.0, {y}, 0.0, 0.0, 0.0, {z}]  # {unit}\n",
                    key.name
                ));
            }
            None => text.push_str(&format!("# {}: not known  # {unit}\n", key.name)),
        }
    }
    text
}
