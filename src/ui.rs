//! Talk with the person at the terminal: progress, errors, hints. Data goes to stdout, talk to stderr.

use dpn_core::progress::Progress;
use dpn_io::{ResultPath, write_file};
use dpn_probe::Weight;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::fmt;
use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};
use thiserror::Error;

/// Standard output takes no more: the reader of a pipe has gone, or the disk is full.
#[derive(Debug, Error)]
#[error("standard output: {0}")]
pub(crate) struct OutputError(std::io::Error);

/// Whether nobody reads standard output any more (`dpn ... | head -1`): whoever did has what he wanted, and nothing is wrong.
pub(crate) fn is_closed_pipe(error: &anyhow::Error) -> bool {
    let io = error.downcast_ref::<OutputError>().map(|error| &error.0).or_else(|| error.downcast_ref());
    io.is_some_and(|error| error.kind() == std::io::ErrorKind::BrokenPipe)
}

/// Data for standard output.
///
/// # Errors
/// It takes no more.
pub(crate) fn write_stdout(text: fmt::Arguments<'_>) -> Result<(), OutputError> {
    std::io::stdout().lock().write_fmt(text).map_err(OutputError)
}

/// Talk for standard error. Where it takes nothing nobody listens, and the work goes on.
pub(crate) fn write_stderr(text: fmt::Arguments<'_>) {
    let _unheard = std::io::stderr().lock().write_fmt(text);
}

/// `print!` that answers instead of panicking.
macro_rules! out {
    ($($text:tt)*) => { $crate::ui::write_stdout(format_args!($($text)*)) };
}

/// `println!` that answers instead of panicking.
macro_rules! outln {
    ($($text:tt)*) => { $crate::ui::write_stdout(format_args!("{}\n", format_args!($($text)*))) };
}

/// `eprintln!` that drops what cannot be written instead of panicking.
macro_rules! errln {
    ($($text:tt)*) => { $crate::ui::write_stderr(format_args!("{}\n", format_args!($($text)*))) };
}

pub(crate) use {errln, out, outln};

/// Says warnings, a line each.
pub(crate) fn warn<W: fmt::Display>(warnings: impl IntoIterator<Item = W>) {
    for warning in warnings {
        errln!("warning: {warning}");
    }
}

/// Writes a command's results as JSON, and prints them where `--json` asks for that in place of words: whether it does.
pub(crate) fn results(file: ResultPath, all: &impl Serialize, json: bool) -> anyhow::Result<bool> {
    let text = serde_json::to_string(all)? + "\n";
    write_file(file, &text)?;
    if json {
        out!("{text}")?;
    }
    Ok(json)
}

/// Says where the pictures among `files` are.
pub(crate) fn print_pictures(files: &[ResultPath]) -> Result<(), OutputError> {
    let pictures = files.iter().filter(|file| file.path().extension().is_some_and(|ending| ending == "png"));
    for picture in pictures {
        outln!("picture:  {}", picture.display())?;
    }
    Ok(())
}

/// A message for the user with what to do about it.
#[derive(Debug, Error)]
#[error("{message}")]
pub(crate) struct Fault {
    /// What is wrong, and where.
    message: String,
    /// How to mend it.
    hint: Option<String>,
}

impl Fault {
    /// A fault whose message says it all.
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), hint: None }
    }

    /// The same with a remedy, printed on a line of its own.
    #[must_use]
    pub(crate) fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }
}

/// Ends a command with a message and what to do about it.
pub(crate) fn refuse<T>(message: impl Into<String>, hint: impl Into<String>) -> anyhow::Result<T> {
    Err(Fault::new(message).hint(hint).into())
}

/// A run or a log that is of no use, told by the exit code; why was said.
#[derive(Debug, Error)]
pub(crate) enum Untrusted {
    /// A run that is not to be trusted, and somebody asked to be told.
    #[error("the run is not to be trusted (--strict)")]
    Doubted,
    /// A run that made no pose.
    #[error("the run made no pose (exit code 3)")]
    NoPose,
    /// A log with something as grave as somebody asked to be told of.
    #[error("the gravest finding is: {0} (--fail-on)")]
    Found(Weight),
}

