//! What ties the window's unknowns together: one kind of residual a file, with its Jacobians.

pub mod inertial;
