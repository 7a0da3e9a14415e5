//! Runs commands with little room and time, and says what they should not have done.

use std::fmt;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// CPU time a command may take \[s\]: the clock on the wall counts the neighbours too.
const LONGEST_S: u32 = 10;
/// What waits for something is at work for longer than this.
const HANGS: Duration = Duration::from_secs(90);
/// Kilobytes of address space.
const ROOM: usize = 1 << 20;

/// Files and what is called on them, each in a folder that has these files alone.
pub(crate) struct Case {
    pub(crate) name: String,
    /// Puts the files into a folder.
    pub(crate) prepare: Box<dyn Fn(&Path) + Send + Sync>,
    /// Lines of arguments, without blanks inside of one.
    pub(crate) commands: Vec<String>,
}

/// What was seen.
#[derive(Default)]
pub(crate) struct Tally {
    cases: usize,
    answers: usize,
    refusals: usize,
    slowest: (Duration, String),
    faults: Vec<String>,
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (slowest, name) = &self.slowest;
        write!(
            f,
            "{} cases, {} commands: {} answers, {} refusals; the slowest took {slowest:.1?}: {name}",
            self.cases,
            self.answers + self.refusals,
            self.answers,
            self.refusals
        )
    }
}

/// Runs every command of every case, on as many threads as there are cores.
///
/// # Panics
/// After all of them, where any did what it should not.
pub(crate) fn judge(cases: impl IntoIterator<Item = Case, IntoIter: Send>) -> Tally {
    let (queue, tally) = (Mutex::new(cases.into_iter()), Mutex::new(Tally::default()));
    let work = || {
        loop {
            let Some(case) = queue.lock().unwrap().next() else { return };
            let dir = tempfile::tempdir().unwrap();
            tally.lock().unwrap().cases += 1;
            for line in &case.commands {
                // What one left is not the next one's.
                let dir = dir.path().join("case");
                std::fs::create_dir_all(&dir).unwrap();
                (case.prepare)(&dir);
                let (took, outcome) = run(&dir, line);
                let mut tally = tally.lock().unwrap();
                let name = format!("{}: dpn {line}", case.name);
                if took > tally.slowest.0 {
                    tally.slowest = (took, name.clone());
                }
                match outcome {
                    Ok(true) => tally.answers += 1,
                    Ok(false) => tally.refusals += 1,
                    Err(fault) => {
                        let kept = keep(&dir, tally.faults.len());
                        eprintln!("{name}: {fault}{kept}");
                        tally.faults.push(format!("{name}: {fault}"));
                    }
                }
                std::fs::remove_dir_all(&dir).unwrap();
            }
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(4);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(work);
        }
    });
    let tally = tally.into_inner().unwrap();
    assert!(tally.faults.is_empty(), "{tally}\n{}", tally.faults.join("\n"));
    tally
}

/// Puts a case with a fault where `DPN_KEEP` says, and says where.
fn keep(dir: &Path, number: usize) -> String {
    let Some(to) = std::env::var_os("DPN_KEEP") else { return String::new() };
    let to = PathBuf::from(to).join(number.to_string());
    std::fs::create_dir_all(to.parent().unwrap()).unwrap();
    let done = Command::new("cp").arg("-r").arg(dir).arg(&to).status().unwrap();
    assert!(done.success());
    format!(" ({})", to.display())
}

/// Whether it answered (or refused), or what is wrong with how it ended.
fn run(dir: &Path, line: &str) -> (Duration, Result<bool, String>) {
    let [out, err] = ["stdout", "stderr"].map(|name| dir.join(name));
    let binary = std::env::var_os("DPN_BIN").unwrap_or_else(|| env!("CARGO_BIN_EXE_dpn").into());
    let mut command = Command::new("sh");
    let script = format!("ulimit -c 0; ulimit -t {LONGEST_S}; ulimit -v {ROOM}; exec \"$0\" \"$@\"");
    // A thread takes room for its stack and its part of the heap, on a machine with a hundred cores all there is.
    command.current_dir(dir).env("RAYON_NUM_THREADS", "2").args(["-c", &script]).arg(binary);
    command.args(line.split_whitespace()).stdin(std::process::Stdio::null());
    let clock = Instant::now();
    let mut child =
        command.stdout(File::create(&out).unwrap()).stderr(File::create(&err).unwrap()).spawn().unwrap();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break Some(status);
        }
        if clock.elapsed() > HANGS {
            child.kill().unwrap();
            child.wait().unwrap();
            break None;
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let took = clock.elapsed();
    let said = String::from_utf8_lossy(&std::fs::read(&err).unwrap()).into_owned();
    (took, ended(status, &said, std::fs::metadata(&out).unwrap().len()))
}

fn ended(status: Option<ExitStatus>, said: &str, printed: u64) -> Result<bool, String> {
    let Some(status) = status else { return Err(format!("still at work after {HANGS:?}: {said}")) };
    if said.contains("panicked") || said.contains("fault of the program") {
        return Err(format!("{status}: {said}"));
    }
    let errors = said.lines().filter(|line| line.starts_with("error: ")).count();
    match status.code() {
        Some(0) if errors == 0 => Ok(true),
        // An answer that is not to be trusted, or has no pose.
        Some(3) if errors == 0 && said.contains("exit code 3") => Ok(true),
        // A log is named as it is read, before what it lacks is known.
        Some(2) if errors == 1 && printed == 0 => Ok(false),
        _ => {
            Err(format!("{status}, {printed} bytes printed: {}", said.chars().take(600).collect::<String>()))
        }
    }
}