/// The user pressed Ctrl-C and the work stopped at a safe place.
#[derive(Debug, Error)]
#[error("{0}")]
pub(crate) struct Interrupted(pub(crate) String);

/// The chain of causes on one line, and the first hint found in it.
pub(crate) fn render_error(error: &anyhow::Error) -> String {
    let mut parts: Vec<String> = Vec::new();
    for cause in error.chain() {
        let text = cause.to_string();
        // Some errors repeat their source in their own words.
        if parts.last().is_none_or(|last| !last.contains(&text)) {
            parts.push(text);
        }
    }
    // Paths and values are as they were typed: what steers a terminal is spelt out.
    let lines = parts.join(": ");
    let lines: Vec<String> = lines.lines().map(dpn_io::printable).collect();
    let mut text = format!("error: {}", lines.join("\n"));
    if let Some(hint) = error.chain().find_map(hint_of) {
        text.push_str(&format!("\n\nhint: {hint}"));
    }
    text
}

/// The remedy an error of ours carries.
fn hint_of(cause: &(dyn std::error::Error + 'static)) -> Option<String> {
    if let Some(fault) = cause.downcast_ref::<Fault>() {
        return fault.hint.clone();
    }
    macro_rules! hints {
        ($($error:ty),+ $(,)?) => {
            $(if let Some(error) = cause.downcast_ref::<$error>() {
                return error.hint();
            })+
        };
    }
    hints!(
        dpn_io::config::ConfigError,
        dpn_eval::closed_loop::ClosedLoopError,
        dpn_live::LiveError,
        dpn_eval::sweeps::SweepError,
        dpn_papers::PaperError,
        dpn_io::LockError,
        dpn_io::IoError,
        dpn_logs::LogError,
        dpn_io::calibration::CalibrationError,
        dpn_io::noise_formats::FormatError,
        dpn_probe::log_noise::LogNoiseError,
        dpn_probe::allan::AllanError,
        dpn_train::asl::LoadError,
        dpn_train::run::RunError,
    );
    None
}

/// One bar on a terminal; a plain line now and then where stderr is none.
pub(crate) struct Bar {
    bar: Option<ProgressBar>,
    what: String,
    total: u64,
    last_line: Option<Instant>,
}

impl Bar {
    /// How often a plain line is written.
    const LINE_EVERY: Duration = Duration::from_secs(10);

    /// A bar that shows nothing until work starts.
    pub(crate) fn new() -> Self {
        Self { bar: None, what: String::new(), total: 0, last_line: None }
    }
}

impl Progress for Bar {
    fn start(&mut self, what: &str, total: u64) {
        what.clone_into(&mut self.what);
        self.total = total;
        if std::io::stderr().is_terminal() {
            let bar = ProgressBar::new(total);
            let style = ProgressStyle::with_template("{prefix} [{bar:32}] {pos}/{len} {msg} (left {eta})");
            bar.set_style(style.expect("the template is well formed").progress_chars("=> "));
            bar.set_prefix(what.to_owned());
            self.bar = Some(bar);
        } else {
            errln!("{what}: {total} steps");
            self.last_line = Some(Instant::now());
        }
    }

    fn step(&mut self, done: u64, note: &str) {
        if let Some(bar) = &self.bar {
            bar.set_position(done);
            bar.set_message(note.to_owned());
        } else if self.last_line.is_none_or(|at| at.elapsed() >= Self::LINE_EVERY) {
            errln!("{}: {done}/{} {note}", self.what, self.total);
            self.last_line = Some(Instant::now());
        }
    }

    fn finish(&mut self, note: &str) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
        errln!("{}: {note}", self.what);
    }
}
