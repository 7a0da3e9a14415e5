//! Timings of the kernels that matter.
