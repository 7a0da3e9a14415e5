//! What a recording looks like, simulated or real, in a few figures an axis, and two sets of recordings side by side.
//!
//! Residual: x - SG(51,3)(x) over the whole recording. Its deviation is taken over disjoint windows of one second. What
//! the vehicle does in a window is judged from the recording alone ([`recording::Activity`]), so that real flights, whose phases
//! nobody wrote down, are treated as simulated ones are.

pub(crate) mod recording;
pub(crate) mod table;
