//! Everything the paper is made from.

use super::input::Input;
use super::plan::Plan;
use dpn_eval::closed_loop::{StartAt, TrackCache};
use dpn_pronet::network::Network;
use dpn_vio::EstimatorConfig;
use std::path::Path;

/// Everything the paper is made from.
#[derive(Debug)]
pub struct Paper<'a> {
    /// What is run.
    pub plan: &'a Plan,
    /// On what.
    pub input: &'a Input,
    /// The networks that the odometry may be given noise by.
    pub networks: &'a [Network],
    /// Those of the open loop: these, and the others of the study.
    pub judged: &'a [Network],
    /// The estimator's settings; covariances are needed for NEES and for the error's band.
    pub estimator: EstimatorConfig,
    /// Why the odometry sees what it sees.
    pub camera: &'a str,
    /// Where runs begin.
    pub from: StartAt,
    /// Version and checksum of the program.
    pub program: String,
    /// Another build of it whose runs are taken, all of them; nothing is run then.
    pub measured_by: Option<&'a str>,
    /// The command line.
    pub command: String,
    /// Folder of the runs; nobody else writes there or to `out` (`dpn_io::FolderLock`).
    pub work: &'a Path,
    /// Folder of tables, figures and page.
    pub out: &'a Path,
    /// Threads to use.
    pub threads: usize,
    /// Where tracks that were followed through images are kept for others.
    pub cache: Option<&'a TrackCache>,
}
