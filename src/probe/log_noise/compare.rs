//! A configuration against a log that moves: its white noise against the floor at rest and the envelope in motion, both of the samples
//! themselves ([`Levels`]); its walks against the log's longest rest, or, where there is none, against what even the motion stays below.
//!
//! Where the log hides the sensor's own noise, a figure is held against what IMUs have (`mix_up::typical`); a mix-up behind which a usual one
//! stands is named.

use super::Levels;
use super::levels::FloorFrom;
use crate::allan::compare::{FigureCheck, Measured, ZERO, judge, key_of, short, times, usual};
use crate::allan::mix_up::{MG, by_measured, by_typical, unusual};
use crate::finding::Finding;
use dpn_core::noise::Meaning;
use dpn_core::noise::units::BadNoise;
use dpn_core::noise::{AccelSampleStd, GyroSampleStd};
use dpn_core::noise::{Axes, Figure, ImuFigures};
use dpn_core::{SampleRate, Sensor};
use dpn_io::noise_formats::{NoiseCalibration, number};
use serde::Serialize;

/// Up to this factor, up or down, two figures agree.
const AGREES: f64 = 3.0;
/// Rotors shake up to this many times as much as the sensor's own noise.
const ROTORS: f64 = 50.0;

/// How a figure stands to the log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    /// A zero.
    Zero,
    /// Below a third of the floor; without one, further below the motion than rotors explain.
    BelowFloor,
    /// Fits the sensor at rest, and is below a third of what the log shows in motion.
    FitsRest,
    /// Within three times of what the log shows in motion.
    FitsMotion,
    /// Above three times what nearly all of the log shows.
    AboveEnvelope,
}

/// One figure of white noise of a configuration against a log that moves.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WhiteCheck {
    /// Which.
    pub figure: Figure,
    /// Its key in the configuration.
    pub key: String,
    /// What stands there, in the format's meaning; the largest of the axes, or zero where one of them is zero.
    pub configured: f64,
    /// Unit of the configured value and of the three below.
    pub unit: &'static str,
    /// The sensor's own noise, where the log shows it.
    pub floor: Option<f64>,
    /// Where the floor is from.
    pub floor_from: Option<FloorFrom>,
    /// Median in motion of the loudest axis.
    pub in_motion: f64,
    /// What the loudest axis exceeds a twentieth of the time in motion.
    pub envelope: f64,
    /// How they stand to each other.
    pub standing: Standing,
    /// Whether no IMU has such a figure.
    pub unusual: bool,
    /// Mix-ups that would explain the distance from the sensor's own noise.
    pub suspects: Vec<&'static str>,
}

/// All that was compared.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// What the log's levels are.
    pub levels: String,
    /// White noises.
    pub white: Vec<WhiteCheck>,
    /// Walks.
    pub walks: Vec<FigureCheck>,
    /// What the walks were held against.
    pub walks_by: String,
}

impl Check {
    /// All of it in words, one a figure.
    pub fn findings(&self) -> Vec<Finding> {
        let white = self.white.iter().map(WhiteCheck::finding);
        white.chain(self.walks.iter().map(FigureCheck::finding)).collect()
    }
}

impl WhiteCheck {
    /// In words.
    pub fn finding(&self) -> Finding {
        let floor = match (self.floor, self.floor_from) {
            (Some(floor), Some(FloorFrom::Rest)) => format!("at rest {}", short(floor)),
            (Some(floor), _) => format!("in its quietest seconds {}", short(floor)),
            (None, _) => "too little at rest to show the sensor's own noise".to_owned(),
        };
        // Variances go as the square.
        let root = |ratio: f64| if self.unit.contains(")^2") { ratio.sqrt() } else { ratio };
        let verdict = match (self.standing, self.floor) {
            (Standing::Zero, _) => ZERO.to_owned(),
            (Standing::BelowFloor, Some(floor)) => format!(
                "{} times below the sensor's own noise: the IMU is trusted too much",
                times(root(floor / self.configured))
            ),
            (Standing::BelowFloor, None) => format!(
                "{} times below what the log shows in motion, more than what shakes explains: the IMU is trusted too much",
                times(root(self.in_motion / self.configured))
            ),
            (Standing::FitsRest, Some(_)) => format!(
                "fits the sensor at rest, {} times below what it shows in motion",
                times(root(self.in_motion / self.configured))
            ),
            (Standing::FitsRest, None) => format!(
                "{} times below what the log shows in motion, as a sensor's own noise may be",
                times(root(self.in_motion / self.configured))
            ),
            (Standing::FitsMotion, _) => "fits the log in motion".to_owned(),
            (Standing::AboveEnvelope, _) => {
                format!("{} times above nearly all of the log", times(root(self.configured / self.envelope)))
            }
        };
        let mut text = format!(
            "{}: `{}` is {} {}; the log says: {floor}, in motion {} (95 %: {}): {verdict}",
            self.figure,
            self.key,
            number(self.configured),
            self.unit,
            short(self.in_motion),
            short(self.envelope)
        );
        if self.unusual {
            text.push_str(&format!("; IMUs at rest have {}", usual(self.figure)));
        }
        if !self.suspects.is_empty() {
            let unless =
                if self.standing == Standing::FitsMotion { "unless raised on purpose, " } else { "" };
            text.push_str(&format!("; {unless}looks like {}", self.suspects.join(", or ")));
        }
        let warns = matches!(self.standing, Standing::Zero | Standing::BelowFloor | Standing::AboveEnvelope)
            || !self.suspects.is_empty()
            || (self.unusual && self.standing == Standing::FitsRest);
        Finding::figure(warns, text)
    }
}

