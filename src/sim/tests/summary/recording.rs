//! The figures of one recording.

use dpn_core::signal::stats::{Ddof, deviation, excess_kurtosis, median, quantiles};
use dpn_core::signal::{FilterError, Peak, SavitzkyGolay, SpectrumError, Welch};
use dpn_core::{ImuRecording, Sensor};
use thiserror::Error;

/// Why there is no summary.
#[derive(Debug, Clone, PartialEq, Error)]
pub(crate) enum SummaryError {
    /// Not one window.
    #[error("{samples} samples are less than {needed}, the second or the filter's window a summary needs")]
    TooShort {
        /// Samples there are.
        samples: usize,
        /// Samples needed.
        needed: usize,
    },
    /// The smoothing filter refused.
    #[error(transparent)]
    Filter(#[from] FilterError),
    /// The spectrum refused.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
}

/// What the vehicle seems to do in a window, by the accelerometer's residual deviation, root of the sum over axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Activity {
    /// Below .12 m/s^2: nothing moves (the data sheet gives .049).
    Quiet,
    /// In between: motors idling, or handled.
    Stirring,
    /// Above .75 m/s^2: motors at work.
    Running,
}

impl Activity {
    /// All three.
    pub(crate) const ALL: [Self; 3] = [Self::Quiet, Self::Stirring, Self::Running];

    fn of(deviation: f64) -> Self {
        match deviation {
            d if d < 0.12 => Self::Quiet,
            d if d < 0.75 => Self::Stirring,
            _ => Self::Running,
        }
    }
}

/// A spectral line and the band around it, in the windows where motors run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Line {
    /// Highest point of 60 to 100 Hz; none where nothing is above zero.
    pub(crate) high: Option<Peak>,
    /// Highest point of 20 to 45 Hz.
    pub(crate) low: Option<Peak>,
    /// Share of 60 to 100 Hz in the power from 20 to 100 Hz.
    pub(crate) high_share: f64,
}

/// One axis of one sensor, in its unit.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AxisSummary {
    /// Median over all windows of the residual's deviation.
    pub(crate) deviation: f64,
    /// The same over the windows of each [`Activity`]; none where there is no such window.
    pub(crate) by_activity: [Option<f64>; 3],
    /// Quantiles .5, .9, .99, .999 of |residual| / its window's deviation where motors run; .674, 1.645, 2.576, 3.291
    /// for a normal variable. Empty where they never run.
    pub(crate) quantiles: Vec<f64>,
    /// Excess kurtosis of the same.
    pub(crate) excess_kurtosis: f64,
    /// Peaks where motors run; none below two seconds of it.
    pub(crate) line: Option<Line>,
}

/// One recording.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RecordingSummary {
    /// Windows of each [`Activity`].
    pub(crate) windows: [usize; 3],
    /// Accelerometer x, y, z \[m/s^2\].
    pub(crate) accel: [AxisSummary; 3],
    /// Gyroscope x, y, z \[rad/s\].
    pub(crate) gyro: [AxisSummary; 3],
}

impl RecordingSummary {
    /// The axes of one sensor.
    pub(crate) fn of(&self, sensor: Sensor) -> &[AxisSummary; 3] {
        match sensor {
            Sensor::Accel => &self.accel,
            Sensor::Gyro => &self.gyro,
        }
    }
}

