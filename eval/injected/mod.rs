//! White noise of a known course added to a recording: the experiment in which an adaptive covariance has its fair chance.
//!
//! What a recording holds in flight changes little; here it changes by a known factor at known times. [`Injection`] says what is added
//! ([`Course`]), how much, and what the odometry should be told where nothing is added; [`Injection::apply`] adds it and leaves the deviation
//! that an oracle says; [`step_response`] measures how a noise track follows.

mod apply;
mod config;
mod course;
mod response;

pub use apply::TONE_HZ;
pub use config::Injection;
pub use course::Course;
pub use response::{StepResponse, step_response};
