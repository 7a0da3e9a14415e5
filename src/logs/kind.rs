//! The kinds of logs.

use dpn_core::named;
use serde::Serialize;

named!(
    /// A kind of log.
    #[derive(Serialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Kind {
        /// A folder with `imu0/data.csv`.
        Asl = "ASL folder",
        /// A text file.
        Csv = "CSV file",
        /// Objects, of an app or a line each.
        Json = "JSON file",
        /// Messages as ROS prints them.
        Echo = "ROS echo",
        /// A ROS 1 bag.
        Rosbag1 = "rosbag1",
        /// An MCAP file.
        Mcap = "MCAP file",
        /// One of rosbag2's SQLite files.
        Sqlite = "rosbag2 SQLite file",
        /// A rosbag2 folder.
        Rosbag2 = "rosbag2 folder",
        /// A folder with a file for each sensor, as phones write them.
        TwoFiles = "folder of two files",
        /// PX4's ULog.
        Ulog = "ULog",
        /// ArduPilot's binary log.
        Ardupilot = "ArduPilot log",
        /// ArduPilot's log as text.
        ArdupilotText = "ArduPilot text log",
        /// Betaflight's and INAV's log.
        Blackbox = "blackbox log",
    }
);
