//! What goes wrong with a node.

use std::path::PathBuf;

/// Why there is no node, or no topic.
#[derive(Debug, thiserror::Error)]
pub enum Ros2Error {
    /// An argument behind `--ros-args` that is none.
    #[error(
        "--ros-args: {problem}; known are -r FROM:=TO, -p NAME:=VALUE, --params-file FILE, -r __ns:=/NAMESPACE, -r __node:=NAME"
    )]
    Argument {
        /// What is wrong.
        problem: String,
    },
    /// A file of parameters that cannot be read.
    #[error("{}: {problem}; it is to hold NODE: ros__parameters: NAME: VALUE", path.display())]
    ParamsFile {
        /// Its place.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// A name that ROS does not have.
    #[error("`{name}` is no name of a {what} in ROS: {problem}")]
    Name {
        /// What it names.
        what: &'static str,
        /// As it was given.
        name: String,
        /// What is wrong.
        problem: &'static str,
    },
    /// A variable of the environment that is none.
    #[error("{name}={value}: {problem}")]
    Environment {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: String,
        /// What is wrong, and what would be right.
        problem: &'static str,
    },
    /// DDS does not begin, or refuses a topic.
    #[error("DDS: {what}: {problem}")]
    Dds {
        /// What was asked of it.
        what: String,
        /// Its words.
        problem: String,
    },
}
