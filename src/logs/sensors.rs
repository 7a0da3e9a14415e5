//! What a bag's sensors say, in the order in which it was recorded: samples and images, one by one.

use crate::budget::Budget;
use crate::cameras::Cameras;
use crate::fields::Encoding;
use crate::imu_message::{decode, is_imu};
use crate::live_imus::{LiveImus, Several};
use crate::messages::Messages;
use crate::topics::{is_wanted, shortened};
use crate::{ImageLogOptions, ImageSpan, LogError, Scales, bag};
use dpn_core::{GrayImage, ImuSample, Stamp};
use dpn_io::{IoError, printable};
use std::io::Read;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// What a sensor says.
#[derive(Debug)]
pub enum SensorEvent {
    /// A sample; stamps may go back, values may be no numbers.
    Sample(ImuSample),
    /// An image and when it was taken, or why there is none.
    Image(Stamp, Result<GrayImage, IoError>),
    /// A message that was passed over, and why.
    PassedOver(String),
}

/// Reads a bag as it comes, from `path` or from stdin for `-`, and hands everything its IMU and its camera say to `take`, until that breaks off; images are
/// to have `size` \[width, height\]. Returns what was wrong where it ended early.
///
/// # Errors
/// No bag; several IMUs or topics of images and no choice, as soon as the second one says something; none of either at its end.
pub fn read_sensors(
    path: &Path,
    options: &ImageLogOptions,
    size: [usize; 2],
    take: &mut dyn FnMut(SensorEvent) -> ControlFlow<()>,
) -> Result<Option<String>, LogError> {
    let mut stream = SensorStream::of_both(path, options, size, take);
    let (_, damage) = bag::read(path, options.imu.max_uncompressed, &mut stream)?;
    stream.finish().map(|()| damage)
}

/// The same from any source of bytes, a socket for example; `path` is for messages.
///
/// # Errors
/// As [`read_sensors`].
pub fn read_sensors_from(
    source: impl Read,
    path: &Path,
    options: &ImageLogOptions,
    size: [usize; 2],
    take: &mut dyn FnMut(SensorEvent) -> ControlFlow<()>,
) -> Result<Option<String>, LogError> {
    let mut stream = SensorStream::of_both(path, options, size, take);
    let (_, damage) = bag::stream(source, path, options.imu.max_uncompressed, &mut stream)?;
    stream.finish().map(|()| damage)
}

/// Hands on what the sensors say.
pub(crate) struct SensorStream<'a> {
    path: PathBuf,
    topic: Option<String>,
    scales: Scales,
    cameras: Cameras,
    size: [usize; 2],
    span: ImageSpan,
    first: Option<Stamp>,
    last: Option<Stamp>,
    /// None where only images are wanted.
    imu: Option<LiveImus>,
    /// All topics, for who finds nothing.
    others: Vec<String>,
    budget: Budget,
    done: bool,
    fault: Option<LogError>,
    take: &'a mut dyn FnMut(SensorEvent) -> ControlFlow<()>,
}

impl<'a> SensorStream<'a> {
    /// Of images alone.
    pub(crate) fn of_images(
        path: &Path,
        options: &ImageLogOptions,
        size: [usize; 2],
        span: ImageSpan,
        take: &'a mut dyn FnMut(SensorEvent) -> ControlFlow<()>,
    ) -> Self {
        let path = if path == Path::new("-") { Path::new("stdin") } else { path };
        Self {
            path: path.to_path_buf(),
            topic: options.imu.topic.clone(),
            scales: options.imu.si_scales(),
            cameras: Cameras::new(path, options.image_topic.clone(), size),
            size,
            span,
            first: None,
            last: None,
            imu: None,
            others: Vec::new(),
            budget: Budget::new(options.imu.max_uncompressed),
            done: false,
            fault: None,
            take,
        }
    }

    /// Of samples and images.
    fn of_both(
        path: &Path,
        options: &ImageLogOptions,
        size: [usize; 2],
        take: &'a mut dyn FnMut(SensorEvent) -> ControlFlow<()>,
    ) -> Self {
        let imu = Some(LiveImus::default());
        Self { imu, ..Self::of_images(path, options, size, ImageSpan::ALL, take) }
    }

