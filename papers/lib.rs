//! The paper again, from data: networks, open loop, closed loop, injected noise, tables, figures, one page.
//!
//! [`Paper::run`] goes through the stages in order. A stage is a function of its inputs; its *id* is a checksum of them (program, plan,
//! data, networks), and its results lie in a folder of that name, so that what was made from other inputs is neither used nor lost. A
//! stage that was broken off goes on. Tables and figures carry the ids of the runs they are made from and the command.
//!
//! * [`Plan`]: what is run; quick or whole.
//! * [`Input`]: recordings that are there, and what is missing.
//! * `results`: every stage's results, read or made.
//! * [`tables`]: every table, from rows; those that `dpn eval` prints too.
//! * [`LogReport`]: a page of another kind, what logs say of their IMU (`dpn report`).
//! * [`LoopPage`]: a closed loop's tables and figure (`dpn eval --closed-loop`).
//! * `drawings`: the figures; `findings` and `page`: the page that tells the story, from `templates/`.

#![cfg_attr(test, allow(clippy::unwrap_used))]

mod asked;
mod cache;
mod drawings;
mod error;
mod findings;
mod forest;
mod id;
mod injected;
mod input;
mod log_report;
mod loop_page;
mod motors;
mod overall;
mod page;
mod paper;
mod plan;
mod results;
mod run;
mod specs;
mod states;
pub mod tables;
mod verdict;

pub use asked::{Opened, PaperPlan};
pub use drawings::loop_curve;
pub use error::PaperError;
pub use id::id;
pub use input::{CameraChoice, Input, Missing};
pub use log_report::{FindingWords, LogReport, LogSection};
pub use loop_page::LoopPage;
pub use paper::Paper;
pub use plan::{InjectedPlan, Plan};
pub use run::{Done, StageReport};

/// The README's code is a test.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
