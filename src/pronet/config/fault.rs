//! What is wrong with a configuration: all faults at once.

use std::fmt;

/// One key whose value cannot be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// The key as spelt in the file.
    pub key: &'static str,
    /// Its value.
    pub value: String,
    /// What it must be.
    pub bound: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` is {}; it must be {}", self.key, self.value, self.bound)
    }
}

/// All faults of one configuration, at least one.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}", .faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
pub struct ConfigError {
    /// The faults in the order of the keys.
    pub faults: Vec<Fault>,
}
