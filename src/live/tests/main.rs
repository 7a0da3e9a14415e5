//! Watched runs under chance and for an hour, in one process: a clock that is moved, images that are rendered once, an estimator that is quick.
#![allow(clippy::unwrap_used)]

mod chaos;
mod flown;
mod hour;
