//! Estimators against windows whose noise is known, beside the Cramer-Rao bound and the paper's rows.

mod cells;
mod job;
mod request;
mod rows;
mod run;

pub use request::{OpenLoopError, Request};
pub use rows::{Errors, Row, SigmaBin};
pub use run::run;
