//! Why a log gives no recording.

use dpn_core::Stamp;
use dpn_core::config::did_you_mean;
use dpn_io::{IoError, printable};
use std::path::PathBuf;
use thiserror::Error;

/// What is wrong with a log as a whole. `Display` says what and where, [`LogError::hint`] what to do.
#[derive(Debug, Error)]
pub enum LogError {
    /// A text log, or a file that cannot be opened.
    #[error(transparent)]
    Io(#[from] IoError),
    /// A folder without a log.
    #[error("no log in {}: looked for mav0/imu0/data.csv, imu0/data.csv, *.mcap, *.db3, a *gyro* and an *accel* file", dir.display())]
    NoLog {
        /// Where.
        dir: PathBuf,
        /// Logs in the folders below.
        below: Vec<PathBuf>,
    },
    /// A bag without a topic of an IMU.
    #[error("{}: no topic of type sensor_msgs/Imu{}", path.display(), after("; it has ", topics))]
    NoImu {
        /// The bag.
        path: PathBuf,
        /// What it has.
        topics: String,
        /// What is wrong with the bag, where something is.
        damage: Option<String>,
    },
    /// More than one IMU, and nobody said which.
    #[error("{}: {} IMU topics: {topics}", path.display(), *count)]
    SeveralTopics {
        /// The bag.
        path: PathBuf,
        /// How many.
        count: usize,
        /// Their names and numbers of messages.
        topics: String,
        /// One of them.
        one: String,
    },
    /// A topic that is not in the bag.
    #[error("{}: no topic `{wanted}`{}", path.display(), after("; it has ", topics))]
    NoTopic {
        /// The bag.
        path: PathBuf,
        /// What was asked for.
        wanted: String,
        /// What it has.
        topics: String,
        /// The most similar name.
        similar: Option<String>,
    },
    /// A topic of another type.
    #[error("{}: `{topic}` is of type {kind}, not sensor_msgs/Imu", path.display())]
    NotImu {
        /// The bag.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// Its type.
        kind: String,
    },
    /// A bag without images.
    #[error("{}: no images on any topic of type sensor_msgs/Image or CompressedImage{}", path.display(), after("; it has ", topics))]
    NoImages {
        /// The bag.
        path: PathBuf,
        /// What it has.
        topics: String,
    },
    /// More than one topic of images, and nobody said which.
    #[error("{}: {} topics of images: {topics}", path.display(), *count)]
    SeveralImageTopics {
        /// The bag.
        path: PathBuf,
        /// How many.
        count: usize,
        /// Their names and numbers of images.
        topics: String,
        /// One of them.
        one: String,
    },
    /// A topic of images that is not in the bag.
    #[error("{}: no topic of images `{wanted}`{}", path.display(), after("; it has ", topics))]
    NoImageTopic {
        /// The bag.
        path: PathBuf,
        /// What was asked for.
        wanted: String,
        /// What it has.
        topics: String,
        /// The most similar name.
        similar: Option<String>,
    },
    /// A bag without poses.
    #[error(
        "{}: no poses on any topic of type nav_msgs/Odometry, geometry_msgs/PoseStamped, PoseWithCovarianceStamped or TransformStamped{}",
        path.display(),
        after("; it has ", topics)
    )]
    NoPoses {
        /// The bag.
        path: PathBuf,
        /// What it has.
        topics: String,
    },
    /// More than one topic of poses, and nobody said which.
    #[error("{}: several topics of poses: {topics}", path.display())]
    SeveralPoseTopics {
        /// The bag.
        path: PathBuf,
        /// Their names.
        topics: String,
        /// One of them.
        one: String,
    },
    /// A folder of images without an IMU's file.
    #[error("{}: images, and no IMU: looked for imu.txt, imu.csv, imu0.csv, *.jsonl, a *gyro* and an *accel* file", dir.display())]
    NoImuFile {
        /// The folder.
        dir: PathBuf,
    },
    /// A file, or a pipe that ended, without a byte.
    #[error("{}: empty, not a byte came", path.display())]
    Empty {
        /// Where nothing came from.
        path: PathBuf,
    },
    /// A log in which images cannot be.
    #[error("{}: {kind}; images are read from rosbag1, MCAP, rosbag2, ASL folders and folders with times.txt or with stamps for names", path.display())]
    NoBag {
        /// The log.
        path: PathBuf,
        /// What it is.
        kind: &'static str,
    },
    /// A log that cannot be copied message by message.
    #[cfg(feature = "write")]
    #[error("{}: {kind}; messages are copied from MCAP, in a file or in a rosbag2 folder", path.display())]
    NoCopy {
        /// The log.
        path: PathBuf,
        /// What it is.
        kind: &'static str,
    },
    /// An IMU or images whose messages are written in a way that is not known.
    #[error("{}: the messages on `{topic}` are written as `{encoding}`; known are cdr and ros1", path.display())]
    Encoding {
        /// The bag.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// As the bag names it.
        encoding: String,
    },
    /// Not two samples of use.
    #[error("{}: {found} sample(s) of use{}; a recording needs at least 2", path.display(), after(" on ", topic))]
    TooFew {
        /// The log.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// How many there are.
        found: usize,
        /// Why there are no more, where that is known.
        reason: Option<String>,
    },
    /// Stamps in no order.
    #[error("{}: time goes back at {count} of {of} samples, first at message {first}", path.display())]
    Backward {
        /// The log.
        path: PathBuf,
        /// How many samples.
        count: usize,
        /// Of how many.
        of: usize,
        /// Which.
        first: u64,
    },
    /// A file of this kind that cannot be read at all.
    #[error("{}: {what}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// A database, and no reader of databases in this build.
    #[error("{}: a rosbag2 database (SQLite), and this build of dpn reads none", path.display())]
    NoSqlite {
        /// The file.
        path: PathBuf,
    },
    /// A bag that must be unpacked first.
    #[error("{}: a compressed bag", path.display())]
    Packed {
        /// The file.
        path: PathBuf,
    },
    /// An archive where its files cannot be sought out: in a stream, or among images.
    #[error("{}: a zip archive", path.display())]
    Zipped {
        /// The file.
        path: PathBuf,
    },
    /// An archive of several files of which none can be chosen.
    #[error("{}: {count} files in a zip archive, and none is a phone's: {names}", path.display())]
    SeveralInZip {
        /// The archive.
        path: PathBuf,
        /// How many.
        count: usize,
        /// Their names.
        names: String,
    },
    /// A gyroscope's and an accelerometer's file that have no time in common.
    #[error("{}: {gyro} and {accel} have {found} sample(s) at the same time; a recording needs at least 2{spans}", dir.display())]
    Apart {
        /// The folder.
        dir: PathBuf,
        /// The gyroscope's file.
        gyro: String,
        /// The accelerometer's.
        accel: String,
        /// How many samples have both.
        found: usize,
        /// The stamps of each.
        spans: String,
    },
    /// A file of a program that is known and not read.
    #[error("{}: {what}", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What it is.
        what: &'static str,
        /// What makes a log of it.
        remedy: &'static str,
    },
    /// A video.
    #[error("{}: a video; images are read from folders and bags", path.display())]
    Video {
        /// The file.
        path: PathBuf,
    },
    /// JSON or printed messages without samples, or with those of one sensor.
    #[error("{}: {what} {problem}", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// Which of the two.
        what: &'static str,
        /// What is wrong with it.
        problem: String,
    },
    /// A part of a log in which nothing is.
    #[error("{}: fewer than two samples between --from and --to; the log is from {first} to {last}", path.display())]
    NothingWithin {
        /// The log.
        path: PathBuf,
        /// Its first stamp.
        first: Stamp,
        /// Its last.
        last: Stamp,
    },
    /// Files of one log that have not as many rows.
    #[error("{}: {files} have not as many rows", dir.display())]
    RowsDiffer {
        /// The folder.
        dir: PathBuf,
        /// Their names and numbers of rows.
        files: String,
    },
    /// Something was asked for that this kind of log does not have.
    #[error("{}: {flag} is for {of}, and this is none: {kind}", path.display())]
    NotHere {
        /// The log.
        path: PathBuf,
        /// What was asked for.
        flag: &'static str,
        /// Which logs have it.
        of: &'static str,
        /// What it is.
        kind: &'static str,
    },
}

