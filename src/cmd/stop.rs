//! Ctrl-C: the first asks long work to stop at a safe place, the second stops at once.
//!
//! SIGTERM ends the process at once, as everywhere: files are whole or not there, and the next run clears what was half-written. To listen for it
//! would be, with this library, to listen for SIGHUP too, and `nohup` would no longer keep a night's run alive.

use crate::ui::{Interrupted, errln};
use anyhow::{Context, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// How long work may take to its next safe place. What takes longer (a fit of another library, a cell of a long sequence) is broken off: files are
/// whole or not there, so that this loses what is under way and nothing else.
const PATIENCE: Duration = Duration::from_millis(1500);

/// What came of long work; where it was stopped, that it was, and that it goes on.
pub(crate) fn outcome<T, E: std::error::Error + Send + Sync + 'static>(
    result: Result<T, E>,
    is_stop: impl Fn(&E) -> bool,
) -> Result<T> {
    result.map_err(|error| match is_stop(&error) {
        true => Interrupted(format!("{error}; the same command goes on from there")).into(),
        false => error.into(),
    })
}

/// A flag that Ctrl-C and SIGTERM set, for what ends well within an image of being asked to. A second one ends the process at once. To be asked for once, before
/// other threads are begun.
pub(crate) fn on_any_end() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&stop);
    let ask = move || {
        if asked.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    };
    #[cfg(unix)]
    {
        use nix::sys::signal::{SigSet, Signal};
        let ends: SigSet = [Signal::SIGINT, Signal::SIGTERM].into_iter().collect();
        ends.thread_block().context("cannot listen for signals")?;
        std::thread::spawn(move || {
            while ends.wait().is_ok() {
                ask();
            }
        });
    }
    #[cfg(not(unix))]
    ctrlc::set_handler(ask).context("cannot listen for Ctrl-C")?;
    Ok(stop)
}

/// A flag that Ctrl-C sets; `kept` says what is not lost where work had to be broken off. To be asked for once.
pub(crate) fn on_ctrl_c(kept: &'static str) -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&stop);
    ctrlc::set_handler(move || {
        if asked.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        std::thread::spawn(move || {
            std::thread::sleep(PATIENCE);
            errln!("stopped; {kept}");
            std::process::exit(130);
        });
    })
    .context("cannot listen for Ctrl-C")?;
    Ok(stop)
}
