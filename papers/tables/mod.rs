//! Every table, each a small function of rows: the paper's three with ours beside them, the study's, those of the injected experiment and
//! of times, and what `dpn eval` prints.

mod ate;
mod closed_loop;
mod fleet;
mod injected;
mod open_loop;
mod split;
mod study;
mod sweep;
mod timing;

pub use fleet::{fleet, fleet_platforms};
pub use open_loop::open_loop_rows;
pub use sweep::{ate, comparisons, consistency, summaries};

pub(super) use closed_loop::closed_loop;
pub(super) use injected::{responses, value};
pub(super) use open_loop::open_loop;
pub(super) use split::split;
pub(super) use study::study;
pub(super) use timing::timing;
