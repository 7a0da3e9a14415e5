//! The images of a recording: which are there, one by one, and ahead of time on a second thread.
//!
//! Images are PNG or JPEG; colour becomes grey. One that is listed but missing, cannot be read or has another size is an error that names the file; whoever reads says whether that ends the run. A recording that lists images nobody unpacked is common (one has a
//! part of a data set): [`ImageFolder::coverage`] says what there is before a run begins.

use super::IoError;
use super::asl::{CameraFrame, Sequence};
use super::image_file::read_image;
use dpn_core::image::GrayImage;
use dpn_core::time::Stamp;
use std::fmt;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;

/// An image and when it was taken.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StampedImage {
    /// When.
    pub t: Stamp,
    /// What the camera saw.
    pub image: GrayImage,
}

/// The images a recording lists.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImageFolder {
    frames: Vec<(Stamp, PathBuf)>,
    size: [usize; 2],
}

impl ImageFolder {
    /// The images of a sequence's first camera; whether they are there is not looked at yet.
    ///
    /// # Errors
    /// No stamps or no calibration of `cam0`, or files of them that cannot be read.
    pub fn open(sequence: &Sequence) -> Result<Self, IoError> {
        let frames = sequence.camera_frames()?;
        let config = sequence
            .camera_config()?
            .ok_or_else(|| IoError::Missing { path: sequence.camera_path().with_file_name("sensor.yaml") })?;
        let place = |frame: CameraFrame| (frame.t, sequence.image_path(&frame));
        Ok(Self {
            frames: frames.into_iter().map(place).collect(),
            size: config.resolution.map(|side| side as usize),
        })
    }

    /// Images named by the caller, in increasing time; each is to have `size` \[width, height\].
    pub fn of(frames: Vec<(Stamp, PathBuf)>, size: [usize; 2]) -> Self {
        Self { frames, size }
    }

    /// The same, without images before `from` and after `to`.
    #[must_use]
    pub fn between(mut self, from: Stamp, to: Stamp) -> Self {
        self.frames.retain(|(t, _)| (from..=to).contains(t));
        self
    }

    /// The same, without images that are not there.
    #[must_use]
    pub fn only_present(mut self) -> Self {
        self.frames.retain(|(_, path)| path.is_file());
        self
    }

    /// Whether any image is there; looks no further than the first that is.
    pub fn holds_any(&self) -> bool {
        self.frames.iter().any(|(_, path)| path.is_file())
    }

    /// Stamps and files of all images listed, whether they are there or not.
    pub fn files(&self) -> &[(Stamp, PathBuf)] {
        &self.frames
    }

    /// How many images are listed.
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Whether none is.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Stamps of all images listed.
    pub fn stamps(&self) -> impl ExactSizeIterator<Item = Stamp> + '_ {
        self.frames.iter().map(|(t, _)| *t)
    }

    /// Looks which files are there; none is opened.
    pub fn coverage(&self) -> Coverage {
        let mut runs: Vec<ImageRun> = Vec::new();
        let mut first_missing = None;
        let mut unbroken = false;
        for (t, path) in &self.frames {
            let there = path.is_file();
            match runs.last_mut() {
                Some(run) if there && unbroken => (run.to, run.images) = (*t, run.images + 1),
                _ if there => runs.push(ImageRun { from: *t, to: *t, images: 1 }),
                _ => first_missing = first_missing.or_else(|| Some(path.clone())),
            }
            unbroken = there;
        }
        Coverage {
            listed: self.frames.len(),
            first: self.frames.first().map(|(t, _)| *t),
            runs,
            first_missing,
        }
    }

    /// Reads image `index`.
    ///
    /// # Errors
    /// A file that is not there or cannot be read; neither PNG nor JPEG, another size.
    ///
    /// # Panics
    /// `index` is not below [`Self::len`].
    pub fn read(&self, index: usize) -> Result<StampedImage, IoError> {
        let (t, path) = &self.frames[index];
        Ok(StampedImage { t: *t, image: read_image(path, self.size)? })
    }

    /// Reads all images in order on a thread of their own, at most `ahead` before they are asked for.
    pub fn prefetch(self, ahead: usize) -> Prefetch<Result<StampedImage, IoError>> {
        Prefetch::spawn(ahead, move |send| {
            let _all_sent = (0..self.len()).all(|index| send(self.read(index)));
        })
    }
}

/// Images in a row, all there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageRun {
    /// Stamp of the first.
    pub from: Stamp,
    /// Stamp of the last.
    pub to: Stamp,
    /// How many.
    pub images: usize,
}

/// Which of the images listed are there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Coverage {
    /// How many are listed.
    pub listed: usize,
    /// Stamp of the first that is listed, from which ranges are counted.
    pub first: Option<Stamp>,
    /// Those that are there, in time.
    pub runs: Vec<ImageRun>,
    /// The first that is not.
    pub first_missing: Option<PathBuf>,
}

impl Coverage {
    /// How many are there.
    pub fn present(&self) -> usize {
        self.runs.iter().map(|run| run.images).sum()
    }

    /// Whether all are.
    pub fn is_complete(&self) -> bool {
        self.first_missing.is_none()
    }

    /// The longest run: the range that can be used. The first of several as long.
    pub fn longest(&self) -> Option<ImageRun> {
        self.runs.iter().copied().rev().max_by_key(|run| run.images)
    }

    /// That range in seconds after the first image listed, outwards to whole milliseconds.
    pub fn longest_s(&self) -> Option<[f64; 2]> {
        let (run, first) = (self.longest()?, self.first?);
        let ms = |t: Stamp| t.seconds_since(first) * 1e3;
        // A microsecond, so that a whole number of milliseconds stays what it is under a clock's trembling.
        Some([(ms(run.from) + 1e-3).floor() / 1e3, (ms(run.to) - 1e-3).ceil() / 1e3])
    }
}

