//! Many logs at once: which were named, and what is said of each, on all cores.

use super::cores::cores;
use crate::ui::render_error;
use anyhow::Result;
use dpn_eval::parallel::each;
use dpn_io::printable;
use dpn_logs::logs_in;
use std::convert::Infallible;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// The logs that were named: of a folder that holds some, these.
pub(super) fn logs(paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut logs = Vec::new();
    for path in paths {
        if path == Path::new("-") {
            logs.push(path.clone());
        } else {
            logs.extend(logs_in(path)?);
        }
    }
    Ok(logs)
}

/// What `look` finds of each, by its name; the first line of why it cannot be read.
pub(super) fn looked_at<T: Send>(
    logs: &[PathBuf],
    look: impl Fn(&Path) -> Result<T> + Sync,
) -> Vec<(String, Result<T, String>)> {
    let row = |at: usize| {
        let found = look(&logs[at]).map_err(|error| {
            let text = render_error(&error);
            text.lines().next().unwrap_or_default().trim_start_matches("error: ").to_owned()
        });
        Ok::<_, Infallible>((printable(&logs[at].display().to_string()).to_string(), found))
    };
    let Ok(rows) = each(cores(), logs.len(), &AtomicBool::new(false), row, |_, _| Ok(()));
    rows.into_iter().flatten().collect()
}
