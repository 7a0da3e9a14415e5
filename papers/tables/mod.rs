//! Every table, each a small function of rows: the paper's three with ours beside them, the study's, those of the injected experiment and
//! of times, and what `dpn eval` prints.

mod ate;
mod closed_loop;
mod comparison;
mod fleet;
mod injected;
mod networks;
mod open_loop;
mod pairs;
mod split;
mod study;
mod sweep;
mod timing;

pub use fleet::{fleet, fleet_platforms};
pub use open_loop::open_loop_rows;
pub use sweep::{ate, comparisons, consistency, doubts, summaries};

pub(super) use closed_loop::closed_loop;
pub(super) use injected::{courses, responses};
pub(super) use networks::networks;
pub(super) use open_loop::open_loop;
pub(super) use pairs::pairs;
pub(super) use split::split;
pub(super) use study::study;
pub(super) use timing::timing;
