//! A configuration's noise figures against those of a log at rest, and what may have been mixed up where they are far apart.

use super::log::AllanLog;
use super::mix_up::{by_measured, by_typical, typical, unusual};
use super::model::Coefficient;
use crate::finding::Finding;
use dpn_core::SampleRate;
use dpn_core::noise::Meaning;
use dpn_core::noise::{Axes, Figure, ImuFigures};
use dpn_io::noise_formats::{Format, NoiseCalibration, number};
use serde::Serialize;

/// Up to this factor, up or down, a walk agrees with a log's, which tells one to a factor of two or so.
const AGREES: f64 = 3.0;
/// The same of white noise: a log at rest shows it to per cents, and sensors of one kind differ by a third.
const WHITE_AGREES: f64 = 1.5;
/// From here on a walk that agrees is said to be near, not the same.
const SAME: f64 = 1.5;
/// Up to this factor people multiply on purpose.
const USUAL: f64 = 20.0;

/// How a figure stands to the log's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// White noise within half as much again, a walk within three times.
    Agrees,
    /// Up to twenty times above: what people do on purpose for vibration.
    Inflated,
    /// More than twenty times above.
    TooHigh,
    /// White noise below two thirds of the sensor's own, a walk below a third.
    TooLow,
    /// The log does not show the figure; the configuration's is below what it would have shown.
    NotSeen,
    /// As [`Self::NotSeen`], and more than twice outside what IMUs have.
    Unusual,
    /// A zero.
    Zero,
}

/// What is said of a zero.
pub(crate) const ZERO: &str =
    "an estimator told of no noise trusts the IMU without bound; put the sensor's figure there";

/// One figure of a configuration against a log's.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FigureCheck {
    /// Which.
    pub figure: Figure,
    /// Its key in the configuration.
    pub key: String,
    /// What stands there, in the format's meaning; the largest of the axes, or zero where one of them is zero.
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

impl FigureCheck {
    /// In words.
    pub fn finding(&self) -> Finding {
        let than = if self.seen { "the noise at rest" } else { "what the log would show" };
        let verdict = match self.verdict {
            Verdict::Agrees if self.ratio.max(1.0 / self.ratio) <= SAME => {
                format!("agrees (x{:.2})", self.ratio)
            }
            Verdict::Agrees => format!("x{:.2}, as near as a log tells a walk", self.ratio),
            Verdict::NotSeen => "agrees as far as the log shows".to_owned(),
            Verdict::Unusual => {
                format!("agrees as far as the log shows, but IMUs have {}", usual(self.figure))
            }
            Verdict::Zero => ZERO.to_owned(),
            Verdict::Inflated => {
                format!("{} times {than}: usual for a moving vehicle, if meant", times(self.ratio))
            }
            Verdict::TooHigh => format!("{} times {than}: more than motion explains", times(self.ratio)),
            Verdict::TooLow => format!(
                "{} times below the sensor's own noise: the IMU is trusted too much",
                times(1.0 / self.ratio)
            ),
        };
        let mut text = format!(
            "{}: `{}` is {} {}, the log says {}{}: {verdict}",
            self.figure,
            self.key,
            number(self.configured),
            self.unit,
            if self.seen { "" } else { "below " },
            short(self.measured),
        );
        if !self.suspects.is_empty() {
            text.push_str(&format!("; looks like {}", self.suspects.join(", or ")));
        }
        Finding::figure(!matches!(self.verdict, Verdict::Agrees | Verdict::NotSeen), text)
    }
}

/// Three digits.
pub(crate) fn short(value: f64) -> String {
    number(format!("{value:.2e}").parse().expect("a number as Rust writes it is one that Rust reads"))
}

/// How often one figure is the other.
pub(crate) fn times(ratio: f64) -> String {
    if ratio >= 10.0 { format!("{ratio:.0}") } else { format!("{ratio:.1}") }
}

/// What IMUs have, with its unit.
pub(crate) fn usual(figure: Figure) -> String {
    let [low, high] = typical(figure);
    format!("{} to {} {}", number(low), number(high), figure.unit())
}

/// What a log says of one figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Its density, the largest of the axes; where it is not seen, what it stays below.
    pub density: f64,
    /// Whether the log shows it on all axes.
    pub seen: bool,
    /// What may stand there in its place: the axes' largest bias instability and white noise, as densities; 0 where not known.
    pub mistaken: [f64; 2],
}

