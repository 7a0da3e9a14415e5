//! What the page in the browser asks of dpn: a log from a stream of bytes, and what `dpn check`, `dpn noise`, `dpn allan` and
//! `dpn noise convert` say with `--json`, made by the same calls.
//!
//! * [`Session`]: a log that was read, in a worker's memory.
//! * [`convert`]: figures of one program as another's.
//! * `picture`: a track thinned to what a picture can show.
//! * `source`: bytes that the page hands over as they are asked for.
//!
//! What is written here is glue; a number that is shown comes from a library.
#![cfg_attr(test, allow(clippy::unwrap_used))]

mod convert;
mod failure;
mod picture;
mod session;
mod source;

pub use convert::convert;
pub use session::Session;
pub use source::Source;
