//! A configuration's white noise against a log that moves: its floor at rest, its envelope in motion.

use super::{Phase, Summary};
use crate::allan::compare::{key_of, suspects};
use dpn_core::noise::formats::{Axes, Figure, ImuFigures, Source, number};
use dpn_core::noise::units::BadNoise;
use dpn_core::noise::{AccelSampleStd, GyroSampleStd};
use dpn_core::{SampleRate, Sensor};
use serde::Serialize;

/// Up to this factor, up or down, two figures agree.
const AGREES: f64 = 3.0;

/// How a figure stands to the log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    /// Below a third of the floor at rest.
    BelowFloor,
    /// Fits the sensor at rest, and is below a third of what the log shows in motion.
    FitsRest,
    /// Within three times of what the log shows in motion.
    FitsMotion,
    /// Above three times what nearly all of the log shows.
    AboveEnvelope,
}

/// One figure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// Which.
    pub figure: Figure,
    /// Its key in the configuration.
    pub key: String,
    /// What stands there, in the format's meaning; the largest of the axes.
    pub configured: f64,
    /// Unit of the configured value and of the three below.
    pub unit: &'static str,
    /// Median at rest of the loudest axis; none where the log never rests.
    pub floor: Option<f64>,
    /// Median in motion of the loudest axis.
    pub in_motion: f64,
    /// What the loudest axis exceeds a twentieth of the time in motion.
    pub envelope: f64,
    /// How they stand to each other.
    pub standing: Standing,
    /// Mix-ups that would explain the distance.
    pub suspects: Vec<&'static str>,
}

impl Finding {
    /// Whether a person should look at it.
    pub fn warns(&self) -> bool {
        matches!(self.standing, Standing::BelowFloor | Standing::AboveEnvelope)
    }

    /// One line for people.
    pub fn text(&self) -> String {
        let short = |value: f64| number(format!("{value:.2e}").parse().unwrap_or(value));
        let times = |ratio: f64| if ratio >= 10.0 { format!("{ratio:.0}") } else { format!("{ratio:.1}") };
        let floor =
            self.floor.map_or_else(|| "no rest in the log".to_owned(), |f| format!("at rest {}", short(f)));
        // Variances go as the square.
        let root = |ratio: f64| if self.unit.contains(")^2") { ratio.sqrt() } else { ratio };
        let verdict = match self.standing {
            Standing::BelowFloor => {
                let floor = self.floor.unwrap_or(self.in_motion);
                format!(
                    "{} times below the sensor at rest: the IMU is trusted too much",
                    times(root(floor / self.configured))
                )
            }
            Standing::FitsRest => format!(
                "fits the sensor at rest, {} times below what it shows in motion",
                times(root(self.in_motion / self.configured))
            ),
            Standing::FitsMotion => "fits the log in motion".to_owned(),
            Standing::AboveEnvelope => {
                format!("{} times above nearly all of the log", times(root(self.configured / self.envelope)))
            }
        };
        let mut text = format!(
            "{}: `{}` is {} {}; the log says {floor}, in motion {} (95 %: {}): {verdict}",
            self.figure,
            self.key,
            number(self.configured),
            self.unit,
            short(self.in_motion),
            short(self.envelope)
        );
        if !self.suspects.is_empty() {
            text.push_str(&format!("; looks like {}", self.suspects.join(", or ")));
        }
        text
    }
}

/// Holds the white noises of `source` against a log of `rate`.
///
/// # Errors
/// A deviation that is no noise.
pub fn compare(source: &Source, summary: &Summary, rate: SampleRate) -> Result<Vec<Finding>, BadNoise> {
    let motion = summary
        .phase(Phase::Moving)
        .or_else(|| summary.phase(Phase::Motors))
        .or_else(|| summary.phases.first().filter(|p| !p.axes.is_empty()));
    let Some(motion) = motion else { return Ok(Vec::new()) };
    let rest = summary.phase(Phase::Rest);
    let mut findings = Vec::new();
    for figure in [Figure::AccelWhite, Figure::GyroWhite] {
        let (key, meaning) = key_of(source.format, figure);
        // Numbers per sample are meant at the rate they were read with.
        let read_at = source.figures.rate.unwrap_or(rate);
        let sensor = figure.sensor();
        let (Some(configured), Some(density)) =
            (source.figures.get(figure, meaning, read_at), source.figures.density(figure))
        else {
            continue;
        };
        let largest = |of: &super::PhaseSummary, pick: fn(&super::Quantiles) -> f64| {
            of.of(sensor).map(|a| pick(&a.sigma)).fold(0.0, f64::max)
        };
        // As densities, to hold against each other; in the format's own meaning, to print.
        let sigmas = [
            rest.map(|r| largest(r, |q| q.middle)),
            Some(largest(motion, |q| q.middle)),
            Some(largest(motion, |q| q.high)),
        ];
        let mut told = [None; 3];
        for (told, sigma) in told.iter_mut().zip(sigmas) {
            if let Some(sigma) = sigma {
                let figures = of_sample(sensor, sigma, rate)?;
                let meant = figures.get(figure, meaning, read_at).map(Axes::largest);
                *told = figures.density(figure).map(Axes::largest).zip(meant);
            }
        }
        let [floor, Some(middle), Some(high)] = told else { continue };
        let density = density.largest();
        let standing = match floor {
            Some((floor, _)) if density < floor / AGREES => Standing::BelowFloor,
            // Rotors shake up to fifty times as much as the sensor's own noise.
            None if density < middle.0 / (50.0 * AGREES) => Standing::BelowFloor,
            _ if density > AGREES * high.0 => Standing::AboveEnvelope,
            _ if density < middle.0 / AGREES => Standing::FitsRest,
            _ => Standing::FitsMotion,
        };
        let configured = configured.largest();
        let reference = match standing {
            Standing::BelowFloor => floor.map_or(middle.1, |f| f.1),
            _ => middle.1,
        };
        let is_far = matches!(standing, Standing::BelowFloor | Standing::AboveEnvelope);
        let suspects = if is_far {
            suspects(figure, meaning, configured, reference, read_at, &|_| 0.0)
        } else {
            Vec::new()
        };
        findings.push(Finding {
            figure,
            key,
            configured,
            unit: meaning.unit(figure),
            floor: floor.map(|f| f.1),
            in_motion: middle.1,
            envelope: high.1,
            standing,
            suspects,
        });
    }
    Ok(findings)
}

/// One sensor's white noise by the deviation of one sample at `rate`.
fn of_sample(sensor: Sensor, sigma: f64, rate: SampleRate) -> Result<ImuFigures, BadNoise> {
    let mut figures = ImuFigures { rate: Some(rate), ..ImuFigures::default() };
    match sensor {
        Sensor::Accel => figures.accel_white = Some(Axes::Same(AccelSampleStd::new(sigma)?.to_density(rate))),
        Sensor::Gyro => figures.gyro_white = Some(Axes::Same(GyroSampleStd::new(sigma)?.to_density(rate))),
    }
    Ok(figures)
}