/// Holds `source` against a log of `rate`.
///
/// # Errors
/// A deviation that is no noise.
pub fn compare(source: &NoiseCalibration, levels: &Levels, rate: SampleRate) -> Result<Check, BadNoise> {
    let mut white = Vec::new();
    for figure in [Figure::AccelWhite, Figure::GyroWhite] {
        white.extend(white_noise(source, levels, rate, figure)?);
    }
    let walk = |figure: Figure| {
        let bound = levels.sensor(figure.sensor()).walk_below;
        let bound = bound.map(|density| Measured { density, seen: false, mistaken: [0.0; 2] });
        let at_rest = levels.rest.as_ref().and_then(|rest| Measured::at_rest(rest, figure));
        let tighter = match (at_rest, bound) {
            (Some(rest), Some(bound)) if !rest.seen && bound.density < rest.density => {
                Measured { density: bound.density, ..rest }
            }
            (Some(rest), _) => rest,
            (None, bound) => bound?,
        };
        judge(source, figure, rate, &tighter)
    };
    let walks = [Figure::AccelWalk, Figure::GyroWalk].into_iter().filter_map(walk).collect();
    let walks_by = match &levels.rest {
        Some(rest) => format!("walks of the bias by the longest rest, {:.0} s, or what the whole log stays below", rest.length_s),
        None => "walks of the bias by what the log's motion stays below, which is far above any; `dpn allan --check` holds them against a log at rest".to_owned(),
    };
    Ok(Check { levels: levels.words(), white, walks, walks_by })
}

fn white_noise(
    source: &NoiseCalibration,
    levels: &Levels,
    rate: SampleRate,
    figure: Figure,
) -> Result<Option<WhiteCheck>, BadNoise> {
    let (key, meaning) = key_of(source.format, figure);
    // Numbers per sample are meant at the rate they were read with.
    let read_at = source.figures.rate.unwrap_or(rate);
    let sensor = figure.sensor();
    let of = levels.sensor(sensor);
    let floor = of.floor.map(|(sigma, _)| converted(figure, meaning, sigma, rate, read_at)).transpose()?;
    let middle = converted(figure, meaning, of.in_motion, rate, read_at)?;
    let high = converted(figure, meaning, of.envelope, rate, read_at)?;
    let mut finding = WhiteCheck {
        figure,
        key,
        configured: 0.0,
        unit: meaning.unit(figure),
        floor: floor.map(|f| f.meant),
        floor_from: of.floor.map(|f| f.1),
        in_motion: middle.meant,
        envelope: high.meant,
        standing: Standing::Zero,
        unusual: false,
        suspects: Vec::new(),
    };
    if source.zeros.iter().any(|zero| zero.figure == figure) {
        return Ok(Some(finding));
    }
    let (Some(configured), Some(density)) =
        (source.figures.get(figure, meaning, read_at), source.figures.density(figure))
    else {
        return Ok(None);
    };
    let (configured, density) = (configured.largest(), density.largest());
    finding.configured = configured;
    finding.standing = match floor {
        Some(floor) if density < floor.density / AGREES => Standing::BelowFloor,
        None if density < middle.density / (ROTORS * AGREES) => Standing::BelowFloor,
        _ if density > AGREES * high.density => Standing::AboveEnvelope,
        _ if density < middle.density / AGREES => Standing::FitsRest,
        _ => Standing::FitsMotion,
    };
    let is_far = matches!(finding.standing, Standing::BelowFloor | Standing::AboveEnvelope);
    finding.unusual = floor.is_none() && unusual(figure, density);
    let is_apart = match floor {
        Some(floor) => is_far || density > AGREES * floor.density,
        None => is_far || finding.unusual,
    };
    if is_apart {
        let by = |right: Converted| by_measured(figure, meaning, configured, right.meant, read_at, &[]);
        finding.suspects = floor.map(by).unwrap_or_default();
        // The quietest seconds may still be far from the sensor's own noise.
        if finding.suspects.is_empty() {
            finding.suspects = by_typical(figure, meaning, configured, read_at);
        }
        if finding.suspects.is_empty() && is_far {
            finding.suspects = by(middle);
        }
        // What fits the log in motion is a hundred times the sensor's own noise for that reason.
        if finding.standing == Standing::FitsMotion {
            finding.suspects.retain(|words| *words != MG);
        }
    }
    Ok(Some(finding))
}

/// A deviation of one sample as a density, to hold against others, and in the format's own meaning, to print.
#[derive(Debug, Clone, Copy)]
struct Converted {
    density: f64,
    meant: f64,
}

fn converted(
    figure: Figure,
    meaning: Meaning,
    sigma: f64,
    rate: SampleRate,
    read_at: SampleRate,
) -> Result<Converted, BadNoise> {
    let mut figures = ImuFigures { rate: Some(rate), ..ImuFigures::default() };
    match figure.sensor() {
        Sensor::Accel => figures.accel_white = Some(Axes::Same(AccelSampleStd::new(sigma)?.to_density(rate))),
        Sensor::Gyro => figures.gyro_white = Some(Axes::Same(GyroSampleStd::new(sigma)?.to_density(rate))),
    }
    let of = |value: Option<Axes<f64>>| value.map(Axes::largest).ok_or(BadNoise(sigma));
    Ok(Converted { density: of(figures.density(figure))?, meant: of(figures.get(figure, meaning, read_at))? })
}
