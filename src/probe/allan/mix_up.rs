//! What a wrong number may be: a right one written down in another meaning or unit.

use dpn_core::noise::Meaning;
use dpn_core::noise::{Axes, Figure, ImuFigures};
use dpn_core::{SampleRate, Sensor};

/// How near a mix-up's own factor must be to explain what stands there.
const NEAR: f64 = 2.0;
/// How far from [`typical`] a figure is nobody's.
const FAR: f64 = 2.0;
/// Mix-ups that are named, the nearest first: by a measured figure, and where many fit.
const NAMED: [usize; 2] = [2, 3];

/// The mix-up whose factor, a hundred, is that of rotors too.
pub(crate) const MG: &str = "mg where m/s^2 belongs";

/// What is written is `factor * right^power`.
struct MixUp {
    factor: f64,
    power: f64,
    words: &'static str,
}

/// Densities of the MEMS IMUs that people fly and carry, lowest and highest.
///
/// White noise: data sheets from ADIS16495 and HG4930 (20 ug/sqrt(Hz), .04 deg/sqrt(h)) to MPU-6050 and ADIS16448 (400 ug/sqrt(Hz),
/// .0135 deg/s/sqrt(Hz)). Walks, which data sheets do not have: published calibrations and defaults, from VINS-Mono's at 200 Hz to EuRoC's
/// `sensor.yaml` (accelerometer) and Basalt's calibration of it (gyroscope).
pub(crate) fn typical(figure: Figure) -> [f64; 2] {
    match figure {
        Figure::AccelWhite => [2e-4, 4e-3],
        Figure::GyroWhite => [1.2e-5, 2.4e-4],
        Figure::AccelWalk => [2.5e-6, 3e-3],
        Figure::GyroWalk => [1.2e-7, 1e-4],
    }
}

/// Whether a density is more than twice outside [`typical`].
pub(crate) fn unusual(figure: Figure, density: f64) -> bool {
    let [low, high] = typical(figure);
    density < low / FAR || density > high * FAR
}