fn after(words: &str, list: &str) -> String {
    if list.is_empty() { String::new() } else { format!("{words}{list}") }
}

impl LogError {
    /// What to do about it.
    pub fn hint(&self) -> Option<String> {
        let text = match self {
            Self::Io(error) => return error.hint(),
            Self::NoLog { below, .. } => match below.first() {
                Some(first) => {
                    return Some(format!(
                        "there are {} below it: give one, for example {}",
                        below.len(),
                        printable(&first.display().to_string())
                    ));
                }
                None => {
                    "give a CSV file, a bag, a ULog or ArduPilot log, or the folder of an ASL sequence (it holds `mav0` or `imu0`), of a rosbag2 or of a phone's two files"
                }
            },
            Self::NoImu { damage: Some(damage), .. } => {
                return Some(format!("the bag is damaged ({damage}); copy or record it again"));
            }
            Self::NoImu { .. } => {
                "record the IMU's topic too; a driver that publishes another type must be converted to sensor_msgs/Imu"
            }
            Self::SeveralTopics { one, .. } => return Some(format!("say which one: --topic {one}")),
            Self::NoTopic { similar: Some(similar), .. }
            | Self::NoImageTopic { similar: Some(similar), .. } => return Some(did_you_mean(similar)),
            Self::NoTopic { similar: None, .. } | Self::NoImageTopic { similar: None, .. } => {
                "topics are written in full, as `rosbag info` or `ros2 bag info` shows them"
            }
            Self::NoImages { .. } => "record the camera's topic too, or name another log",
            Self::SeveralImageTopics { one, .. } => {
                return Some(format!("say which one: --image-topic {one}"));
            }
            Self::NoPoses { .. } => "record the poses' topic too, or name a trajectory's file",
            Self::SeveralPoseTopics { path, one, .. } => {
                return Some(format!(
                    "name one behind the bag: {}:{one}",
                    printable(&path.display().to_string())
                ));
            }
            Self::NoImuFile { .. } => {
                "put the IMU's samples beside times.txt: stamp, gyroscope x y z, accelerometer x y z a row"
            }
            #[cfg(feature = "write")]
            Self::NoCopy { .. } => "convert it first, for example by `ros2 bag convert` or `mcap convert`",
            Self::Empty { .. } => {
                "look whether what writes it runs; a download or export may have been cut off"
            }
            Self::NoBag { .. } => "record camera and IMU into one bag, or lay the images beside a times.txt",
            Self::NotImu { .. } => "choose the topic of the raw IMU; without --topic the only one is taken",
            Self::Encoding { .. } => {
                "convert the bag to ROS 2's cdr or ROS 1's ros1, for example by `ros2 bag convert` or `rosbags-convert`"
            }
            Self::TooFew { reason: Some(reason), .. } => {
                return Some(format!("{reason}; copy, convert or record it again"));
            }
            Self::TooFew { .. } => "record for longer, or look whether the file was cut off",
            Self::Backward { .. } => "sort the samples by time, or cut the log where its clock was set",
            Self::Damaged { .. } => "copy or record it again",
            Self::NoSqlite { .. } => {
                "open it by `dpn check`, `dpn noise` and `dpn allan`, or convert it to MCAP by `ros2 bag convert`"
            }
            Self::Packed { .. } => "unpack it first, for example by `zstd -d` or `ros2 bag convert`",
            Self::Zipped { .. } => "unpack it first, for example by `unzip`, and give the file or the folder",
            Self::SeveralInZip { .. } => "unpack it by `unzip` and give the file or the folder of the IMU",
            Self::Apart { .. } => {
                "take both from one recording, with stamps of one clock; or name their unit: --time-unit"
            }
            Self::NotHere { flag, .. } => return Some(format!("leave {flag} out")),
            Self::Foreign { remedy, .. } => remedy,
            Self::Video { path } => {
                let file = printable(&path.display().to_string());
                return Some(format!(
                    "make a folder of it: mkdir -p seq/images && ffmpeg -i {file} -fps_mode passthrough -pix_fmt gray seq/images/%05d.png, its stamps by \
                     ffprobe -v error -select_streams v -show_entries frame=pts_time -of csv=p=0 {file} | awk '{{print NR, $1}}' > seq/times.txt, \
                     the samples as seq/imu.csv on the same clock"
                ));
            }
            Self::Json { .. } => {
                "known are objects of a sensor, a time and x, y, z or values, and objects with both sensors' axes; else write a CSV with a header"
            }
            Self::NothingWithin { .. } => "give seconds from the log's begin, or stamps within it",
            Self::RowsDiffer { .. } => "take the files of one recording, or one file with a column for each",
        };
        Some(text.to_owned())
    }
}
