//! `dpn run --mcap`: the run as a log. Images go into a temporary file while the run goes on, everything else behind them once the truth is aligned.

use super::messages::{Topic, image, is_due, of_update, path, pose_in, sigma, tracks, transform};
use anyhow::{Context, Result};
use dpn_core::{GrayImage, Stamp};
use dpn_eval::closed_loop::{JudgedRun, Recording};
use dpn_io::{atomic_write, scratch_file};
use dpn_logs::McapLog;
use dpn_vio::estimator::FrontEndObserver;
use dpn_vio::frontend::Fed;
use nalgebra::Isometry3;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::File;
use std::io;
use std::path::Path;

/// Images go into the log so often \[s\]: each has some hundred kilobytes.
const IMAGE_EVERY_S: f64 = 0.5;
/// Noise so often \[s\].
const SIGMA_EVERY_S: f64 = 0.05;

/// The log of a run that goes on.
pub(in crate::cmd) struct RunLog {
    log: McapLog<File>,
    /// The same file, which goes when this does.
    scratch: File,
    channels: BTreeMap<&'static str, u16>,
    image: Option<Stamp>,
    /// The first that could not be logged; after it nothing is.
    fault: Option<io::Error>,
}

impl FrontEndObserver for RunLog {
    fn end(&mut self, seen: &GrayImage, fed: &Fed) {
        let t = fed.report.t;
        let Some(frame) = &fed.frame else { return };
        if self.fault.is_none() && is_due(&mut self.image, t, IMAGE_EVERY_S) {
            let put = image(t, seen).and_then(|image| self.put(Topic::Image, t, &image));
            self.fault = put.and_then(|()| self.put(Topic::Tracks, t, &tracks(t, frame))).err();
        }
    }
}

impl RunLog {
    /// # Errors
    /// No temporary file.
    pub(in crate::cmd) fn new() -> Result<Self> {
        let named = scratch_file().context("a temporary file")?;
        let written = named.reopen().context("a temporary file")?;
        let log = McapLog::new(written, "").context("a temporary file")?;
        Ok(Self { log, scratch: named.into_file(), channels: BTreeMap::new(), image: None, fault: None })
    }

    /// Writes the log; `truth_from_world` is where the estimate's world lies in the truth's.
    ///
    /// # Errors
    /// The temporary file's, or that at `file`.
    pub(in crate::cmd) fn finish(
        mut self,
        file: &Path,
        recording: &Recording,
        done: &JudgedRun,
        truth_from_world: Option<&Isometry3<f64>>,
    ) -> Result<()> {
        let fault = self.fault.take();
        fault
            .map_or(Ok(()), Err)
            .and_then(|()| self.whole(recording, done, truth_from_world))
            .and_then(|()| self.log.finish())
            .context("a temporary file")?;
        atomic_write(file, |out| io::copy(&mut self.scratch, out).map(|_| ()))?;
        Ok(())
    }

    fn whole(
        &mut self,
        recording: &Recording,
        done: &JudgedRun,
        truth_from_world: Option<&Isometry3<f64>>,
    ) -> io::Result<()> {
        let (Some(first), Some(last)) = (done.output.frames.first(), done.output.frames.last()) else {
            return Ok(());
        };
        let span = *first..=*last;
        if let Some(pose) = truth_from_world {
            self.put(Topic::Tf, *first, &transform(*first, "truth", "world", pose))?;
        }
        let truth = recording.truth.iter().flatten().filter(|pose| span.contains(&pose.t));
        let (truth, poses): (Vec<_>, _) = (truth.copied().collect(), done.output.poses());
        for (topic, frame, poses) in
            [(Topic::EstimatePath, "world", &poses), (Topic::TruthPath, "truth", &truth)]
        {
            let Some(first) = poses.first() else { continue };
            self.put(topic, first.t, &path(first.t, frame, poses.iter().map(|pose| &pose.world_from_body)))?;
        }
        for pose in &truth {
            self.put(Topic::Truth, pose.t, &pose_in(pose.t, "truth", &pose.world_from_body))?;
        }
        for update in &done.output.updates {
            for (topic, value) in of_update(update.t, update, None) {
                self.put(topic, update.t, &value)?;
            }
        }
        let mut last = None;
        for (t, noise) in done.noise.stamps().iter().zip(done.noise.noises()) {
            if span.contains(t) && is_due(&mut last, *t, SIGMA_EVERY_S) {
                self.put(Topic::Sigma, *t, &sigma(*t, noise))?;
            }
        }
        Ok(())
    }

    fn put(&mut self, topic: Topic, t: Stamp, value: &Value) -> io::Result<()> {
        let (name, schema) = topic.names();
        let channel = match self.channels.get(name) {
            Some(channel) => *channel,
            None => {
                let channel = self.log.json_channel(name, schema, &topic.schema())?;
                self.channels.insert(name, channel);
                channel
            }
        };
        self.log.message(channel, t, value.to_string().as_bytes())
    }
}
