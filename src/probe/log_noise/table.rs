//! The noise of many logs in one table, a row each.

use super::EffectiveNoise;
use crate::doctor::Examination;
use crate::paste::FigureLine;
use crate::phases::phases;
use crate::text::{aligned, three};
use dpn_core::noise::{Figure, Interval};
use dpn_core::{Recorded, Sensor};
use serde::Serialize;
use std::io;

/// A log by its name, and its noise, or why it could not be read.
pub type Row = (String, Result<NoiseOfLog, String>);

/// What a row has of a log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NoiseOfLog {
    /// Median rate \[Hz\].
    pub rate_hz: f64,
    /// From the first to the last stamp \[s\].
    pub length_s: f64,
    /// Seconds at rest.
    pub rest_s: f64,
    /// The figures that `dpn noise` of this log alone would paste, accelerometer and gyroscope; without a second of data none.
    pub noise: Vec<FigureLine>,
    /// Densities at rest by the spectrum, accelerometer and gyroscope, the largest of the axes; none of a log that does not rest.
    pub at_rest: [Option<f64>; 2],
    /// What the gravest finding that warns is about.
    pub worst: Option<&'static str>,
}

impl NoiseOfLog {
    /// Of a log and its examination.
    ///
    /// # Errors
    /// As [`Samples::piece`](dpn_core::Samples::piece).
    pub fn of(recording: &dyn Recorded, examination: &Examination) -> io::Result<Self> {
        let stretches = phases(recording)?;
        let effective = EffectiveNoise::of(recording, &stretches, examination.rest.as_ref())?;
        Ok(Self {
            rate_hz: examination.rate_hz,
            length_s: examination.length_s,
            rest_s: examination.figures.rest_s,
            at_rest: [examination.figures.accel_noise, examination.figures.gyro_noise],
            noise: effective.map_or_else(Vec::new, |effective| effective.paste.lines),
            worst: examination
                .findings
                .first()
                .filter(|finding| finding.warns())
                .map(|finding| finding.about),
        })
    }

    fn line(&self, sensor: Sensor) -> Option<&FigureLine> {
        self.noise.iter().find(|line| line.figure == Figure::white(sensor))
    }

    /// The figure to paste, the largest of the axes; where it is not known, that at rest.
    fn density(&self, sensor: Sensor) -> Option<f64> {
        let largest = |axes: [Interval; 3]| axes.iter().map(|axis| axis.value).fold(0.0, f64::max);
        self.line(sensor).and_then(|line| line.density).map(largest).or(self.rest(sensor))
    }

    fn rest(&self, sensor: Sensor) -> Option<f64> {
        self.at_rest[usize::from(sensor == Sensor::Gyro)]
    }

    /// Where the figures come from, or why there is none: once, where both sensors have the same.
    fn source(&self) -> String {
        let words = |sensor: Sensor| match self.line(sensor) {
            Some(line) if line.density.is_none() && self.rest(sensor).is_some() => {
                format!("at rest, by the spectrum; in motion {}", line.words)
            }
            line => line.map_or("too short", |line| &line.words).to_owned(),
        };
        match Sensor::ALL.map(words) {
            [accel, gyro] if accel == gyro => accel,
            [accel, gyro] => format!("accel {accel}; gyro {gyro}"),
        }
    }
}

/// The table: rate, rest or motion, noise, where it comes from, and the worst finding.
pub fn page(rows: &[Row]) -> String {
    let mut table = vec![["log", "Hz", "state", "accel", "gyro", "worst", "from"].map(str::to_owned)];
    for (name, row) in rows {
        table.push(match row {
            Ok(of) => {
                let state = match of.rest_s {
                    rest if rest > 0.9 * of.length_s => "rest".to_owned(),
                    0.0 => "motion".to_owned(),
                    rest => format!("rest {rest:.0} of {:.0} s", of.length_s),
                };
                let [accel, gyro] =
                    Sensor::ALL.map(|sensor| of.density(sensor).map_or_else(|| "-".to_owned(), three));
                let worst = of.worst.unwrap_or("-").to_owned();
                [name.clone(), format!("{:.1}", of.rate_hz), state, accel, gyro, worst, of.source()]
            }
            Err(error) => {
                let mut cells: [String; 7] = std::array::from_fn(|_| "-".to_owned());
                (cells[0], cells[6]) = (name.clone(), format!("cannot be read: {error}"));
                cells
            }
        });
    }
    aligned(&table) + "noise: densities, the largest of the axes, m/s^2/sqrt(Hz) and rad/s/sqrt(Hz)\n"
}
