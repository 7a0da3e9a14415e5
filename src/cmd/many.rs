//! Many logs at once: which were named, and what is said of each, on all cores.

use super::cores::cores;
use crate::ui::{refuse, render_error};
use anyhow::Result;
use dpn_eval::parallel::each;
use dpn_io::printable;
use dpn_logs::logs_in;
use std::convert::Infallible;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// The logs that were named: of a folder that holds some, these, but for the file `own` that the command itself leaves.
pub(super) fn logs(paths: &[PathBuf], own: Option<&Path>) -> Result<Vec<PathBuf>> {
    let own = own.and_then(|own| own.canonicalize().ok());
    let mut logs = Vec::new();
    for path in paths {
        if path == Path::new("-") {
            logs.push(path.clone());
            continue;
        }
        let found = logs_in(path)?;
        let is_own = |log: &PathBuf| log != path && own.is_some() && log.canonicalize().ok() == own;
        logs.extend(found.into_iter().filter(|log| !is_own(log)));
    }
    Ok(logs)
}

/// Refuses, once all was said, rows of which none could be read, and a log that was named and is not there. What a folder holds beside logs is
/// no fault.
pub(super) fn read_some<T>(named: &[PathBuf], rows: &[(String, Result<T, String>)]) -> Result<()> {
    if rows.iter().all(|(_, row)| row.is_err()) {
        let first = rows.iter().find_map(|(_, row)| row.as_ref().err()).map_or("", String::as_str);
        let message = format!("none of {} logs can be read, the first: {first}", rows.len());
        return refuse(message, "`dpn check --help` lists the kinds of logs that are read");
    }
    match named.iter().find(|path| *path != Path::new("-") && !path.exists()) {
        None => Ok(()),
        Some(missing) => {
            let message = format!("{} does not exist", missing.display());
            refuse(message, "the other logs were read; look at its name")
        }
    }
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
        Ok::<_, Infallible>((printable(&logs[at].display().to_string()), found))
    };
    let Ok(rows) = each(cores(), logs.len(), &AtomicBool::new(false), row, |_, _| Ok(()));
    rows.into_iter().flatten().collect()
}
