//! A log with images beside the IMU: a bag, or a folder with `times.txt` or with stamps for names.
//!
//! It is read twice from front to back: for the samples, which takes note of the topics of images and decodes one of them to see whether it can be used
//! ([`ImageLog::imu`]), and for the images ([`ImageLog::images`]), which are read, decoded and made grey on a thread of their own, a few ahead. Neither holds more
//! than a chunk and those few, however long the log.

use crate::cameras::Cameras;
use crate::fields::Encoding;
use crate::imu_file::ImuFile;
use crate::messages::Messages;
use crate::read::bag_log;
use crate::sensors::{SensorEvent, SensorStream};
use crate::topics::Topics;
use crate::{ImageLogOptions, ImageSpan, Kind, Log, LogError, bag, read_log};
use dpn_core::{GrayImage, Stamp};
use dpn_io::asl::{Sequence, discover};
use dpn_io::{ImageFolder, IoError, Prefetch, TimesFolder};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Images read ahead.
const AHEAD: usize = 4;
/// Where a camera's calibration may lie in a folder, as ASL has it.
const CALIBRATIONS: [&str; 3] = ["sensor.yaml", "cam0/sensor.yaml", "mav0/cam0/sensor.yaml"];

/// A log with images.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageLog {
    path: PathBuf,
    is_folder: bool,
    options: ImageLogOptions,
}

/// A camera's images and their stamps, as they come.
pub type Images = Box<dyn Iterator<Item = (Stamp, Result<GrayImage, IoError>)>>;

impl ImageLog {
    /// The log at `path`, where it is of a kind that may have images and is no ASL sequence; by its first bytes or its files.
    ///
    /// # Errors
    /// A video, a log of another program.
    pub fn find(path: &Path, options: ImageLogOptions) -> Result<Option<Self>, LogError> {
        let of = |is_folder| Ok(Some(Self { path: path.to_path_buf(), is_folder, options }));
        // Looking into a pipe would take from it.
        if Sequence::open(path).is_ok() || !(path.is_dir() || path.is_file()) {
            return Ok(None);
        }
        if path.is_dir() && TimesFolder::is(path) {
            return of(true);
        }
        match Kind::of(path) {
            // A stray bag beside sequences is no folder of a bag.
            Ok(Kind::Rosbag2) if discover(path).is_ok() => Ok(None),
            Ok(Kind::Rosbag1 | Kind::Mcap | Kind::Sqlite | Kind::Rosbag2) => of(false),
            // Whether a packed file holds a bag is seen when it is read.
            Err(LogError::Packed { .. }) if path.is_file() => of(false),
            Err(error @ (LogError::Video { .. } | LogError::Foreign { .. })) => Err(error),
            _ => Ok(None),
        }
    }

