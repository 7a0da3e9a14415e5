//! The rotors' tones of one flight, on top of what the frame does.

use super::config::{AMPLITUDE_WANDER_S, AXES, AxisVibration, VibrationConfig};
use super::motor_speed;
use super::rotors::{self, Turning};
use crate::flight::FlightPlan;
use crate::imu::ou::Wander;
use crate::imu::series::ImuSeries;
use dpn_core::SampleRate;
use dpn_core::random::Stream;

/// Vibration at each of `times` \[s after the flight's start\], which are `rate` apart but for the stamps' rounding.
pub(crate) fn draw(
    config: &VibrationConfig,
    plan: &FlightPlan,
    times: &[f64],
    rate: SampleRate,
    stream: &Stream,
) -> ImuSeries {
    let mut vibration = ImuSeries::zeros(times.len());
    if config.scale == 0.0 {
        return vibration;
    }
    let dt = rate.period();
    let axes = levels(config, plan);
    let speed: Vec<f64> = times.iter().map(|&t| motor_speed(plan, t)).collect();
    // Loudness of the whole frame: posture, battery, wind.
    let mut wander =
        Wander::new(config.amplitude_wander, 2.0 * AMPLITUDE_WANDER_S, dt, stream.named("loudness").rng());
    // exp of a normal of deviation s has a mean square of exp(2 s^2).
    let quiet = config.amplitude_wander.powi(2);
    let loudness: Vec<f64> = times.iter().map(|_| (wander.next() - quiet).exp()).collect();
    rotors::add(
        &Turning { config, axes: &axes, speed: &speed, loudness: &loudness, dt, stream },
        &mut vibration,
    );
    vibration
}

/// The axes' deviations in this flight: accelerometer x, y, z, gyroscope x, y, z.
pub(super) fn levels(config: &VibrationConfig, plan: &FlightPlan) -> [AxisVibration; 6] {
    let character = plan.flight.character();
    std::array::from_fn(|a| {
        let axis = AXES[a];
        let level = if a < 3 { character.accel_level[a] } else { character.gyro_level[a - 3] };
        let factor = config.scale * level;
        AxisVibration {
            harmonics: axis.harmonics.map(|v| v * factor),
            low_line: axis.low_line * factor,
            broad_band: axis.broad_band * factor,
            ..axis
        }
    })
}

#[cfg(test)]
mod tests {
    use super::super::config::SILENT;
    use super::*;
    use crate::flight::{Flight, Phase};

    /// Vibration of a flight at 200 Hz, and the phase of each sample.
    fn vibration(flight: Flight, config: &VibrationConfig) -> (ImuSeries, Vec<Phase>) {
        let plan = FlightPlan::new(flight, 3);
        let n = (plan.phases.duration() * 200.0) as usize;
        let times: Vec<f64> = (0..n).map(|i| i as f64 * 0.005).collect();
        let phases = times.iter().map(|&t| plan.phases.at(t)).collect();
        let series = draw(config, &plan, &times, SampleRate::HZ_200, &Stream::new(3));
        (series, phases)
    }

    fn deviation(series: &ImuSeries, phases: &[Phase], wanted: Phase) -> [f64; 6] {
        let picked: Vec<usize> = (0..phases.len()).filter(|&i| phases[i] == wanted).collect();
        std::array::from_fn(|a| {
            let of = |i: usize| {
                if a < 3 { series.accel[i][a] } else { series.gyro[i][a - 3] }
            };
            (picked.iter().map(|&i| of(i).powi(2)).sum::<f64>() / picked.len() as f64).sqrt()
        })
    }

    #[test]
    fn it_comes_with_the_motors_and_is_exactly_nothing_without_them() {
        let (series, phases) = vibration(Flight::RoomMedium, &VibrationConfig::default());
        for (i, phase) in phases.iter().enumerate() {
            if !phase.motors_on() {
                assert_eq!((series.accel[i], series.gyro[i]), ([0.0; 3], [0.0; 3]));
            }
        }
        let (idle, flying) =
            (deviation(&series, &phases, Phase::IdleBefore), deviation(&series, &phases, Phase::Flying));
        // .4 of the speed is .16 of the force, and the low line is there already: accelerometer x, z are mostly tones.
        for a in [0, 2] {
            assert!((0.1..0.45).contains(&(idle[a] / flying[a])), "{a}: {idle:?} {flying:?}");
        }
    }

    /// All tones of the rotors together.
    fn tones(axis: &AxisVibration) -> f64 {
        axis.harmonics.iter().map(|v| v * v).sum::<f64>().sqrt()
    }

    #[test]
    fn in_flight_every_axis_has_the_deviation_its_configuration_says() {
        let config = VibrationConfig::default();
        let mut powers = [0.0; 6];
        for flight in Flight::ALL {
            let (series, phases) = vibration(flight, &config);
            let flying = deviation(&series, &phases, Phase::Flying);
            let levels = levels(&config, &FlightPlan::new(flight, 3));
            for a in 0..6 {
                powers[a] += (flying[a] / tones(&levels[a])).powi(2) / 11.0;
            }
        }
        // A flight's power scatters by 14 % through the gains of its six rotors (34 % each), by more through slow
        // loudness (a dozen correlation times at .12) and thrust: the mean of eleven by about 9 %. Three of it.
        assert!(powers.iter().all(|power| (power - 1.0).abs() < 0.27), "{powers:?}");
    }

    #[test]
    fn harmonics_above_half_the_rate_alias_where_they_must() {
        // One rotor that neither wanders nor is joined by anything: 91.5 Hz, and 2 x 91.5 at 200 - 183 = 17 Hz.
        let config = VibrationConfig {
            rotors: 1,
            rotor_spread: 0.0,
            speed_wander: 0.0,
            amplitude_wander: 0.0,
            ..VibrationConfig::default()
        };
        let mut axes = [SILENT; 6];
        axes[0].harmonics = [0.0, 1.0, 0.0];
        let n = 2000;
        let mut series = ImuSeries::zeros(n);
        let (ones, stream) = (vec![1.0; n], Stream::new(1));
        let (config, axes, speed, loudness) = (&config, &axes, &ones, &ones);
        let of = Turning { config, axes, speed, loudness, dt: 0.005, stream: &stream };
        rotors::add(&of, &mut series);
        let power = |hz: f64| {
            let (mut re, mut im) = (0.0, 0.0);
            for (i, v) in series.accel.iter().enumerate() {
                let angle = std::f64::consts::TAU * hz * 0.005 * i as f64;
                re += v[0] * angle.cos();
                im += v[0] * angle.sin();
            }
            (re * re + im * im) / (n * n) as f64
        };
        let total = series.accel.iter().map(|v| v[0] * v[0]).sum::<f64>() / n as f64;
        // A sine of mean square m has m / 2 in the positive frequency; 183 Hz and 17 Hz are the same samples.
        assert!((power(17.0) / (0.5 * total) - 1.0).abs() < 0.01);
        assert!(power(91.5) < 1e-3 * total);
    }
}
