//! Who works on a shard, told to whoever looks: a small file that is written anew every few seconds. A lock would not do: not every file system
//! shows it to other machines.

use dpn_io::{ResultPath, write_json};
use serde::{Deserialize, Serialize};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Name of the file.
pub(super) const BEAT: &str = "running.json";
/// How often it is written.
const EVERY: Duration = Duration::from_secs(5);

/// Who works on a shard.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Beat {
    /// The machine.
    pub node: String,
    /// The process there.
    pub process: u32,
    /// When it began [s since 1970].
    pub since: u64,
    /// When it was last alive [s since 1970], by the machine's clock.
    pub beat: u64,
    /// Cells that were there when it began.
    pub found: usize,
    /// What its numbers of processes are counted in: containers of one machine may have one name and numbers of their own.
    #[serde(default)]
    pub pids: Option<String>,
}

impl Beat {
    /// Whether the process was of this machine, and lives no more. Where that cannot be told it is not said.
    pub(super) fn is_dead(&self) -> bool {
        let here = pids();
        here.is_some() && (&self.node, &self.pids) == (&node(), &here) && !lives(self.process)
    }
}

/// Whether a process is there and has not ended; one that its parent has not asked after yet has.
fn lives(process: u32) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok();
    // The name before the state is in brackets and may hold some itself.
    let state = stat.as_deref().and_then(|stat| stat.rsplit_once(')')?.1.trim_start().chars().next());
    state.is_some_and(|state| !matches!(state, 'Z' | 'X'))
}

/// The space of this process's number; only Linux says.
fn pids() -> Option<String> {
    Some(std::fs::read_link("/proc/self/ns/pid").ok()?.to_string_lossy().into_owned())
}

/// Writes a [`Beat`] until it is dropped; then the file goes.
#[derive(Debug)]
pub(super) struct Heart {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Heart {
    /// Begins in `dir`.
    pub(super) fn start(dir: &ResultPath, found: usize) -> Self {
        let path = dir.join(BEAT);
        let since = now();
        let mut beat =
            Beat { node: node(), process: std::process::id(), since, beat: since, found, pids: pids() };
        let (stop, stopped) = channel::<()>();
        let thread = std::thread::spawn(move || {
            loop {
                beat.beat = now();
                // Who cannot be seen at work works all the same.
                let _ = write_json(&path, &beat);
                if stopped.recv_timeout(EVERY) != Err(RecvTimeoutError::Timeout) {
                    break;
                }
            }
            let _ = path.remove();
        });
        Self { stop: Some(stop), thread: Some(thread) }
    }
}

impl Drop for Heart {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            // A panic there has been told by its own message.
            let _ = thread.join();
        }
    }
}

/// Seconds since 1970.
pub(super) fn now() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs())
}

/// What the machine is called.
pub(super) fn node() -> String {
    let named = std::env::var("SLURMD_NODENAME").ok();
    let named = named.or_else(|| std::fs::read_to_string("/proc/sys/kernel/hostname").ok());
    named
        .or_else(|| std::env::var("HOSTNAME").ok())
        .map_or_else(|| "unknown".into(), |name| name.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_of_this_machine_that_is_gone_is_dead_at_once_and_no_other_is() {
        let here =
            Beat { node: node(), process: std::process::id(), since: 0, beat: now(), found: 0, pids: pids() };
        // No process has a number so high: Linux ends at 2^22.
        let gone = Beat { process: 4_194_999, ..here.clone() };
        assert!(!here.is_dead());
        assert_eq!(gone.is_dead(), cfg!(target_os = "linux"));
        assert!(!Beat { node: "another".into(), ..gone.clone() }.is_dead());
        assert!(!Beat { pids: Some("pid:[1]".into()), ..gone.clone() }.is_dead());
        assert!(!Beat { pids: None, ..gone }.is_dead());
    }
}