    /// Stamp of the last image.
    pub(crate) fn last_image(&self) -> Option<Stamp> {
        self.last
    }

    /// # Errors
    /// What ended it early; no sensor of one kind, where the bag ended by itself.
    pub(crate) fn finish(mut self) -> Result<(), LogError> {
        if let Some(fault) = self.fault {
            return Err(fault);
        }
        if self.done {
            return Ok(());
        }
        let left = self.imu.as_mut().map(LiveImus::end);
        self.samples(left.unwrap_or_default());
        let topics = shortened(self.others.into_iter());
        if self.imu.is_some_and(|imu| !imu.is_chosen()) {
            return Err(LogError::NoImu { path: self.path, topics, damage: None });
        }
        if self.first.is_none() {
            self.cameras.choose(&topics)?;
        }
        Ok(())
    }

    fn end(&mut self, fault: LogError) {
        self.fault.get_or_insert(fault);
        self.done = true;
    }

    fn give(&mut self, event: SensorEvent) {
        self.done |= (self.take)(event).is_break();
    }

    /// Hands samples on, in their units.
    fn samples(&mut self, samples: Vec<ImuSample>) {
        for sample in samples {
            if self.done {
                return;
            }
            self.give(SensorEvent::Sample(self.scales.of(sample)));
        }
    }

    /// A message of an IMU; `None` where it is none.
    fn sample(&mut self, number: u32, received_ns: i64, data: &[u8]) -> Option<()> {
        let imu = self.imu.as_mut()?;
        let (index, name, encoding) = imu.topic(number)?;
        let sample = match decode(data, encoding) {
            Ok(message) if message.stamped => message.sample,
            Ok(message) => ImuSample { t: Stamp::from_ns(received_ns), ..message.sample },
            Err(why) => {
                let passed_over = format!("a message on {name}: such messages {why}");
                self.give(SensorEvent::PassedOver(passed_over));
                return Some(());
            }
        };
        match imu.take(index, sample) {
            Ok(samples) => self.samples(samples),
            Err(Several { one, topics, count }) => {
                let path = self.path.clone();
                self.end(LogError::SeveralTopics { path, count, topics, one });
            }
        }
        Some(())
    }
}

impl Messages for SensorStream<'_> {
    fn next_file(&mut self) {
        self.cameras.next_file();
        if let Some(imu) = &mut self.imu {
            imu.next_file();
        }
    }

    fn declare(&mut self, number: u32, name: &str, kind: &str, encoding: Result<Encoding, String>) -> bool {
        let shown = printable(name);
        // For words alone: what a hostile file declares without end makes no room.
        if self.others.len() < 100 {
            self.others.push(format!("{shown} ({})", printable(kind)));
        }
        let is_camera = self.cameras.declare(number, name, kind, encoding.clone());
        let Some(imu) = &mut self.imu else { return is_camera };
        imu.forget(number);
        if !is_imu(kind) || !is_wanted(self.topic.as_deref(), &shown) {
            return is_camera;
        }
        match encoding {
            Ok(encoding) => imu.declare(number, shown, encoding),
            Err(foreign) => {
                let (path, encoding) = (self.path.clone(), printable(&foreign));
                self.end(LogError::Encoding { path, topic: shown, encoding });
            }
        }
        true
    }

    fn message(&mut self, number: u32, received_ns: i64, data: &[u8]) {
        if self.done || self.sample(number, received_ns, data).is_some() {
            return;
        }
        let Some(seen) = self.cameras.message(number, received_ns, data) else { return };
        let t = seen.t;
        let first = *self.first.get_or_insert(t);
        if self.cameras.are_several() {
            let fault = self.cameras.several();
            return self.end(fault);
        }
        // Beside an IMU a stamp before the first is what somebody's clock was set to.
        let misses = if self.imu.is_some() { None } else { self.span.misses(first, t) };
        match misses {
            Some(ControlFlow::Break(())) => self.done = true,
            Some(ControlFlow::Continue(())) => {}
            None => {
                let image = seen.grey(&self.path, self.size);
                self.last = Some(t);
                self.give(SensorEvent::Image(t, image));
            }
        }
    }

    fn budget(&mut self) -> &mut Budget {
        &mut self.budget
    }

    fn is_done(&self) -> bool {
        self.done
    }
}