/// One line: how many are missing, and the longest range that is there in seconds since the first stamp listed.
impl fmt::Display for Coverage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let missing = self.listed - self.present();
        let Some(first) = &self.first_missing else { return write!(f, "{} images, all there", self.listed) };
        write!(
            f,
            "{missing} of {} images are not there, the first of them {}",
            self.listed,
            first.display()
        )?;
        if let Some((run, [from, to])) = self.longest().zip(self.longest_s()) {
            write!(f, "; {} in a row are, from {from} to {to} s after the first listed", run.images)?;
        }
        Ok(())
    }
}

/// What a thread of its own makes ahead of time, in order: images. Dropping it ends the making.
#[derive(Debug)]
pub struct Prefetch<T> {
    receiver: Option<Receiver<T>>,
    thread: Option<JoinHandle<()>>,
}

impl<T: Send + 'static> Prefetch<T> {
    /// Of what `make` sends, at most `ahead` are made before they are asked for; it is answered whether anybody still waits for more.
    pub fn spawn(ahead: usize, make: impl FnOnce(&mut dyn FnMut(T) -> bool) + Send + 'static) -> Self {
        let (sender, receiver) = sync_channel(ahead);
        let thread = std::thread::spawn(move || make(&mut |item| sender.send(item).is_ok()));
        Self { receiver: Some(receiver), thread: Some(thread) }
    }
}

impl<T> Iterator for Prefetch<T> {
    type Item = T;

    fn next(&mut self) -> Option<T> {
        match self.receiver.as_ref()?.recv() {
            Ok(item) => Some(item),
            Err(_) => {
                // The thread is through; that it panicked must not read as the end.
                if let Some(Err(panic)) = self.thread.take().map(JoinHandle::join) {
                    std::panic::resume_unwind(panic);
                }
                None
            }
        }
    }
}

impl<T> Drop for Prefetch<T> {
    fn drop(&mut self) {
        // The thread may be waiting for room: without a receiver it goes home.
        self.receiver = None;
        if let Some(thread) = self.thread.take() {
            // Whoever drops it does not want the images that are left, nor what befell them.
            drop(thread.join());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::image_file::tests::grey;
    use super::*;
    use std::fs;
    use std::path::Path;

    /// Images 0 to `n`, of which those in `missing` are listed only.
    fn folder(dir: &Path, n: u8, missing: &[u8]) -> ImageFolder {
        let frames = (0..n).map(|i| {
            let path = dir.join(format!("{i}.png"));
            if !missing.contains(&i) {
                fs::write(&path, grey(i)).unwrap();
            }
            (Stamp::from_ns(i64::from(i) * 50_000_000), path)
        });
        ImageFolder::of(frames.collect(), [4, 3])
    }

    #[test]
    fn prefetched_images_are_those_read_one_by_one() {
        let dir = tempfile::tempdir().unwrap();
        let folder = folder(dir.path(), 9, &[]);
        let plain: Vec<_> = (0..9).map(|i| folder.read(i).unwrap()).collect();
        assert_eq!(plain[3].image.pixels()[1], 10);
        for ahead in [0, 1, 20] {
            let fetched: Vec<_> = folder.clone().prefetch(ahead).map(Result::unwrap).collect();
            assert_eq!(fetched, plain);
        }
        // One that is dropped early ends too.
        let mut some = folder.prefetch(1);
        assert!(some.next().is_some());
        drop(some);
    }

    #[test]
    fn missing_images_are_counted_and_the_longest_range_is_said() {
        let dir = tempfile::tempdir().unwrap();
        let folder = folder(dir.path(), 10, &[0, 4, 5]);
        let coverage = folder.coverage();
        assert_eq!((coverage.listed, coverage.present(), coverage.runs.len()), (10, 7, 2));
        let longest = coverage.longest().unwrap();
        assert_eq!((longest.from.ns(), longest.to.ns(), longest.images), (300_000_000, 450_000_000, 4));
        let said = coverage.to_string();
        assert!(said.starts_with("3 of 10 images are not there") && said.contains("0.png"), "{said}");
        assert!(said.ends_with("4 in a row are, from 0.3 to 0.45 s after the first listed"), "{said}");
        assert_eq!(coverage.longest_s(), Some([0.3, 0.45]));
        assert_eq!(folder.files().iter().filter(|(_, path)| !path.exists()).count(), 3);
        assert!(folder.holds_any() && folder.clone().only_present().coverage().is_complete());
        assert!(!ImageFolder::of(vec![(Stamp::from_ns(0), dir.path().join("x.png"))], [4, 3]).holds_any());
        let part = folder.clone().between(longest.from, longest.to);
        assert!(part.coverage().is_complete() && part.len() == 4);
        assert!(part.stamps().eq([300, 350, 400, 450].map(|ms| Stamp::from_ns(ms * 1_000_000))));
        assert_eq!(part.coverage().to_string(), "4 images, all there");
        // A missing one is an error in its place; the others come all the same.
        let outcomes: Vec<_> = folder.prefetch(2).collect();
        assert!(matches!(&outcomes[4], Err(IoError::Missing { path }) if path.ends_with("4.png")));
        assert_eq!(outcomes.iter().filter(|o| o.is_ok()).count(), 7);
    }

    #[test]
    fn an_image_of_another_size_is_named_with_both() {
        let dir = tempfile::tempdir().unwrap();
        let folder = ImageFolder { size: [8, 3], ..folder(dir.path(), 1, &[]) };
        let error = folder.read(0).unwrap_err().to_string();
        assert!(error.ends_with("0.png has 4 x 3 px; the camera's have 8 x 3"), "{error}");
    }
}