impl Measured {
    /// What a log at rest says of `figure`.
    pub fn at_rest(log: &AllanLog, figure: Figure) -> Option<Self> {
        let density = log.figures().density(figure)?.largest();
        let sensor = figure.sensor();
        let largest = |c| log.estimates(sensor, c).iter().map(|e| e.value).fold(0.0, f64::max);
        let coefficient = if figure.is_walk() { Coefficient::Walk } else { Coefficient::White };
        // Who reads the instability off a plot takes its lowest point, flat or not.
        let lowest = |axis: &super::AxisFit| {
            axis.fit.points.iter().map(|p| p.deviation).fold(f64::INFINITY, f64::min) / FLOOR
        };
        let floor = log.axes.iter().filter(|a| a.sensor == sensor).map(lowest).fold(0.0, f64::max);
        let is_flat = log.seen(sensor, Coefficient::Instability);
        let mistaken = if figure.is_walk() {
            [if is_flat { largest(Coefficient::Instability) } else { floor }, largest(Coefficient::White)]
        } else {
            [0.0; 2]
        };
        Some(Self { density, seen: log.seen(sensor, coefficient), mistaken })
    }
}

/// The floor of an Allan plot over the bias instability: sqrt(2 ln 2 / pi).
const FLOOR: f64 = 0.664;

/// Holds every figure of `source` against `log`.
pub fn compare(source: &NoiseCalibration, log: &AllanLog) -> Vec<FigureCheck> {
    let judged = |figure| judge(source, figure, log.rate, &Measured::at_rest(log, figure)?);
    Figure::ALL.into_iter().filter_map(judged).collect()
}

/// Figures of `source` that no IMU has at rest, nor twenty times that as people tell an estimator that moves; with mix-ups that would explain them.
pub fn implausible(source: &NoiseCalibration) -> Vec<Finding> {
    let rate = source.figures.rate.unwrap_or(SampleRate::HZ_200);
    let of = |figure: Figure| {
        let density = source.figures.density(figure)?.largest();
        let above = density > typical(figure)[1] * USUAL;
        if !(unusual(figure, density) && (above || density < typical(figure)[0])) {
            return None;
        }
        let (key, meaning) = key_of(source.format, figure);
        let configured = source.figures.get(figure, meaning, rate)?.largest();
        let (number, unit) = (number(configured), meaning.unit(figure));
        let mut text = format!("{figure}: `{key}` is {number} {unit}, but IMUs have {}", usual(figure));
        let suspects = by_typical(figure, meaning, configured, rate);
        if !suspects.is_empty() {
            text.push_str(&format!("; looks like {}", suspects.join(", or ")));
        }
        Some(Finding::figure(true, text))
    };
    Figure::ALL.into_iter().filter_map(of).collect()
}

