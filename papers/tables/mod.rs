//! The tables: the paper's three with ours beside them, the study's, those of the injected experiment, and times.

mod closed_loop;
mod injected;
mod open_loop;
mod split;
mod study;
mod timing;

pub(super) use closed_loop::closed_loop;
pub(super) use injected::{responses, value};
pub(super) use open_loop::open_loop;
pub(super) use split::split;
pub(super) use study::study;
pub(super) use timing::timing;
