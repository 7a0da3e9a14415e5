//! The kinds of logs.

use serde::Serialize;

/// A kind of log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// A folder with `imu0/data.csv`.
    Asl,
    /// A text file.
    Csv,
    /// A ROS 1 bag.
    Rosbag1,
    /// An MCAP file.
    Mcap,
    /// One of rosbag2's SQLite files.
    Sqlite,
    /// A rosbag2 folder.
    Rosbag2,
    /// A folder with a file for each sensor, as phones write them.
    TwoFiles,
    /// PX4's ULog.
    Ulog,
    /// ArduPilot's binary log.
    Ardupilot,
    /// ArduPilot's log as text.
    ArdupilotText,
}

impl Kind {
    /// Its name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Asl => "ASL folder",
            Self::Csv => "CSV file",
            Self::Rosbag1 => "rosbag1",
            Self::Mcap => "MCAP file",
            Self::Sqlite => "rosbag2 SQLite file",
            Self::Rosbag2 => "rosbag2 folder",
            Self::TwoFiles => "folder of two files",
            Self::Ulog => "ULog",
            Self::Ardupilot => "ArduPilot log",
            Self::ArdupilotText => "ArduPilot text log",
        }
    }
}