/// Summarises `recording`. The last, broken second is left out.
///
/// # Errors
/// Less than a second, or less than the filter's 51 samples.
pub(crate) fn summarise(recording: &ImuRecording) -> Result<RecordingSummary, SummaryError> {
    let window = recording.rate().hz().round() as usize;
    let needed = window.max(51);
    if window == 0 || recording.len() < needed {
        return Err(SummaryError::TooShort { samples: recording.len(), needed });
    }
    let filter = SavitzkyGolay::new(51, 3)?;
    let residual = |sensor, axis| -> Result<Vec<f64>, FilterError> {
        let x = recording.axis(sensor, axis);
        let smooth = filter.smooth(&x)?;
        Ok(x.iter().zip(smooth).map(|(x, s)| x - s).collect())
    };
    let of = |sensor| -> Result<[Vec<f64>; 3], FilterError> {
        Ok([residual(sensor, 0)?, residual(sensor, 1)?, residual(sensor, 2)?])
    };
    let (accel, gyro) = (of(Sensor::Accel)?, of(Sensor::Gyro)?);
    let deviations =
        |r: &Vec<f64>| -> Vec<f64> { r.chunks_exact(window).map(|w| deviation(w, Ddof::Zero)).collect() };
    let shaken = accel.each_ref().map(deviations);
    let activity: Vec<Activity> = (0..recording.len() / window)
        .map(|i| Activity::of(shaken.iter().map(|axis| axis[i] * axis[i]).sum::<f64>().sqrt()))
        .collect();

    let axis = |sensor, index, residual: &Vec<f64>| {
        let x = recording.axis(sensor, index);
        summarise_axis(recording, &x, residual, &deviations(residual), &activity)
    };
    Ok(RecordingSummary {
        windows: Activity::ALL.map(|a| activity.iter().filter(|&&b| a == b).count()),
        accel: [
            axis(Sensor::Accel, 0, &accel[0])?,
            axis(Sensor::Accel, 1, &accel[1])?,
            axis(Sensor::Accel, 2, &accel[2])?,
        ],
        gyro: [
            axis(Sensor::Gyro, 0, &gyro[0])?,
            axis(Sensor::Gyro, 1, &gyro[1])?,
            axis(Sensor::Gyro, 2, &gyro[2])?,
        ],
    })
}

