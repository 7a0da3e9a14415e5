//! Constants of the network's definition that are no keys of its configuration.

/// Added to a variance before its root is taken, as PyTorch does.
pub const NORM_EPSILON: f32 = 1e-5;
/// Added to a channel's mean square before its root is taken.
pub const POOL_EPSILON: f32 = 1e-8;
/// Where the head `log-sigma` clamps its exponent.
pub const LOG_SIGMA_RANGE: (f32, f32) = (-10.0, 5.0);
/// Where the head `log-sigma-and-spread` clamps its second exponent: a spread of .7 % to a factor of 1600.
pub const LOG_SPREAD_RANGE: (f32, f32) = (-5.0, 2.0);
