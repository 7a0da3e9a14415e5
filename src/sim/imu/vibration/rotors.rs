//! Tones of the rotors: phi(t) = 2 pi integral of the rotor's speed; axis a reads, of harmonic h,
//!
//! A_h,a g_r,a e(t) (f / f_hover)^2 sqrt(2) sin(h phi(t) + psi_r,h,a)
//!
//! The phase is a smooth function of time and is sampled at the stamps, so what lies above half the rate aliases as it
//! does in the sensor: 2 x 91.5 Hz shows at 17 Hz, 3 x at 74.5 Hz. Imbalance forces grow with the square of the speed.
//! Rotors differ by fixed offsets and wander, hence they beat and together look like a band.

use super::config::{AMPLITUDE_WANDER_S, AxisVibration, SPEED_WANDER_S, VibrationConfig};
use crate::imu::ou::Wander;
use crate::imu::series::ImuSeries;
use dpn_core::random::Stream;
use rand::Rng;
use rand_distr::StandardNormal;
use std::f64::consts::{SQRT_2, TAU};

/// Harmonics of the rotor's speed that are heard.
const HARMONICS: usize = 3;

/// What the rotors of a flight follow.
pub(super) struct Turning<'a> {
    pub(super) config: &'a VibrationConfig,
    /// Accelerometer x, y, z, gyroscope x, y, z.
    pub(super) axes: &'a [AxisVibration; 6],
    /// Motors relative to hover, per sample.
    pub(super) speed: &'a [f64],
    /// A factor per sample.
    pub(super) loudness: &'a [f64],
    /// Time between samples \[s\].
    pub(super) dt: f64,
    pub(super) stream: &'a Stream,
}

/// One rotor: how its harmonics reach the six axes.
struct Rotor {
    offset: f64,
    phase: f64,
    /// `[accel x, y, z, gyro x, y, z][harmonic]`: amplitudes on the sine and the cosine of the harmonic's phase.
    reach: [[(f64, f64); HARMONICS]; 6],
    speed: Wander,
    loudness: Wander,
}

impl Rotor {
    fn new(config: &VibrationConfig, axes: &[AxisVibration; 6], dt: f64, stream: &Stream) -> Self {
        let mut rng = stream.named("place").rng();
        let offset: f64 = rng.sample(StandardNormal);
        let phase = rng.random_range(0.0..TAU);
        let share = SQRT_2 / f64::from(config.rotors).sqrt();
        let reach = axes.each_ref().map(|axis| {
            // How well this rotor is heard on this axis; the square of it is 1 in the mean.
            let gain = rng.random_range(0.7..1.3) / 1.03_f64.sqrt();
            std::array::from_fn(|h| {
                let psi = rng.random_range(0.0..TAU);
                let amplitude = axis.harmonics[h] * gain * share;
                (amplitude * psi.cos(), amplitude * psi.sin())
            })
        });
        Self {
            offset: config.rotor_spread * offset,
            phase,
            reach,
            speed: Wander::new(config.speed_wander, SPEED_WANDER_S, dt, stream.named("speed").rng()),
            loudness: Wander::new(
                config.amplitude_wander,
                AMPLITUDE_WANDER_S,
                dt,
                stream.named("loudness").rng(),
            ),
        }
    }
}

/// Adds all rotors' tones to `to`.
pub(super) fn add(of: &Turning<'_>, to: &mut ImuSeries) {
    let Turning { config, axes, speed, loudness, dt, stream } = *of;
    // exp of a normal of deviation s has a mean square of exp(2 s^2).
    let quiet = config.amplitude_wander.powi(2);
    for r in 0..config.rotors {
        let mut rotor = Rotor::new(config, axes, dt, &stream.named("rotor").index(u64::from(r)));
        let mut phase = rotor.phase;
        let mut turning = 0.0;
        for (i, &motors) in speed.iter().enumerate() {
            let relative = motors * (1.0 + rotor.offset + rotor.speed.next());
            // Trapezoidal rule: the speed is a random walk's relative, smooth on the scale of a sample.
            phase += TAU * config.hover_hz * 0.5 * (turning + relative) * dt;
            turning = relative;
            let swing = (rotor.loudness.next() - quiet).exp() * loudness[i] * relative * relative;
            if swing == 0.0 {
                continue;
            }
            let (sin, cos) = phase.sin_cos();
            let (mut s, mut c) = (sin, cos);
            for h in 0..HARMONICS {
                for (a, reach) in rotor.reach.iter().enumerate() {
                    let (on_sin, on_cos) = reach[h];
                    *to.value_mut(a, i) += swing * (on_sin * s + on_cos * c);
                }
                // sin and cos of the next multiple of the phase.
                (s, c) = (s * cos + c * sin, c * cos - s * sin);
            }
        }
    }
}
