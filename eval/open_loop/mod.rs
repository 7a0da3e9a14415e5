//! Estimators against windows whose noise is known, beside the Cramer-Rao bound and the paper's rows.

mod rows;

pub use rows::{Errors, Row, SigmaBin};
