//! Estimators against windows whose noise is known, beside the Cramer-Rao bound and the paper's rows.

mod rows;
mod run;

pub use rows::{Errors, Row, SigmaBin};
pub use run::{Drawn, OpenLoop, OpenLoopError, Request, run};