/// Holds one figure of `source` against what a log of `log_rate` says of it; none where the configuration does not have it.
pub fn judge(
    source: &NoiseCalibration,
    figure: Figure,
    log_rate: SampleRate,
    measured: &Measured,
) -> Option<FigureCheck> {
    let (key, meaning) = key_of(source.format, figure);
    // Numbers per sample are meant at the rate they were read with.
    let rate = source.figures.rate.unwrap_or(log_rate);
    let meant = |density: f64| {
        let mut figures = ImuFigures::default();
        let own = if figure.is_walk() { Meaning::WalkDensity } else { Meaning::Density };
        figures.set(figure, own, Axes::Same(density), rate).expect("a density of the log's is one");
        figures.get(figure, meaning, rate).map(Axes::largest)
    };
    let at_log = meant(measured.density)?;
    let seen = measured.seen;
    let found = |configured, ratio, verdict, suspects| {
        let (key, unit) = (key.clone(), meaning.unit(figure));
        Some(FigureCheck { figure, key, configured, measured: at_log, unit, seen, ratio, verdict, suspects })
    };
    if source.zeros.iter().any(|zero| zero.figure == figure) {
        return found(0.0, 0.0, Verdict::Zero, Vec::new());
    }
    let configured = source.figures.get(figure, meaning, rate)?.largest();
    let density = source.figures.density(figure)?.largest();
    let ratio = density / measured.density;
    let agrees = if figure.is_walk() { AGREES } else { WHITE_AGREES };
    let verdict = match ratio {
        r if r <= AGREES && !seen && unusual(figure, density) => Verdict::Unusual,
        r if r <= AGREES && !seen => Verdict::NotSeen,
        r if r < 1.0 / agrees => Verdict::TooLow,
        r if r <= agrees => Verdict::Agrees,
        r if r <= USUAL => Verdict::Inflated,
        _ => Verdict::TooHigh,
    };
    let others: Vec<(f64, &'static str)> = measured
        .mistaken
        .into_iter()
        .zip(["a bias instability where a walk belongs", "the white noise where a walk belongs"])
        .filter_map(|(density, words)| Some((meant(density)?, words)))
        .collect();
    let mut suspects = match verdict {
        Verdict::Agrees | Verdict::NotSeen | Verdict::Zero | Verdict::Unusual => Vec::new(),
        _ => by_measured(figure, meaning, configured, at_log, rate, &others),
    };
    // A bound is no figure that a mix-up could have begun with.
    if !seen && suspects.is_empty() && unusual(figure, density) {
        suspects = by_typical(figure, meaning, configured, rate);
    }
    found(configured, ratio, verdict, suspects)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::allan::simulate::at_rest;
    use dpn_core::random::Stream;
    use dpn_core::{ImuRecording, ImuSample, Stamp};
    use dpn_io::noise_formats::{Given, parse};
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
    fn figures_that_no_imu_has_are_named_without_a_log_and_usual_ones_are_not() {
        let of = |[an, aw, gn, gw]: [f64; 4]| {
            let text = format!(
                "accelerometer_noise_density: {an:e}\naccelerometer_random_walk: {aw:e}\ngyroscope_noise_density: {gn:e}\ngyroscope_random_walk: {gw:e}\n"
            );
            let source = parse(text.as_bytes(), Path::new("f"), None, &Given::default()).unwrap();
            implausible(&source).into_iter().map(|finding| finding.text).collect::<Vec<_>>()
        };
        // EuRoC's, and five times as much.
        assert_eq!(of([2e-3, 3e-3, 1.7e-4, 1.9e-5]), Vec::<String>::new());
        assert_eq!(of([1e-2, 1.5e-2, 8.5e-4, 1e-4]), Vec::<String>::new());
        let variances = of([4e-6, 1e-8, 4e-8, 1e-10]);
        assert_eq!(variances.len(), 4, "{variances:?}");
        assert!(variances[0].contains("is 4.0e-6 m/s^2/sqrt(Hz), but IMUs have"), "{variances:?}");
        assert!(
            variances.iter().all(|text| text.contains("a variance where a deviation belongs")),
            "{variances:?}"
        );
        let degrees = of([2e-3, 3e-3, 1.7e-4 * 57.3, 1.9e-5]);
        assert!(degrees.len() == 1 && degrees[0].contains("degrees where radians belong"), "{degrees:?}");
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
        assert!(sound.iter().all(|f| f.verdict == Verdict::Agrees && !f.finding().warns()), "{sound:?}");
        // White noise is measured to per cents: less than half of it is not what the log says.
        let low = kalibr(0.45e-3, 0.45 * 2e-4, 0.9e-4, 2e-5);
        assert_eq!((low[0].verdict, low[0].finding().warns()), (Verdict::TooLow, true));
        assert!(
            low[0].finding().text.contains("2.2 times below the sensor's own noise"),
            "{}",
            low[0].finding().text
        );
        assert!(
            low[1].verdict == Verdict::Agrees && !low[1].finding().text.contains("agrees"),
            "{}",
            low[1].finding().text
        );
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
        // Who reads the instability off the plot takes its lowest point over .664: sqrt(2 N K / sqrt(3)) / .664.
        let instability = kalibr(1e-3, 2e-4, 1e-4, (2.0 * 1e-4 * 2e-5 / 3f64.sqrt()).sqrt() / 0.664);
        assert_eq!(instability[3].suspects.first(), Some(&"a bias instability where a walk belongs"));
        assert!(instability[3].finding().warns(), "{:?}", instability[3]);
        let zero = {
            let given = Given { rate: SampleRate::from_hz(100.0), keep_zeros: true, ..Given::default() };
            let text = "acc_n: 0.01\nacc_w: 0\ngyr_n: 0.001\ngyr_w: 2e-4\n";
            compare(&parse(text.as_bytes(), Path::new("f"), None, &given).unwrap(), &log)
        };
        assert_eq!(zero[1].verdict, Verdict::Zero);
        assert!(
            zero[1].finding().warns() && zero[1].finding().text.contains("put the sensor's figure there")
        );
        let vins = check("acc_n: 0.001\nacc_w: 0.002\ngyr_n: 0.001\ngyr_w: 2e-4\n");
        assert_eq!(vins[0].suspects[0], "a density where a deviation per sample belongs");
        assert_eq!((vins[1].verdict, vins[2].verdict), (Verdict::Agrees, Verdict::Agrees));
        assert!(
            vins[0].finding().text.contains("10 times below the sensor's own noise"),
            "{}",
            vins[0].finding().text
        );
        let deviation = check("AccelerometerNoise: 0.01\nGyroscopeNoise: 1e-6\n");
        assert_eq!(deviation[0].suspects[0], "a deviation where a variance belongs");
        assert_eq!(deviation[1].verdict, Verdict::Agrees);
    }
}
