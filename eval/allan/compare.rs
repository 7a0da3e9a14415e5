//! A configuration's noise figures against those of a log at rest, and what may have been mixed up where they are far apart.

use super::log::AllanLog;
use super::model::Coefficient;
use dpn_core::SampleRate;
use dpn_core::noise::formats::{Axes, Figure, Format, Meaning, Source, number};
use serde::Serialize;

/// Up to this factor, up or down, a configuration agrees with a log.
const AGREES: f64 = 3.0;
/// Up to this factor people multiply on purpose.
const USUAL: f64 = 20.0;
/// How near a mix-up's own factor must be to explain what stands there.
const NEAR: f64 = 1.6;

/// How a figure stands to the log's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Within three times.
    Agrees,
    /// Three to twenty times above: what people do on purpose for vibration.
    Inflated,
    /// More than twenty times above.
    TooHigh,
    /// Below a third of the sensor's own noise.
    TooLow,
    /// The log does not show the figure; the configuration's is below what it would have shown.
    NotSeen,
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
    /// What the log says, in the same meaning; the largest of the axes. An upper bound where the log does not show it.
    pub measured: f64,
    /// Unit of both.
    pub unit: &'static str,
    /// Whether the log shows the figure on all axes.
    pub seen: bool,
    /// Configured density over measured density.
    pub ratio: f64,
    /// How they stand to each other.
    pub verdict: Verdict,
    /// Mix-ups that would explain the distance.
    pub suspects: Vec<&'static str>,
}

impl Finding {
    /// Whether a person should look at it.
    pub fn warns(&self) -> bool {
        !matches!(self.verdict, Verdict::Agrees | Verdict::NotSeen)
    }

    /// One line for people.
    pub fn text(&self) -> String {
        let head = format!(
            "{}: `{}` is {} {}, the log says {}{}",
            self.figure,
            self.key,
            number(self.configured),
            self.unit,
            if self.seen { "" } else { "below " },
            number(rounded(self.measured)),
        );
        let times = |ratio: f64| {
            if ratio >= 10.0 { format!("{ratio:.0}") } else { format!("{ratio:.1}") }
        };
        let verdict = match self.verdict {
            Verdict::Agrees => format!("agrees (x{:.2})", self.ratio),
            Verdict::NotSeen => "agrees as far as the log shows".to_owned(),
            Verdict::Inflated => {
                format!("{} times the noise at rest: usual for a moving vehicle, if meant", times(self.ratio))
            }
            Verdict::TooHigh => {
                format!("{} times the noise at rest: more than motion explains", times(self.ratio))
            }
            Verdict::TooLow => {
                format!(
                    "{} times below the sensor's own noise: the IMU is trusted too much",
                    times(1.0 / self.ratio)
                )
            }
        };
        let mut text = format!("{head}: {verdict}");
        if !self.suspects.is_empty() {
            text.push_str(&format!("; looks like {}", self.suspects.join(", or ")));
        }
        text
    }
}

fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// Holds every figure of `source` against `log`.
pub fn compare(source: &Source, log: &AllanLog) -> Vec<Finding> {
    let Ok(measured) = log.figures() else {
        return Vec::new();
    };
    // Numbers per sample are meant at the rate they were read with.
    let rate = source.figures.rate.unwrap_or(log.rate);
    Figure::ALL
        .into_iter()
        .filter_map(|figure| {
            let (key, meaning) = key_of(source.format, figure);
            let configured = source.figures.get(figure, meaning, rate)?.largest();
            let at_log = measured.get(figure, meaning, rate)?.largest();
            let density =
                |figures: &dpn_core::noise::formats::ImuFigures| figures.density(figure).map(Axes::largest);
            let ratio = density(&source.figures)? / density(&measured)?;
            let coefficient = if figure.is_walk() { Coefficient::Walk } else { Coefficient::White };
            let seen = log.seen(figure.sensor(), coefficient);
            let verdict = match ratio {
                r if r <= AGREES && !seen => Verdict::NotSeen,
                r if r < 1.0 / AGREES => Verdict::TooLow,
                r if r <= AGREES => Verdict::Agrees,
                r if r <= USUAL => Verdict::Inflated,
                _ => Verdict::TooHigh,
            };
            let suspects = if matches!(verdict, Verdict::Agrees | Verdict::NotSeen) {
                Vec::new()
            } else {
                let largest =
                    |c| log.estimates(figure.sensor(), c).iter().map(|e| e.value).fold(0.0, f64::max);
                suspects(figure, meaning, configured, at_log, rate, &largest)
            };
            Some(Finding {
                figure,
                key,
                configured,
                measured: at_log,
                unit: meaning.unit(figure),
                seen,
                ratio,
                verdict,
                suspects,
            })
        })
        .collect()
}

