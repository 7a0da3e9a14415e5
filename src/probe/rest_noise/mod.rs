//! The white noise of a sensor at rest, from its whole spectrum: plateau, low pass, steps of the converter and lines each for themselves.
//!
//! Nearly every consumer IMU has a low pass on. What is measured sample by sample then sees the filter, not the noise that an estimator's sums see; the Allan
//! deviation at a fixed averaging time sees either, by where the corner is. Here the density below the corner is fitted together with the filter, the drift below it
//! and the rounding above it (see [`response`](LowPass)), and where drift meets the corner, so that there is no plateau, the density is said to be not known.

mod density;
mod fit;
mod report;
pub(crate) mod stretch;

pub use density::{AxisNoise, Filter};
pub use dpn_core::signal::{LowPass, Made};
pub use stretch::Held;

use crate::doctor::values::step;
use crate::phases::Stretch;
use crate::rates::{self, Part};
use dpn_core::noise::Interval;
use dpn_core::{Recorded, SampleRate, Sensor};
use serde::Serialize;
use std::io;
use stretch::Rows;

/// The shortest rest that is looked at \[s\].
const LEAST_S: f64 = 4.0;
/// Corners that differ by less are one filter's.
const ALIKE: f64 = 1.3;
/// Power of rounding over that of the noise from which steps are coarse.
const COARSE: f64 = 0.2;
/// Values that tell a converter's step.
const TELLING: usize = 20_000;

/// One sensor at rest.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SensorNoise {
    /// The sensor.
    pub sensor: Sensor,
    /// Where its values stand on several rows each.
    pub held: Option<Held>,
    /// Whether all its values are zeros, as of a sensor that the log does not have.
    #[serde(skip)]
    pub silent: bool,
    /// x, y, z; none of an axis that never changes.
    pub axes: [Option<AxisNoise>; 3],
}

impl SensorNoise {
    /// Densities of the three axes; none where one is not known.
    pub fn densities(&self) -> Option<[Interval; 3]> {
        let mut all = self.axes.iter().map(|axis| axis.as_ref()?.density);
        Some([all.next()??, all.next()??, all.next()??])
    }

    /// The low pass that all its axes show alike: one is a sensor's, and what falls on one axis alone is what shakes it.
    pub fn filter(&self) -> Option<Filter> {
        let mut filters = self.axes.iter().flatten().map(|axis| axis.filter).collect::<Option<Vec<_>>>()?;
        filters.sort_by(|a, b| a.corner_hz.value.total_cmp(&b.corner_hz.value));
        let (first, last) = (filters.first()?, filters.last()?);
        let alike = filters.iter().all(|f| f.low_pass.order() == first.low_pass.order());
        (alike && last.corner_hz.value < ALIKE * first.corner_hz.value).then(|| filters[filters.len() / 2])
    }

    /// Whether a low pass, held values or coarse steps stand between its noise and the log.
    pub fn is_shaped(&self) -> bool {
        self.filter().is_some() || self.held.is_some() || self.coarse_step().is_some()
    }

    /// The converter's step, where its rounding is not small beside the noise of every axis.
    fn coarse_step(&self) -> Option<f64> {
        let coarse = |axis: &AxisNoise| axis.step.filter(|_| axis.rounding > COARSE);
        self.axes.iter().flatten().filter_map(coarse).reduce(f64::max)
    }

    /// What stands between the noise of an axis and the log, where anything does: a low pass, and values that are held; `rows` is the log's rate.
    pub fn shape(&self, axis: usize, rows: SampleRate) -> Option<Shape> {
        let filter = self.filter();
        if filter.is_none() && self.held.is_none() {
            return None;
        }
        let density = self.axes[axis].as_ref().and_then(|axis| axis.density).map_or(0.0, |d| d.value);
        let values = self.held.and_then(|held| SampleRate::from_hz(held.values_hz));
        Some(Shape { filter, values: values.unwrap_or(rows), held: self.held.is_some(), density })
    }
}

/// What white noise goes through before it is in a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    filter: Option<Filter>,
    /// Rate of values.
    values: SampleRate,
    held: bool,
    /// Density below the corner \[unit / sqrt(Hz)\]; 0 where it is not known.
    pub density: f64,
}

impl Shape {
    /// Share of the power at `hz` that comes through; 0 where a held value's images stand.
    pub fn gain(&self, hz: f64) -> f64 {
        let passed = self.filter.map_or(1.0, |filter| filter.gain(hz, self.values));
        if !self.held {
            return passed;
        }
        if hz > 0.45 * self.values.hz() {
            return 0.0;
        }
        let half_turns = std::f64::consts::PI * hz / self.values.hz();
        passed * if half_turns > 0.0 { (half_turns.sin() / half_turns).powi(2) } else { 1.0 }
    }
}

/// Both sensors in the longest stretch at rest.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RestNoise {
    /// From the log's begin \[s\].
    pub from_s: f64,
    /// To \[s\].
    pub to_s: f64,
    /// Lost samples that a straight line stands in for.
    pub bridged: usize,
    /// Accelerometer, gyroscope.
    pub sensors: [SensorNoise; 2],
}

impl RestNoise {
    /// One sensor's.
    pub fn sensor(&self, sensor: Sensor) -> &SensorNoise {
        &self.sensors[usize::from(sensor == Sensor::Gyro)]
    }

    /// Of a recording with its phases; none where it does not rest for 4 s in one piece.
    ///
    /// # Errors
    /// As [`Samples::piece`](dpn_core::Samples::piece).
    pub fn of(recording: &dyn Recorded, stretches: &[Stretch]) -> io::Result<Option<Self>> {
        Self::in_parts(recording, stretches, &rates::parts(recording)?)
    }

    /// As [`of`](Self::of), where the parts of a rate each are known.
    pub(crate) fn in_parts(
        recording: &dyn Recorded,
        stretches: &[Stretch],
        parts: &[Part],
    ) -> io::Result<Option<Self>> {
        let Some(rows) = Rows::longest(recording, stretches, parts, LEAST_S)? else { return Ok(None) };
        let sensor = |sensor: Sensor| {
            let (mut axes, mut silent) = ([const { None }; 3], true);
            for (axis, found) in axes.iter_mut().enumerate() {
                if let Some((values, rate)) = rows.series(recording, sensor, axis)? {
                    silent &= values.iter().all(|value| *value == 0.0);
                    let step = step(&values[..values.len().min(TELLING)]);
                    *found = density::density(&values, rate, step);
                }
            }
            Ok::<_, io::Error>(SensorNoise { sensor, held: rows.held(sensor), silent, axes })
        };
        let sensors = [sensor(Sensor::Accel)?, sensor(Sensor::Gyro)?];
        Ok(Some(Self { from_s: rows.from_s, to_s: rows.to_s, bridged: rows.bridged(), sensors }))
    }
}
