//! The vibration of one flight, all parts together.

use super::config::{AxisVibration, VibrationConfig};
use super::{frame, motor_speed, rotors};
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
    let speed: Vec<f64> = times.iter().map(|&t| motor_speed(config, plan, t)).collect();
    // Loudness of the whole frame: posture, battery, wind.
    let mut wander = Wander::new(
        config.amplitude_wander,
        2.0 * config.amplitude_wander_s,
        dt,
        stream.named("loudness").rng(),
    );
    let loudness: Vec<f64> = times.iter().map(|_| wander.next().exp()).collect();
    rotors::add(config, &axes, &speed, &loudness, dt, stream, &mut vibration);
    frame::add_low_line(config, &axes, &speed, dt, stream, &mut vibration);
    frame::add_broad_band(config, &axes, &speed, &loudness, dt, stream, &mut vibration);
    vibration
}

/// The axes' deviations in this flight: accelerometer x, y, z, gyroscope x, y, z.
fn levels(config: &VibrationConfig, plan: &FlightPlan) -> [AxisVibration; 6] {
    let character = plan.flight.character();
    std::array::from_fn(|a| {
        let (axis, level) = if a < 3 {
            (config.accel[a], character.accel_level[a])
        } else {
            (config.gyro[a - 3], character.gyro_level[a - 3])
        };
        let factor = config.scale * level;
        AxisVibration {
            harmonics: axis.harmonics.map(|v| v * factor),
            low_line: axis.low_line * factor,
            broad_band: axis.broad_band * factor,
        }
    })
}
