//! Everything the paper is made from.

use super::asked::Opened;
use super::input::Input;
use super::plan::Plan;
use dpn_eval::closed_loop::{Experiment, TrackCache};
use dpn_io::ResultPath;
use dpn_pronet::network::Network;
use dpn_vio::EstimatorConfig;

/// Everything the paper is made from.
#[derive(Debug, Clone)]
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
    /// What every closed loop is made from, but for noises and seeds.
    pub run: Experiment,
    /// Why the odometry sees what it sees.
    pub camera: &'a str,
    /// Version and checksum of the program.
    pub program: String,
    /// Another build of it whose runs are taken, all of them; nothing is run then.
    pub measured_by: Option<&'a str>,
    /// The command line.
    pub command: String,
    /// Folder of the runs; nobody else writes there or to `out` (`dpn_io::FolderLock`).
    pub work: ResultPath,
    /// Folder of tables, figures and page.
    pub out: ResultPath,
    /// Threads to use.
    pub threads: usize,
    /// Where tracks that were followed through images are kept for others.
    pub cache: Option<&'a TrackCache>,
}

impl<'a> Paper<'a> {
    /// Of what was opened, by `program`, on one thread; nothing of it is written, for it has no folders yet.
    pub fn new(opened: &'a Opened, networks: &'a [Network], program: String) -> Self {
        Self {
            plan: &opened.plan,
            input: &opened.input,
            networks,
            judged: networks,
            estimator: opened.estimator.clone(),
            run: opened.run.clone(),
            camera: &opened.camera,
            program,
            measured_by: None,
            command: String::new(),
            work: "".into(),
            out: "".into(),
            threads: 1,
            cache: None,
        }
    }
}
