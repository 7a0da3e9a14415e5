//! What imu_utils leaves of a log at rest: below `Acc` and `Gyr`, for the mean of the axes and for each, `*_n`, which is the deviation of one sample, and `*_w`,
//! a bias instability, from which no walk follows.

use super::calibration::{Given, NoiseCalibration};
use super::error::FormatError;
use super::format::Format;
use super::key_fault::KeyFault;
use super::keyed;
use super::step::{Remark, Step};
use super::tree::Tree;
use dpn_core::noise::{Axes, Figure, Meaning};
use std::path::Path;

/// A sensor's block, its key, and the figure.
const SENSORS: [(&str, &str, Figure); 2] =
    [("Acc", "acc_n", Figure::AccelWhite), ("Gyr", "gyr_n", Figure::GyroWhite)];

/// Reads them; none where the file has no such blocks.
///
/// # Errors
/// Numbers that no noise has; no rate.
pub(super) fn read(tree: &Tree, path: &Path, given: &Given) -> Result<Option<NoiseCalibration>, FormatError> {
    let blocks = tree.blocks();
    let entry = |above: &str, axis: &str, key: &str| {
        let block = blocks.iter().find(|block| block.path == format!("{above}.{axis}"))?;
        block.get(key)
    };
    if SENSORS.iter().any(|(above, key, _)| entry(above, "avg-axis", key).is_none()) {
        return Ok(None);
    }
    let rate = given.rate.ok_or(FormatError::NeedsRate { format: Format::Vins })?;
    let mut source = NoiseCalibration::new(Format::Vins);
    source.figures.rate = Some(rate);
    for (above, key, figure) in SENSORS {
        let mean = entry(above, "avg-axis", key).expect("it was looked for");
        let axes: Vec<_> =
            ["x-axis", "y-axis", "z-axis"].into_iter().filter_map(|axis| entry(above, axis, key)).collect();
        let number = |entry| {
            Ok::<_, FormatError>(keyed::axes(entry, path, false, &mut Vec::new())?.map(Axes::largest))
        };
        let each = axes.into_iter().map(number).collect::<Result<Option<Vec<f64>>, _>>()?;
        let values = match each.map(<[f64; 3]>::try_from) {
            Some(Ok(each)) => Axes::Each(each),
            _ => Axes::Same(number(mean)?.expect("a zero was refused")),
        };
        let bad = |bad: dpn_core::noise::units::BadNoise| {
            FormatError::key(path, mean.line, key, KeyFault::NotPositive { value: bad.0 })
        };
        source.figures.set(figure, Meaning::SampleStd, values, rate).map_err(bad)?;
        source.steps.push(Step::to_density(key, figure, Meaning::SampleStd, values, &source.figures, rate));
    }
    source.remarks.push(Remark(
        "imu_utils: `acc_n`, `gyr_n` are deviations of one sample at --rate; `acc_w`, `gyr_w` are bias instabilities, and no walk follows from them: left out".to_owned(),
    ));
    Ok(Some(source))
}