    /// Its name: the folder's, or the file's without what follows the first dot.
    pub fn name(&self) -> String {
        let full = self.path.canonicalize().unwrap_or_else(|_| self.path.clone());
        let name = full.file_name().unwrap_or(full.as_os_str()).to_string_lossy().into_owned();
        match (full.is_dir(), name.split_once('.')) {
            (false, Some((stem, _))) if !stem.is_empty() => stem.to_owned(),
            _ => name,
        }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A camera's calibration in ASL's form that lies in the folder or beside the log.
    pub fn calibration(&self) -> Option<PathBuf> {
        let dirs = self.dirs().into_iter();
        dirs.flat_map(|dir| CALIBRATIONS.map(|file| dir.join(file))).find(|file| file.is_file())
    }

    /// Folders in which a calibration of any form may lie.
    pub fn calibration_dirs(&self) -> Vec<PathBuf> {
        let dirs = self.dirs();
        dirs.iter().cloned().chain(dirs.first().map(|dir| dir.join("cam0"))).collect()
    }

    /// The folder itself, and the one that it or the file lies in.
    fn dirs(&self) -> Vec<PathBuf> {
        let beside = self.path.parent().map(Path::to_path_buf);
        self.path.is_dir().then(|| self.path.clone()).into_iter().chain(beside).collect()
    }

    /// The files that it is read from, in order.
    ///
    /// # Errors
    /// A folder that cannot be listed.
    pub fn files(&self) -> Result<Vec<PathBuf>, LogError> {
        if self.is_folder {
            let folder = TimesFolder::read(&self.path)?;
            let list = folder.has_list().then_some(folder.times).into_iter();
            let images = folder.frames.into_iter().map(|(_, file)| file).filter(|file| file.is_file());
            return Ok(list.chain(ImuFile::of(&self.path)?.files()?).chain(images).collect());
        }
        if self.path.is_dir() {
            return Ok(crate::rosbag2::bags(&self.path)?.0);
        }
        Ok(vec![self.path.clone()])
    }

    /// The samples, having seen that there are images of `size` \[width, height\] beside them, on one topic, and that one of the first can be read.
    ///
    /// # Errors
    /// As [`read_log`]; no images, several topics of them and no choice, a topic that is not there; none of the first images of use; a list of another
    /// length than its folder.
    pub fn imu(&self, size: [usize; 2]) -> Result<Log, LogError> {
        let options = &self.options;
        if self.is_folder {
            let folder = TimesFolder::read(&self.path)?;
            if !options.skip_missing {
                folder.agree()?;
            }
            return read_log(ImuFile::of(&self.path)?.path(), &options.imu);
        }
        let cameras = Cameras::new(&self.path, options.image_topic.clone(), size);
        let mut survey = Survey { topics: Topics::new(&options.imu), cameras };
        let (kind, damage) = bag::read(&self.path, options.imu.max_uncompressed, &mut survey)?;
        let (listed, remark) = (survey.topics.listed(), survey.cameras.remark());
        let mut log = bag_log(&self.path, kind, survey.topics, damage, &options.imu)?;
        let topic = survey.cameras.choose(&listed)?;
        log.remarks.extend(remark.filter(|remark| remark.contains(&topic)));
        Ok(log)
    }

    /// The images within `span`, of `size` \[width, height\], read ahead on a second thread. One that cannot be read is an error in its place.
    ///
    /// # Errors
    /// Of a folder, as [`TimesFolder::read`].
    pub fn images(&self, size: [usize; 2], span: ImageSpan) -> Result<Images, LogError> {
        if self.is_folder {
            let folder = self.folder(size)?;
            let (stamps, first) = (folder.stamps().collect::<Vec<_>>(), folder.stamps().next());
            let within = |t: &Stamp| first.is_some_and(|first| span.misses(first, *t).is_none());
            let stamps: Vec<Stamp> = stamps.into_iter().filter(within).collect();
            let Some((from, to)) = stamps.first().zip(stamps.last()) else {
                return Ok(Box::new(std::iter::empty()));
            };
            let images = folder.between(*from, *to).prefetch(AHEAD);
            let images = images.map(|read| read.map(|stamped| stamped.image));
            return Ok(Box::new(stamps.into_iter().zip(images)));
        }
        let log = self.clone();
        Ok(Box::new(Prefetch::spawn(AHEAD, move |send| {
            let mut take = |event| {
                let SensorEvent::Image(t, image) = event else { return ControlFlow::Continue(()) };
                if send((t, image)) { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            };
            let mut stream = SensorStream::of_images(&log.path, &log.options, size, span, &mut take);
            let read = bag::read(&log.path, log.options.imu.max_uncompressed, &mut stream);
            let last = stream.last_image().unwrap_or(Stamp::from_ns(0));
            if let Err(error) = read.map(|_| ()).and(stream.finish()) {
                // What was readable a moment ago no longer is.
                let problem = format!("can no longer be read: {error}");
                send((last, Err(IoError::BadImage { path: log.path.clone(), problem })));
            }
        })))
    }

    /// Of a folder with `times.txt`, its images; those that are not there left out where that was asked for.
    ///
    /// # Errors
    /// As [`TimesFolder::read`].
    pub fn folder(&self, size: [usize; 2]) -> Result<ImageFolder, LogError> {
        let folder = ImageFolder::of(TimesFolder::read(&self.path)?.frames, size);
        Ok(if self.options.skip_missing { folder.only_present() } else { folder })
    }

    /// Whether it is a folder with `times.txt`.
    pub fn is_folder(&self) -> bool {
        self.is_folder
    }
}

/// Samples kept, topics of images looked at.
struct Survey {
    topics: Topics,
    cameras: Cameras,
}

impl Messages for Survey {
    fn next_file(&mut self) {
        self.topics.next_file();
        self.cameras.next_file();
    }

    fn declare(&mut self, number: u32, name: &str, kind: &str, encoding: Result<Encoding, String>) -> bool {
        let camera = self.cameras.declare(number, name, kind, encoding.clone());
        self.topics.declare(number, name, kind, encoding) || camera
    }

    fn message(&mut self, number: u32, received_ns: i64, data: &[u8]) {
        self.topics.message(number, received_ns, data);
        self.cameras.probe(number, data);
    }

    fn budget(&mut self) -> &mut crate::budget::Budget {
        self.topics.budget()
    }
}
