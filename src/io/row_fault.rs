//! What can be wrong with a row of a table, or with its header.

use thiserror::Error;

/// What to do about a clock that goes back.
const BACK: &str = "sort the rows by time, or cut the log where its clock was set";

/// What is wrong with a row or a header; texts are as the file has them, shortened.
#[derive(Debug, Clone, PartialEq, Error)]
#[allow(missing_docs)] // The fields' names say it.
pub enum RowFault {
    /// A column the reader needs is not in the header.
    #[error("no column `{column}`; the header names {found}")]
    MissingColumn { column: String, found: String },
    /// Two columns of the header mean the same.
    #[error("columns {} and {} both read as `{column}`", first + 1, second + 1)]
    DoubleColumn { column: String, first: usize, second: usize },
    /// A unit the reader does not know.
    #[error("column `{column}` has the unit \"{unit}\"; known are {known}")]
    UnknownUnit { column: String, unit: String, known: &'static str },
    /// A header, or a row, with a number of columns that fits no format of this file.
    #[error("{found} columns; {expected} are known")]
    UnknownLayout { found: usize, expected: &'static str },
    /// The same of a trajectory, whose columns have fixed places.
    #[error("{found} columns; {expected} are known")]
    PoseLayout { found: usize, expected: &'static str },
    /// A table without a header in which several columns could be a sensor's.
    #[error(
        "{columns} columns without a header could mean several things; median lengths of columns {found}: say {choices}"
    )]
    SeveralTriples { columns: usize, found: String, choices: String },
    /// Poses where an IMU's samples are wanted.
    #[error("the rows end with unit quaternions: poses, not an IMU's samples")]
    Poses,
    /// A row with more or fewer fields than the header or the rows before it.
    #[error("{found} fields, expected {expected}")]
    FieldCount { found: usize, expected: usize },
    /// Text that is no number.
    #[error("{column} is \"{text}\", not a number")]
    BadNumber { column: String, text: String },
    /// NaN, an infinity or a number too large.
    #[error("{column} is \"{text}\"; every value must be finite")]
    NotFinite { column: String, text: String },
    /// A stamp that is no time in the range of 64-bit nanoseconds.
    #[error("stamp \"{text}\" is not a time in {unit}")]
    BadStamp { text: String, unit: &'static str },
    /// The same of a trajectory, whose unit its format says.
    #[error("stamp \"{text}\" is not a time in {unit}")]
    PoseStamp { text: String, unit: &'static str },
    /// Poses without stamps where stamps are needed.
    #[error("twelve columns are a pose without a stamp, and no times.txt lies beside the file")]
    NoStamps,
    /// A position that is none in metres.
    #[error("{column} is {value:e} m; no trajectory goes further than 1e9 m")]
    TooFar { column: &'static str, value: f64 },
    /// Stamps that stand still or go back.
    #[error("time goes from {prev_ns} to {t_ns} ns; stamps must increase")]
    TimeNotIncreasing { prev_ns: i64, t_ns: i64 },
    /// Bytes that are no text.
    #[error("not UTF-8 text")]
    NotUtf8,
    /// A quaternion too far from length 1 to be a rotation.
    #[error("the quaternion has norm {norm}; a rotation has norm 1")]
    BadQuaternion { norm: f64 },
    /// Twelve numbers that are no pose.
    #[error("the pose's matrix {problem}")]
    BadPose { problem: String },
    /// A standard deviation below zero.
    #[error("{column} is {value}; a noise figure is not negative")]
    BadNoise { column: String, value: f64 },
    /// A count or a name that is no whole number from 0.
    #[error("{column} is \"{text}\", not a whole number from 0")]
    NotWhole { column: String, text: String },
    /// A frame of tracks whose count disagrees with the tracks after it.
    #[error(
        "the frame says {said} tracks ({} fields: id u v), but {found} fields follow",
        u128::from(*said) * 3
    )]
    TrackCount { said: u64, found: usize },
    /// More tracks in a frame than any tracker follows.
    #[error("{found} tracks in one frame; at most {most} are read")]
    TooManyTracks { found: u64, most: u64 },
    /// An image's name that leads out of the camera's folder.
    #[error("the image `{name}` is no file in the camera's folder")]
    BadName { name: String },
    /// An id that one frame holds twice.
    #[error("track {id} is there twice in one frame")]
    TrackTwice { id: u64 },
}

impl RowFault {
    /// What to do about it.
    pub fn hint(&self) -> &'static str {
        match self {
            Self::MissingColumn { column, .. } if column == "time" => {
                "of a log without stamps say its rate: --rate HZ; else say which column is which: --columns T,GX,GY,GZ,AX,AY,AZ"
            }
            Self::SeveralTriples { .. } => {
                "9.8, or 1 in g, is the accelerometer's, less than 10 rad/s the gyroscope's; a magnetometer's length hardly changes"
            }
            Self::MissingColumn { .. } | Self::DoubleColumn { .. } => {
                "say which column is which, by number or name: --columns T,GX,GY,GZ,AX,AY,AZ"
            }
            Self::UnknownUnit { .. } => {
                "name its unit: --time-unit, --gyro-unit or --accel-unit; or say what one of it is: --gyro-scale, --accel-scale"
            }
            Self::UnknownLayout { .. } => {
                "add a header that names the columns, or say which is which: --columns T,GX,GY,GZ,AX,AY,AZ"
            }
            Self::PoseLayout { .. } => {
                "trajectories are TUM's (t x y z qx qy qz qw between blanks, t in seconds), KITTI's (twelve numbers, before them t or beside the file times.txt) or EuRoC's (commas, nanoseconds, quaternion w x y z)"
            }
            Self::PoseStamp { .. } => {
                "between blanks, as TUM has them, stamps are seconds (1403636625.363555670), between commas, as EuRoC has them, nanoseconds: write them so"
            }
            Self::NoStamps => {
                "KITTI's poses need times.txt beside them, a number of seconds a line; two files without stamps are compared line by line"
            }
            Self::TooFar { .. } => "an estimator that diverges leaves such poses: cut the file before them",
            Self::Poses => {
                "trajectories are held against each other by `dpn ape`, against a log by `dpn noise LOG --against FILE`; if it is a log, say --columns T,GX,GY,GZ,AX,AY,AZ"
            }
            Self::FieldCount { .. } => "the row is cut off or damaged; mend or delete the line",
            Self::BadNumber { column, text } if column != "time" && text.contains([':', '=']) => {
                "a name before each number is not read: write the rows without, below a header"
            }
            Self::BadNumber { text, .. } | Self::BadStamp { text, .. } if text.contains(':') => {
                "dates are read year first (2023-10-29T02:59:40.25+01:00), times of day as 02:59:40.25: write them so or in seconds, ms, us or ns, or count the samples (--rate HZ)"
            }
            Self::BadNumber { text, .. } if text.is_empty() => {
                "an empty field is no number: mend or delete the line; rows that have one sensor each are read without --columns and --rate"
            }
            Self::BadNumber { .. } | Self::NotFinite { .. } => {
                "mend or delete the line; nothing is skipped silently"
            }
            Self::BadStamp { .. } => {
                "mend the line, name another column for the stamps (--columns) or write them as decimal numbers in s, ms, us or ns; or count the samples (--rate HZ)"
            }
            Self::TimeNotIncreasing { prev_ns, t_ns, .. } if prev_ns == t_ns => {
                "two rows share a stamp: drop one, or write stamps with more digits"
            }
            Self::TimeNotIncreasing { .. } => BACK,
            Self::NotUtf8 => "save the file as UTF-8 text; a binary file cannot be read as text",
            Self::BadQuaternion { .. } => {
                "look at the order: ASL has w x y z, TUM has x y z w after the position"
            }
            Self::BadPose { .. } => {
                "KITTI has the upper three rows of world_from_body, twelve numbers, row by row"
            }
            Self::BadNoise { .. } => "standard deviations are zero or more; mend the line",
            Self::NotWhole { .. } | Self::TrackCount { .. } => {
                "a frame is one line: stamp_ns n, then n times id u v; mend or delete the line"
            }
            Self::TooManyTracks { .. } => {
                "trackers follow some hundred points a frame: keep those that were followed longest"
            }
            Self::BadName { .. } => {
                "names are relative to cam0/data and stay in it, as 1403636579763555584.png does"
            }
            Self::TrackTwice { .. } => "an id names one point; make the file again, or delete one of the two",
        }
    }
}
