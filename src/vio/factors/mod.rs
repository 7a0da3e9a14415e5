//! What ties the window's unknowns together: one kind of measurement a file, residual and derivatives.

pub mod inertial;
pub mod loss;
pub mod reprojection;
pub(crate) mod rest;