fn summarise_axis(
    recording: &ImuRecording,
    x: &[f64],
    residual: &[f64],
    deviations: &[f64],
    activity: &[Activity],
) -> Result<AxisSummary, SummaryError> {
    let window = recording.rate().hz().round() as usize;
    let pick = |wanted: Activity| -> Vec<f64> {
        let chosen = deviations.iter().zip(activity).filter(|&(_, a)| *a == wanted);
        chosen.map(|(&d, _)| d).collect()
    };
    // The running windows one after another; the seams between stretches are few.
    let running = |signal: &[f64]| -> Vec<(usize, f64)> {
        let windows = signal.chunks_exact(window).enumerate();
        windows
            .filter(|&(i, _)| activity[i] == Activity::Running)
            .flat_map(|(i, w)| w.iter().map(move |&v| (i, v)))
            .collect()
    };
    let standardised: Vec<f64> = running(residual)
        .into_iter()
        .filter(|&(i, _)| deviations[i] > 0.0)
        .map(|(i, v)| v / deviations[i])
        .collect();
    let absolute: Vec<f64> = standardised.iter().map(|v| v.abs()).collect();
    let moving: Vec<f64> = running(x).into_iter().map(|(_, v)| v).collect();
    let line = if moving.len() >= 2 * window {
        let spectrum = Welch::new(2 * window)?.spectrum(&moving, recording.rate())?;
        Some(Line {
            high: spectrum.peak(60.0, 100.0),
            low: spectrum.peak(20.0, 45.0),
            high_share: spectrum.band_power(60.0, 100.0) / spectrum.band_power(20.0, 100.0),
        })
    } else {
        None
    };
    Ok(AxisSummary {
        deviation: median(deviations),
        by_activity: Activity::ALL.map(|a| {
            let chosen = pick(a);
            (!chosen.is_empty()).then(|| median(&chosen))
        }),
        quantiles: if absolute.is_empty() { vec![] } else { quantiles(&absolute, &[0.5, 0.9, 0.99, 0.999]) },
        excess_kurtosis: excess_kurtosis(&standardised),
        line,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::{ImuSample, Stamp};
    use dpn_sim::imu::WhiteConfig;
    use dpn_sim::{Flight, FlightConfig, simulate};

    #[test]
    fn white_noise_alone_shows_its_deviation_and_a_normal_shape() {
        // Known deviations, no motors: everything is Quiet and nothing has a line.
        let white = WhiteConfig { schedule: false, ..WhiteConfig::default() };
        let config = FlightConfig { white, ..FlightConfig::ideal() };
        let flight = simulate(Flight::Hover, 5, &config).unwrap();
        let summary = summarise(&flight.recording).unwrap();
        assert_eq!(summary.windows[2], 0);
        // SG(51,3) keeps 1 - 9/4 / 51 of the variance in the residual (leading order); the medians of 97 windows of
        // 200 samples have a standard error of 1.25 x 5 % / sqrt(97) = .6 %.
        let gain = SavitzkyGolay::new(51, 3).unwrap().residual_gain(flight.recording.len());
        for axis in 0..3 {
            let accel = summary.accel[axis].deviation / (0.028_284 * gain);
            let gyro = summary.gyro[axis].deviation / (0.002_399_6 * gain);
            assert!((accel - 1.0).abs() < 0.03, "{accel}");
            assert!((gyro - 1.0).abs() < 0.03, "{gyro}");
            assert!(summary.accel[axis].line.is_none() && summary.accel[axis].quantiles.is_empty());
        }
    }

    #[test]
    fn a_tone_is_found_where_it_is_with_the_share_it_has() {
        // 90 Hz and 30 Hz with powers 9 : 1 on accelerometer x, 30 Hz alone on y.
        let samples = (0..4000)
            .map(|i| {
                let t = f64::from(i) * 0.005;
                let tone = |hz: f64| (std::f64::consts::TAU * hz * t).sin();
                ImuSample {
                    t: Stamp::from_ns(i64::from(i) * 5_000_000),
                    gyro: [0.0; 3],
                    accel: [3.0 * tone(90.0) + tone(30.0), tone(30.0), 9.81],
                }
            })
            .collect();
        let summary = summarise(&ImuRecording::new(samples).unwrap()).unwrap();
        assert_eq!(summary.windows, [0, 0, 20]);
        let line = summary.accel[0].line.unwrap();
        assert!((line.high.unwrap().hz - 90.0).abs() < 0.05);
        assert!((line.low.unwrap().hz - 30.0).abs() < 0.05);
        assert!((line.high_share - 0.9).abs() < 1e-3);
        assert!(summary.accel[1].line.unwrap().high_share < 1e-3);
        // A sine's absolute value has the median sin(pi/4) of its amplitude: 1 deviation; and excess kurtosis -1.5.
        assert!((summary.accel[1].quantiles[0] - 1.0).abs() < 0.06);
        assert!((summary.accel[1].excess_kurtosis + 1.5).abs() < 0.05);
    }

    #[test]
    fn a_recording_below_a_second_has_no_summary() {
        let flight = simulate(Flight::Hover, 5, &FlightConfig::default()).unwrap();
        let short = ImuRecording::new(flight.recording.samples()[..150].to_vec()).unwrap();
        assert_eq!(summarise(&short), Err(SummaryError::TooShort { samples: 150, needed: 200 }));
    }

    #[test]
    fn simulated_flights_lie_in_the_ranges_measured_on_euroc() {
        // Medians over a sequence's windows, over the eleven sequences of EuRoC, widened by 15 %: the rotors' random
        // gains move a flight's deviation by 7 %.
        let accel = [(1.0, 1.7), (0.44, 0.68), (0.65, 0.96)];
        let gyro = [(0.021, 0.038), (0.048, 0.090), (0.037, 0.053)];
        let flights = [1, 8].map(|seed| dpn_sim::simulate_all(seed, &FlightConfig::default()).unwrap());
        for flight in flights.iter().flatten() {
            let summary = summarise(&flight.recording).unwrap();
            for (sensor, ranges) in [(Sensor::Accel, accel), (Sensor::Gyro, gyro)] {
                for (axis, (low, high)) in ranges.into_iter().enumerate() {
                    let found = summary.of(sensor)[axis].by_activity[2].unwrap();
                    assert!(
                        (0.85 * low..=1.15 * high).contains(&found),
                        "{} {sensor} {axis}: {found}",
                        flight.name()
                    );
                }
                let quiet = summary.of(sensor)[0].by_activity[0].unwrap();
                let sheet = match sensor {
                    Sensor::Accel => 0.0283,
                    Sensor::Gyro => 0.0024,
                };
                assert!((quiet / sheet - 1.0).abs() < 0.1, "{} at rest: {quiet}", flight.name());
            }
            // Lines: 80 to 100 Hz on accelerometer x, z and gyroscope y; 24 to 31 Hz on accelerometer y, gyroscope x.
            for (sensor, axis) in [(Sensor::Accel, 0), (Sensor::Accel, 2), (Sensor::Gyro, 1)] {
                let line = summary.of(sensor)[axis].line.unwrap();
                assert!((80.0..100.0).contains(&line.high.unwrap().hz), "{line:?}");
                assert!((0.5..0.95).contains(&line.high_share), "{} {line:?}", flight.name());
            }
            for (sensor, axis) in [(Sensor::Accel, 1), (Sensor::Gyro, 0)] {
                let line = summary.of(sensor)[axis].line.unwrap();
                assert!((24.0..31.0).contains(&line.low.unwrap().hz), "{} {line:?}", flight.name());
            }
        }
    }
}