/// What `configured` would be, were one of the `right` values (in `meaning`, with their own words where they are not the figure itself)
/// written down by mistake.
pub(crate) fn by_measured(
    figure: Figure,
    meaning: Meaning,
    configured: f64,
    right: f64,
    rate: SampleRate,
    others: &[(f64, &'static str)],
) -> Vec<&'static str> {
    let off = |value: f64| (configured / value).ln().abs();
    let mut near: Vec<(f64, &'static str)> = mix_ups(figure, meaning, rate)
        .into_iter()
        .map(|m| (m.factor * right.powf(m.power), m.words))
        .chain(others.iter().copied())
        .filter(|(value, _)| *value > 0.0 && off(*value) < NEAR.ln())
        .map(|(value, words)| (off(value), words))
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    near.into_iter().take(NAMED[0]).map(|(_, words)| words).collect()
}

/// Mix-ups behind which a [`typical`] figure would stand, where nothing was measured: the nearer to the middle, the earlier.
pub(crate) fn by_typical(
    figure: Figure,
    meaning: Meaning,
    configured: f64,
    rate: SampleRate,
) -> Vec<&'static str> {
    let [low, high] = typical(figure);
    let middle = (low * high).sqrt();
    let mut near: Vec<(f64, &'static str)> = mix_ups(figure, meaning, rate)
        .into_iter()
        .filter_map(|m| {
            let mut figures = ImuFigures::default();
            let right = (configured / m.factor).powf(1.0 / m.power);
            figures.set(figure, meaning, Axes::Same(right), rate).ok()?;
            let density = figures.density(figure)?.largest();
            ((low..=high).contains(&density)).then(|| ((density / middle).ln().abs(), m.words))
        })
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    near.into_iter().take(NAMED[1]).map(|(_, words)| words).collect()
}

fn mix_ups(figure: Figure, meaning: Meaning, rate: SampleRate) -> Vec<MixUp> {
    const DEGREES: f64 = 180.0 / std::f64::consts::PI;
    const G: f64 = 9.806_65;
    let root = rate.hz().sqrt();
    let mut all = Vec::new();
    let mut add = |factor: f64, power: f64, words| all.push(MixUp { factor, power, words });
    match meaning {
        Meaning::Density => {
            add(1.0, 2.0, "a variance where a deviation belongs");
            add(root, 1.0, "a deviation per sample where a density belongs");
        }
        Meaning::SampleStd => {
            add(1.0, 2.0, "a variance where a deviation belongs");
            add(1.0 / root, 1.0, "a density where a deviation per sample belongs");
        }
        Meaning::SampleVariance => {
            add(1.0, 0.5, "a deviation where a variance belongs");
            add(1.0 / rate.hz(), 1.0, "a power density where a variance per sample belongs");
            add(1.0 / root, 0.5, "a density where a variance per sample belongs");
        }
        Meaning::Power => add(1.0, 0.5, "a density where its square belongs"),
        Meaning::WalkDensity => {
            add(1.0, 2.0, "a variance where a deviation belongs");
            add(1.0 / root, 1.0, "a walk per sample where a density belongs");
            add(root, 1.0, "a walk of VINS's kind where a density belongs");
        }
        Meaning::WalkStepVariance => {
            add(1.0, 0.5, "a deviation where a variance belongs");
            add(rate.hz(), 1.0, "a power density where a variance per sample belongs");
        }
        Meaning::WalkRateStd => {
            add(1.0, 2.0, "a variance where a deviation belongs");
            add(1.0 / root, 1.0, "a density where VINS's kind of walk belongs");
        }
    }
    let squared = matches!(meaning, Meaning::SampleVariance | Meaning::WalkStepVariance | Meaning::Power);
    let power = if squared { 2 } else { 1 };
    match figure.sensor() {
        Sensor::Gyro => {
            add(DEGREES.powi(power), 1.0, "degrees where radians belong");
            add(DEGREES.powi(-power), 1.0, "radians turned into radians once more");
        }
        Sensor::Accel => {
            add(G.powi(-power), 1.0, "g where m/s^2 belongs");
            add((1e3 / G).powi(power), 1.0, MG);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mix_up_of_a_usual_imu_is_named_without_a_measurement_and_the_usual_imu_is_not() {
        let rate = SampleRate::HZ_200;
        let of = |figure, meaning, value| by_typical(figure, meaning, value, rate);
        let first = |figure, meaning, value: f64| of(figure, meaning, value).first().copied();
        // EuRoC's figures.
        let (accel, gyro) = (2e-3, 1.7e-4);
        assert_eq!(
            first(Figure::AccelWhite, Meaning::Density, accel * 200f64.sqrt()),
            Some("a deviation per sample where a density belongs")
        );
        assert_eq!(
            first(Figure::GyroWhite, Meaning::Density, gyro * 57.3),
            Some("degrees where radians belong")
        );
        assert_eq!(
            first(Figure::AccelWhite, Meaning::Density, accel * accel),
            Some("a variance where a deviation belongs")
        );
        assert!(!unusual(Figure::AccelWhite, accel) && !unusual(Figure::GyroWhite, gyro));
        assert!(
            unusual(Figure::AccelWhite, accel * 200f64.sqrt()) && unusual(Figure::GyroWhite, gyro * 57.3)
        );
        // A walk in degrees.
        assert!(unusual(Figure::GyroWalk, 1.94e-5 * 57.3));
        assert!(
            of(Figure::GyroWalk, Meaning::WalkDensity, 1.94e-5 * 57.3)
                .contains(&"degrees where radians belong")
        );
    }

    #[test]
    fn a_measured_figure_names_the_factor_that_leads_to_it() {
        let rate = SampleRate::HZ_200;
        let said = by_measured(Figure::AccelWhite, Meaning::SampleVariance, 0.0283, 8e-4, rate, &[]);
        assert_eq!(said.first(), Some(&"a deviation where a variance belongs"));
        let said =
            by_measured(Figure::GyroWalk, Meaning::WalkDensity, 7e-5, 1.9e-5, rate, &[(7.1e-5, "a floor")]);
        assert_eq!(said, ["a floor"]);
    }
}
