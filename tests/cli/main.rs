//! The binary from outside: what it prints, how it exits, which files it leaves.
//!
//! Nothing here needs recordings or a network: recordings are made up ([`recording`]), networks are tiny ([`training`]).
#![allow(clippy::unwrap_used)]

mod allan;
mod apart;
mod arguments;
mod bad_config;
mod bad_data;
mod bag;
mod check;
mod closed_loop;
mod eval;
mod export;
mod fleet;
mod image_logs;
mod images;
mod inertial;
mod keys;
mod links;
mod live;
mod live_faults;
mod locks;
mod logs;
mod many_logs;
mod noise;
mod noise_against;
mod noise_log;
mod odometry;
mod page;
mod paper;
mod pipes;
mod recording;
mod remedies;
mod rendered;
mod report;
mod run;
mod simulate;
mod sweep;
mod tracks;
mod train;
mod training;
mod trajectories;
mod truth;
