//! How work is disturbed, and what must be left afterwards.

use crate::work::Work;
use dpn_testing::forged::Draw;
use std::collections::BTreeMap;
use std::fmt;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Within this work that is asked to stop must have stopped. It has 2 s; the rest is the machine's, which is busy with other tests.
const STOPS_WITHIN: Duration = Duration::from_secs(3);

/// How a process that aborts ends.
const SIGABRT: i32 = 6;

/// What a run left that nobody disturbed.
pub(crate) struct Whole {
    results: BTreeMap<String, Vec<u8>>,
    pub(crate) seconds: f64,
}

/// How often work was disturbed, and how.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    killed: usize,
    stopped: usize,
    runs: usize,
    slowest: Duration,
}

impl Tally {
    pub(crate) fn disturbances(&self) -> usize {
        self.killed + self.stopped
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { killed, stopped, runs, slowest } = self;
        write!(
            f,
            "{killed} kills and {stopped} stops (the slowest took {slowest:.1?}) over {runs} runs, nothing lost"
        )
    }
}

/// Work run to its end in a folder of its own.
pub(crate) fn undisturbed(of: Work) -> Whole {
    let tmp = tempfile::tempdir().unwrap();
    of.prepare(tmp.path());
    let clock = Instant::now();
    ends_well(of, tmp.path());
    Whole { seconds: clock.elapsed().as_secs_f64(), results: of.results(tmp.path()) }
}

/// Calls work again and again, disturbs it `most` times, and compares what it leaves in the end.
pub(crate) fn until_it_ends(of: Work, whole: &Whole, draw: &mut Draw, most: usize, tally: &mut Tally) {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    of.prepare(dir);
    tally.runs += 1;
    // So often within one run, or it would hardly ever get to its end.
    for _ in 0..most.min(5) {
        let at = Duration::from_secs_f64(draw.share() * whole.seconds);
        let kill = draw.share() < 0.5;
        let mut child = quietly(&mut of.command(dir));
        std::thread::sleep(at);
        if let Some(status) = child.try_wait().unwrap() {
            let said = std::io::read_to_string(child.stderr.take().unwrap()).unwrap();
            assert!(status.success(), "{}: {status}: {said}", of.name());
            break;
        }
        if kill {
            child.kill().unwrap();
            child.wait().unwrap();
            tally.killed += 1;
            continue;
        }
        let asked = Instant::now();
        let signal = if draw.share() < 0.5 { "-INT" } else { "-TERM" };
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        let output = child.wait_with_output().unwrap();
        let (took, said) = (asked.elapsed(), String::from_utf8_lossy(&output.stderr));
        assert!(took < STOPS_WITHIN, "{}: {took:?} after {signal} at {at:?}: {said}", of.name());
        // It may have ended just then, or not have listened yet.
        assert!(matches!(output.status.code(), Some(130 | 0) | None), "{} {at:?}: {said}", of.name());
        tally.slowest = tally.slowest.max(took);
        tally.stopped += 1;
    }
    ends_well(of, dir);
    compare(of, whole, dir);
}

/// Ends work just before and just after each of its renames, of which `every` so many are looked at, and compares what the same command then makes of
/// what it left. The numbers of renames seen.
pub(crate) fn at_renames(of: Work, whole: &Whole, every: usize) -> usize {
    for rename in 1.. {
        for moment in [format!("{rename}"), format!("{rename}+")] {
            if rename % every != 1 % every {
                continue;
            }
            if !at_rename(of, whole, &moment) {
                assert!(rename > every, "{}: nothing was renamed", of.name());
                return rename - 1;
            }
        }
    }
    unreachable!("work ends")
}

/// Ends work before the rename of this number, or after it (`7+`), and compares what the same command then makes of what it left; whether it has so
/// many.
pub(crate) fn at_rename(of: Work, whole: &Whole, moment: &str) -> bool {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    of.prepare(dir);
    let done = of.command(dir).env("DPN_ABORT_AT_RENAME", moment).output().unwrap();
    if done.status.success() {
        return false;
    }
    let said = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.signal(), Some(SIGABRT), "{} at {moment}: {said}", of.name());
    ends_well(of, dir);
    compare(of, whole, dir);
    true
}

/// Files may not grow beyond some sizes: a write fails in the middle. Nothing half-written is taken for whole later.
pub(crate) fn full_disk(of: Work, whole: &Whole) {
    let tmp = tempfile::tempdir().unwrap();
    of.prepare(tmp.path());
    for blocks in [1, 8, 40, 200] {
        let mut limited = Command::new("sh");
        let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
        limited.current_dir(tmp.path()).args(["-c", &script, env!("CARGO_BIN_EXE_dpn")]);
        let done = limited.args(of.arguments(tmp.path())).output().unwrap();
        let said = String::from_utf8_lossy(&done.stderr);
        match done.status.code() {
            Some(0) => break,
            code => {
                let named = ["error: cannot write ", ": cannot be written; "]
                    .iter()
                    .any(|words| said.contains(words));
                assert!(code == Some(2) && named, "{}: {said}", of.name());
            }
        }
    }
    ends_well(of, tmp.path());
    compare(of, whole, tmp.path());
}

/// Two at once: one may be told that the other writes there, and no result is lost.
pub(crate) fn two_writers(of: Work, whole: &Whole, draw: &mut Draw) {
    let tmp = tempfile::tempdir().unwrap();
    of.prepare(tmp.path());
    let first = quietly(&mut of.command(tmp.path()));
    std::thread::sleep(Duration::from_secs_f64(0.2 * draw.share() * whole.seconds));
    let second = quietly(&mut of.command(tmp.path()));
    let done = [first, second].map(|child| child.wait_with_output().unwrap());
    let codes: Vec<_> = done.iter().map(|output| output.status.code()).collect();
    assert!(codes.contains(&Some(0)), "{}: {codes:?}", of.name());
    for output in done.iter().filter(|output| output.status.code() != Some(0)) {
        let said = String::from_utf8_lossy(&output.stderr);
        let other = said.contains("another dpn writes there (process ");
        let stood_there = of == Work::Train && said.contains("a run stands there already");
        assert!(output.status.code() == Some(2) && (other || stood_there), "{}: {said}", of.name());
    }
    compare(of, whole, tmp.path());
}

fn quietly(command: &mut Command) -> Child {
    command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

fn ends_well(of: Work, dir: &Path) {
    let done = of.command(dir).output().unwrap();
    assert!(done.status.success(), "{}: {}", of.name(), String::from_utf8_lossy(&done.stderr));
}

fn compare(of: Work, whole: &Whole, dir: &Path) {
    let found = of.results(dir);
    let names = |results: &BTreeMap<String, Vec<u8>>| results.keys().cloned().collect::<Vec<_>>();
    // Temporary files and locks would be among them.
    assert_eq!(names(&found), names(&whole.results), "{}", of.name());
    for (name, bytes) in &whole.results {
        assert!(found[name] == *bytes, "{}: {name} differs from an undisturbed run", of.name());
    }
}
