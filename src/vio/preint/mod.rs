//! Pre-integration: what the IMU says of the motion between two instants, as one measurement, its covariance and its
//! dependence on the biases. The noise comes with every sample, stays beside it, and is used again when the interval
//! is integrated anew or merged with the next.
//!
//! # Mean
//! Over the step `dt` from sample 0 to sample 1, with `w = (gyro_0 + gyro_1)/2 - bg` and `f_k = accel_k - ba`:
//! ```text
//! gamma <- gamma Exp(w dt)
//! a      = (gamma_0 f_0 + gamma_1 f_1)/2
//! alpha <- alpha + beta dt + a dt^2/2
//! beta  <- beta + a dt
//! ```
//! `gamma` is [`Delta::rotation`] (`body_i_from_body_j`), `beta` [`Delta::velocity`], `alpha` [`Delta::position`], both
//! in the frame of body i and free of gravity: with `T` the duration and `g = (0, 0, -9.81)` in the world,
//! ```text
//! R_j = R_i gamma     v_j = v_i + g T + R_i beta     p_j = p_i + v_i T + g T^2/2 + R_i alpha
//! ```
//!
//! # First order
//! `x = (position, rotation, velocity)` is the true increment minus the computed one, the rotation on the right
//! (`gamma_true = gamma Exp(theta)`), and `b` the true bias minus the one integrated with. Differentiating the step
//! itself, with `R_k = gamma_k`, `J = Jr(w dt) dt` and `K = -(R_0 hat(f_0) + R_1 hat(f_1) Exp(-w dt))/2`:
//! ```text
//! theta <- Exp(-w dt) theta - J bg
//! s      = dt K theta + dt/2 R_1 hat(f_1) J bg - dt/2 (R_0 + R_1) ba
//! v     <- v + s
//! p     <- p + dt v + dt/2 s
//! ```
//! that is `x <- F x + B b`. The bias Jacobian obeys the same with `b = I`: `J <- F J + B`. It is the derivative of what
//! is computed, to rounding, not of a continuous idealisation. The noise of each reading acts as half a bias: sample 0's
//! gyro enters by `B_g/2`, its accelerometer by `(dt/2 R_0)` in `s`, sample 1's by `B_g/2` and `(dt/2 R_1)`: below `G_0`
//! and `G_1`.
//!
//! # Covariance
//! [`ImuCov`] names three models. The samples' deviations `Q_k` are per sample (no density); the biases walk with the
//! densities of [`PreintegrationConfig`], so that under all three their variance grows by `density^2` a second.
//! * [`ImuCov::Exact`]: noise drawn once a sample. Neighbouring steps share a sample, hence its draw; its weight is the sum
//!   of what both steps give it, `W_k = F G_1 + G_0` (`F`, `G_0` of the later step):
//!   `P <- F P F^T + W_k Q_k W_k^T`, and the last sample, half used, is added at the end by `G_1 Q G_1^T`.
//!   Sample k reads the bias as it is at k: the walk's increment `u` over the step enters that step through sample 1 already.
//! * [`ImuCov::Vins`]: VINS-Mono's. Each step draws the noise of both its samples anew,
//!   `P <- F P F^T + G_0 Q_0 G_0^T + G_1 Q_1 G_1^T`: two independent draws of weight 1/2 in place of one of weight 1 count half of
//!   the variance of rotation and velocity, and of position. The walk enters from the next step on. Two differences to VINS-Mono: `Exp`
//!   and `Jr` in place of their first-order terms (relative error `|w| dt`), and a walk of constant density, which
//!   equals VINS-Mono's `acc_w dt` a step at one rate, the 200 Hz of its constants.
//! * [`ImuCov::Euler`]: the paper's `P <- (I + F dt) P (I + F dt)^T + (G dt) Q (G dt)^T`, where `F` and `G` are the continuous ones at sample
//!   0 (`theta' = -hat(w_0) theta - bg - n_g`, `v' = -R_0 hat(f_0) theta - R_0 (ba + n_a)`, `p' = v`) and `Q = Q_0`: each sample but
//!   the last counts once, in full. The mean and the bias Jacobian remain those of the mid-point.
//!
//! Two intervals that meet in one sample each give it half a weight and treat its two halves as independent: of `n` steps
//! 1/2 of a sample's variance is missing (2.5 % at 20 steps) under `exact`, and comes back when the intervals are merged.
//!
//! Sources: Forster et al. 2017 (right Jacobians, bias update), Qin et al. 2018, sec. IV-B (increments in the first body frame,
//! mid-point). The weights are derived here. Not here: the residual between two states ([`crate::factors::inertial`]).

mod config;
mod covariance;
mod delta;
mod interval;
mod levels;
mod linear;
#[cfg(test)]
mod monte_carlo;
mod sample;
#[cfg(test)]
pub(crate) mod testing;

pub use config::{ImuCov, PreintegrationConfig};
pub use delta::Delta;
pub use interval::Preintegration;
pub(crate) use levels::{ACCEL_WALK, GYRO_WALK};
pub use levels::{COMPONENTS, NoiseLevels};
pub use sample::NoisySample;