pub(crate) fn key_of(format: Format, figure: Figure) -> (String, Meaning) {
    match format.layout() {
        Some(layout) => {
            let key = layout.key(figure);
            (key.name.to_owned(), key.meaning)
        }
        None if format == Format::Ros => (figure.to_string(), Meaning::SampleVariance),
        None if figure.is_walk() => (figure.to_string(), Meaning::WalkDensity),
        None => (figure.to_string(), Meaning::Density),
    }
}

/// What `configured` would be, were the `measured` noise written down by mistake in another meaning or unit.
///
/// `largest` is the largest of the axes' other coefficients, for a walk.
pub(crate) fn suspects(
    figure: Figure,
    meaning: Meaning,
    configured: f64,
    measured: f64,
    rate: SampleRate,
    largest: &dyn Fn(Coefficient) -> f64,
) -> Vec<&'static str> {
    use dpn_core::Sensor::{Accel, Gyro};
    const DEGREES: f64 = 180.0 / std::f64::consts::PI;
    const G: f64 = 9.806_65;
    let root = rate.hz().sqrt();
    let sensor = figure.sensor();
    let variance = matches!(meaning, Meaning::SampleVariance | Meaning::WalkStepVariance | Meaning::Power);
    let density = !meaning.needs_rate();
    let mut all: Vec<(f64, &'static str)> = Vec::new();
    if variance {
        all.push((measured.sqrt(), "a deviation where a variance belongs"));
        all.push((measured / rate.hz(), "a power density where a variance per sample belongs"));
    } else {
        all.push((measured * measured, "a variance where a deviation belongs"));
    }
    match (variance, density, figure.is_walk()) {
        (false, true, false) => all.push((measured * root, "a deviation per sample where a density belongs")),
        (false, false, false) => {
            all.push((measured / root, "a density where a deviation per sample belongs"));
        }
        (false, true, true) => {
            all.push((measured / root, "a walk per sample where a density belongs"));
            all.push((measured * root, "a walk of VINS's kind where a density belongs"));
        }
        (false, false, true) => all.push((measured / root, "a density where VINS's kind of walk belongs")),
        (true, ..) => {}
    }
    let power = if variance { 2 } else { 1 };
    match sensor {
        Gyro => {
            all.push((measured * DEGREES.powi(power), "degrees where radians belong"));
            all.push((measured / DEGREES.powi(power), "radians turned into radians once more"));
        }
        Accel => {
            all.push((measured / G.powi(power), "g where m/s^2 belongs"));
            all.push((measured * (1e3 / G).powi(power), "mg where m/s^2 belongs"));
        }
    }
    if figure.is_walk() {
        all.push((largest(Coefficient::Instability), "a bias instability where a walk belongs"));
        all.push((largest(Coefficient::White), "the white noise where a walk belongs"));
    }
    let off = |value: f64| (configured / value).ln().abs();
    let mut near: Vec<(f64, &'static str)> = all
        .into_iter()
        .filter(|(value, _)| *value > 0.0 && off(*value) < NEAR.ln())
        .map(|(value, words)| (off(value), words))
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    near.into_iter().take(2).map(|(_, words)| words).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::allan::simulate::at_rest;
    use dpn_core::noise::formats::{Given, parse};
    use dpn_core::random::Stream;
    use dpn_core::{ImuRecording, ImuSample, Stamp};
    use std::path::Path;

    /// Ten minutes at 100 Hz: 1e-3 m/s^2/sqrt(Hz) and 1e-4 rad/s/sqrt(Hz), walks of 2e-4 and 2e-5.
    fn log() -> AllanLog {
        let rate = SampleRate::from_hz(100.0).unwrap();
        let mut rng = Stream::new(9).named("compare").rng();
        let mut axis = |white: f64, walk: f64| {
            at_rest(&[0.0, white * white, 0.0, walk * walk, 0.0], 60_000, rate, &mut rng)
        };
        let axes: Vec<Vec<f64>> =
            [(1e-4, 2e-5), (1e-4, 2e-5), (1e-4, 2e-5), (1e-3, 2e-4), (1e-3, 2e-4), (1e-3, 2e-4)]
                .map(|(w, k)| axis(w, k))
                .to_vec();
        let samples = (0..60_000).map(|i| ImuSample {
            t: Stamp::from_ns(i as i64 * 10_000_000),
            gyro: [axes[0][i], axes[1][i], axes[2][i]],
            accel: [axes[3][i], axes[4][i], axes[5][i] + 9.81],
        });
        AllanLog::of(&ImuRecording::new(samples.collect()).unwrap(), true).unwrap()
    }

    #[test]
    fn every_mix_up_is_named_and_a_sound_file_is_not() {
        let log = log();
        let check = |text: &str| {
            let given = Given { rate: SampleRate::from_hz(100.0), ..Given::default() };
            let source = parse(text.as_bytes(), Path::new("f"), None, &given).unwrap();
            compare(&source, &log)
        };
        let kalibr = |an: f64, aw: f64, gn: f64, gw: f64| {
            check(&format!(
                "accelerometer_noise_density: {an:e}\naccelerometer_random_walk: {aw:e}\ngyroscope_noise_density: {gn:e}\n\
                 gyroscope_random_walk: {gw:e}\n"
            ))
        };
        let sound = kalibr(1.2e-3, 2e-4, 0.9e-4, 2e-5);
        assert!(sound.iter().all(|f| f.verdict == Verdict::Agrees && !f.warns()), "{sound:?}");
        let per_sample = kalibr(1e-2, 2e-4, 1e-3, 2e-5);
        assert_eq!(per_sample[0].suspects.first(), Some(&"a deviation per sample where a density belongs"));
        assert_eq!(per_sample[0].verdict, Verdict::Inflated);
        assert_eq!(per_sample[2].suspects.first(), Some(&"a deviation per sample where a density belongs"));
        let degrees = kalibr(1e-3 / 9.81, 2e-4, 1e-4 * 57.3, 2e-5);
        assert_eq!((degrees[0].verdict, degrees[0].suspects[0]), (Verdict::TooLow, "g where m/s^2 belongs"));
        assert_eq!(
            (degrees[2].verdict, degrees[2].suspects[0]),
            (Verdict::TooHigh, "degrees where radians belong")
        );
        let variances = kalibr(1e-6, 1e-3, 1e-8, 2e-5);
        assert_eq!(variances[0].suspects, ["a variance where a deviation belongs"]);
        assert!(
            variances[1].suspects.contains(&"the white noise where a walk belongs"),
            "{:?}",
            variances[1]
        );
        let vins = check("acc_n: 0.001\nacc_w: 0.002\ngyr_n: 0.001\ngyr_w: 2e-4\n");
        assert_eq!(vins[0].suspects[0], "a density where a deviation per sample belongs");
        assert_eq!((vins[1].verdict, vins[2].verdict), (Verdict::Agrees, Verdict::Agrees));
        assert!(vins[0].text().contains("10 times below the sensor's own noise"), "{}", vins[0].text());
        let deviation = check("AccelerometerNoise: 0.01\nGyroscopeNoise: 1e-6\n");
        assert_eq!(deviation[0].suspects[0], "a deviation where a variance belongs");
        assert_eq!(deviation[1].verdict, Verdict::Agrees);
    }
}
