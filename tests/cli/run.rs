//! Runs the binary and keeps what it said.

pub(crate) use dpn_testing::files;
use std::path::Path;
use std::process::{Command, Output};

/// What a finished `dpn` left.
#[derive(Debug)]
pub(crate) struct Done {
    /// Exit code; `None` after a signal.
    pub(crate) code: Option<i32>,
    /// Data.
    pub(crate) stdout: String,
    /// Talk.
    pub(crate) stderr: String,
}

/// The command, without arguments.
pub(crate) fn dpn() -> Command {
    Command::new(env!("CARGO_BIN_EXE_dpn"))
}

/// Runs `dpn` with the words of `line`.
pub(crate) fn run(line: &str) -> Done {
    finished(dpn().args(line.split_whitespace()).output().unwrap())
}

/// Runs a command to its end.
pub(crate) fn end(command: &mut Command) -> Done {
    finished(command.output().unwrap())
}

/// What a command that has ended left.
pub(crate) fn finished(output: Output) -> Done {
    Done {
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

impl Done {
    /// The same, having checked that all went well.
    #[track_caller]
    pub(crate) fn well(self) -> Self {
        assert_eq!(self.code, Some(0), "{self:?}");
        self
    }

    /// The same of a run that is too short for a pose, which exit code 3 says.
    #[track_caller]
    pub(crate) fn without_pose(self) -> Self {
        assert_eq!(self.code, Some(3), "{self:?}");
        self
    }

    /// Checks that it was refused: exit code 2, nothing on stdout, no panic, and on stderr exactly `expected`, in which `[DIR]`
    /// stands for `dir`.
    #[track_caller]
    pub(crate) fn refused(&self, dir: &Path, expected: &str) {
        assert_eq!(self.code, Some(2), "{self:?}");
        assert_eq!(self.stdout, "", "{self:?}");
        assert_eq!(self.stderr.replace(dir.to_str().unwrap(), "[DIR]").trim_end(), expected);
    }

    /// Stdout as one JSON value.
    #[track_caller]
    pub(crate) fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|error| panic!("{error}: {self:?}"))
    }
}
