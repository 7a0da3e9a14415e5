//! Variance components: while the odometry runs, the levels of its noise are learned from its own residuals.
//!
//! Nine levels multiply what is told: six of the inertial samples (accelerometer and gyroscope by axis), two of the biases' walks, one of
//! the pixels. When the oldest frame leaves the window, the interval and the sightings that go with it are as well known as they will ever be; each
//! is read then, once.
//!
//! # Inertial interval
//! With the covariance `Q = sum_k Q_k` of the interval by components, whitened by `S` (`S Q S^T = I`), the whitened residual `v`, its Jacobian `J`
//! by the states and their covariance `H^-1 = (L L^T)^-1` in the whole window, prior included, the residual's own covariance is
//! ```text
//! M = I - J H^-1 J^T = I - W^T W,   L W = J^T
//! ```
//! and the derivative of the restricted likelihood by the logarithm of component k's variance, with its expected curvature, is
//! ```text
//! g_k = (v^T C_k v - tr(M C_k))/2,   I_kl = tr(M C_k M C_l)/2,   C_k = S Q_k S^T
//! ```
//! `tr(M C_k)` is the redundancy of the component: the share of it that is left in the residual and not taken up by the states. That a whitened
//! residual should be 1 would be the wrong target: the states are fitted to the same residuals.
//!
//! # In time
//! `Learner` adds up `g` and `I` with exponential forgetting. An interval was weighed with the levels of its time (`Preintegration::levels`), so its
//! derivative is carried to the present ones by `I`. New levels go into all intervals of the window, integrated anew, once they differ enough: what
//! was weighed too firmly would else go on pulling for the two seconds until it leaves.
//!
//! Sources: Helmert's and Förstner's estimates, Koch 1986 (restricted likelihood), Teunissen and Amiri-Simkooei 2008 (LS-VCE). Not here: correlation
//! in time. Vibration is no white noise; what is learned is the white level that gives the interval the same error.

mod config;
mod inertial;
mod learner;
mod level;
mod pixels;
#[cfg(test)]
mod tests;

pub use config::ComponentsConfig;
pub(crate) use learner::Learner;
pub use learner::Levels;
pub use level::Level;
