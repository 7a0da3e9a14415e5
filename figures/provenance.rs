//! What made a table or a figure.

/// The command and the runs behind a table or a figure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Provenance {
    /// The command line.
    pub command: String,
    /// The program: version and checksum.
    pub program: String,
    /// Folders of the runs, without what is above them.
    pub runs: Vec<String>,
}

impl Provenance {
    /// The same of these runs alone.
    #[must_use]
    pub fn of(&self, runs: &[&str]) -> Self {
        Self { runs: runs.iter().map(|run| (*run).to_owned()).collect(), ..self.clone() }
    }

    /// One line for the foot of a table or figure.
    pub fn line(&self) -> String {
        format!("{} ({}); runs: {}.", self.command, self.program, self.runs.join(", "))
    }
}
