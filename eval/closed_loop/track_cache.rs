//! Tracks that were followed through images and rows of cells, kept in a folder for whoever needs the same again: another shard, another node, another command.
//!
//! An entry is named by the checksum of everything that the tracks are a function of (program, processor, the sequence's files, camera, front-end, seed, start and end), so
//! it is right or not there. It begins with the checksum of all that follows; one that is damaged is made anew, and said. While one process
//! makes an entry, others that need it wait, where the file system has locks; where it has none they make it too, with the same bytes. When all
//! entries together outgrow the limit, those go that were least recently used.

use super::image_report::ImageReport;
use super::recording::Span;
use super::row::Row;
use super::tracked::TrackedSequence;
use dpn_core::checksum::{of_bytes, of_parts};
use dpn_core::{Stamp, Track, TrackFrame};
use dpn_io::{IoError, ResultPath};
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};
use std::fs::{File, TryLockError};
use std::io;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, SystemTime};

/// End of an entry's name.
const END: &str = "tracks";
/// End of the name of the file whose lock says that an entry is being made.
const MAKING: &str = "making";
/// How often one that waits looks again.
const LOOK: Duration = Duration::from_millis(200);

/// A folder of kept tracks.
#[derive(Debug)]
pub struct TrackCache {
    dir: ResultPath,
    most: u64,
    taken: AtomicUsize,
    made: AtomicUsize,
    rows: AtomicUsize,
    remarks: Mutex<Vec<String>>,
}

/// The line behind an entry's checksum. Words of 8 bytes, little-endian, follow: of each frame its stamp and number of tracks, then of each of these id, x and y.
#[derive(Serialize, Deserialize)]
struct Content {
    key: String,
    span: (f64, Option<f64>),
    images: Option<ImageReport>,
}

impl TrackCache {
    /// The cache in `dir`, which is made; its entries take up to `most` bytes.
    ///
    /// # Errors
    /// A folder that cannot be made.
    pub fn open(dir: impl Into<ResultPath>, most: u64) -> Result<Self, IoError> {
        let dir = dir.into();
        let failed = |source| IoError::Write { path: dir.path().to_path_buf(), source };
        std::fs::create_dir_all(dir.path()).map_err(failed)?;
        let [taken, made, rows] = std::array::from_fn(|_| AtomicUsize::new(0));
        Ok(Self { dir, most, taken, made, rows, remarks: Mutex::default() })
    }

    /// What was taken and made, and what was wrong, a line each; nothing where nothing was asked.
    pub fn words(&self) -> Vec<String> {
        let (taken, made) = (self.taken.load(Ordering::Relaxed), self.made.load(Ordering::Relaxed));
        let mut words = self.remarks.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if taken + made > 0 {
            words.push(format!("tracks: {taken} taken from {}, {made} made", self.dir.display()));
        }
        match self.rows.load(Ordering::Relaxed) {
            0 => {}
            rows => words.push(format!("cells: {rows} taken from {}", self.dir.display())),
        }
        words
    }

    /// The row of the cell of this content, where it was run with this cache by whatever command and is `enough`.
    pub(super) fn row(&self, content: &str, enough: impl Fn(&Row) -> bool) -> Option<Row> {
        let text = self.row_path(content).read().ok()??;
        let row: Row = serde_json::from_slice(&text).ok()?;
        if row.cell != content || !enough(&row) {
            return None;
        }
        self.rows.fetch_add(1, Ordering::Relaxed);
        Some(row)
    }

    /// Keeps a cell's row.
    pub(super) fn keep_row(&self, row: &Row) {
        if let Err(error) = dpn_io::write_json(self.row_path(&row.cell), row) {
            self.remark(format!("a row is not kept: {}", with_cause(&error)));
        }
    }

    /// Processors of another kind make other bits.
    fn row_path(&self, content: &str) -> ResultPath {
        let name = of_parts([content, &dpn_pronet::processor()]);
        self.dir.join("cells").join(&name[..2]).join(format!("{name}.json"))
    }

    /// The tracks of `key`, and whether they were there; `make` makes them where they are not. A fault of the folder ends nothing: it is a remark.
    ///
    /// # Errors
    /// That of `make`.
    pub(super) fn get<E>(
        &self,
        key: &str,
        stop: &AtomicBool,
        make: impl FnOnce() -> Result<TrackedSequence, E>,
    ) -> Result<(TrackedSequence, bool), E> {
        if let Some(found) = self.read(key) {
            return Ok((found, true));
        }
        let making = self.dir.join(format!("{key}.{MAKING}"));
        let lock = self.claim(&making, stop);
        // Whoever held it may just have made it.
        if let Some(found) = lock.as_ref().and_then(|_| self.read(key)) {
            return Ok((found, true));
        }
        let made = make();
        if let Ok(made) = &made {
            self.made.fetch_add(1, Ordering::Relaxed);
            if let Err(error) = self.keep(key, made) {
                self.remark(format!("tracks are not kept: {}", with_cause(&error)));
            }
        }
        // Who waits for its lock has it open, and finds the entry first.
        let _ = making.remove();
        Ok((made?, false))
    }

    /// The lock on an entry's making; none where there are no locks, or on a stop.
    fn claim(&self, path: &ResultPath, stop: &AtomicBool) -> Option<File> {
        let file = path.open_lock().ok()?;
        loop {
            match file.try_lock() {
                Ok(()) => return Some(file),
                Err(TryLockError::WouldBlock) if !stop.load(Ordering::Relaxed) => std::thread::sleep(LOOK),
                Err(_) => return None,
            }
        }
    }

    fn path(&self, key: &str) -> ResultPath {
        self.dir.join(format!("{key}.{END}"))
    }

    fn remark(&self, words: String) {
        self.remarks.lock().unwrap_or_else(PoisonError::into_inner).push(words);
    }

    fn read(&self, key: &str) -> Option<TrackedSequence> {
        let path = self.path(key);
        match read(&path, key) {
            Ok(None) => None,
            Ok(found) => {
                self.taken.fetch_add(1, Ordering::Relaxed);
                // Used now. Who may read it only leaves its age as it is.
                let _ = path.append().map(|file| file.set_modified(SystemTime::now()));
                found
            }
            Err(error) => {
                self.remark(format!("{}; made anew", with_cause(&error)));
                None
            }
        }
    }

    fn keep(&self, key: &str, tracked: &TrackedSequence) -> Result<(), IoError> {
        let path = self.path(key);
        let bytes = bytes_of(key, tracked);
        if bytes.len() as u64 > self.most {
            self.remark(format!(
                "{}: not kept, for its {} bytes are more than the cache holds",
                path.display(),
                bytes.len()
            ));
            return Ok(());
        }
        dpn_io::write_file(&path, &bytes)?;
        self.make_room(&path)
    }

    /// Removes entries until all take no more than the limit, the least recently used first and never `newest`.
    fn make_room(&self, newest: &ResultPath) -> Result<(), IoError> {
        let mut entries = Vec::new();
        for (name, _) in self.dir.list()? {
            if Path::new(&name).extension().is_none_or(|end| end != END) {
                continue;
            }
            // One that another process removed meanwhile is none.
            let opened = self.dir.join(&name).open().ok().flatten();
            let Some(about) = opened.and_then(|file| file.metadata().ok()) else { continue };
            entries.push((about.modified().unwrap_or(SystemTime::UNIX_EPOCH), name, about.len()));
        }
        entries.sort();
        let mut all: u64 = entries.iter().map(|(.., bytes)| bytes).sum();
        let newest = newest.path().file_name();
        for (_, name, bytes) in entries.into_iter().filter(|(_, name, _)| Some(name.as_os_str()) != newest) {
            if all <= self.most {
                break;
            }
            let _ = self.dir.join(name).remove();
            all -= bytes;
        }
        Ok(())
    }
}

fn with_cause(error: &IoError) -> String {
    match std::error::Error::source(error) {
        Some(cause) => format!("{error}: {cause}"),
        None => error.to_string(),
    }
}

fn bytes_of(key: &str, tracked: &TrackedSequence) -> Vec<u8> {
    let span = (tracked.span.from_s, tracked.span.to_s);
    let content = Content { key: key.to_owned(), span, images: tracked.images.clone() };
    let mut told = serde_json::to_vec(&content).expect("numbers, texts and lists of them");
    told.push(b'\n');
    let mut put = |word: u64| told.extend(word.to_le_bytes());
    for frame in &tracked.frames {
        put(frame.t.ns().cast_unsigned());
        put(frame.readout_s.to_bits());
        put(frame.clock_s.to_bits());
        put(frame.tracks.len() as u64);
        for track in &frame.tracks {
            [track.id, track.px.x.to_bits(), track.px.y.to_bits()].into_iter().for_each(&mut put);
        }
    }
    [of_bytes(&told).into_bytes(), told].concat()
}

fn read(path: &ResultPath, key: &str) -> Result<Option<TrackedSequence>, IoError> {
    let Some(bytes) = path.read()? else { return Ok(None) };
    let damaged = || IoError::reading(path.path(), io::Error::new(io::ErrorKind::InvalidData, "damaged"));
    parse(&bytes, key).map(Some).ok_or_else(damaged)
}

/// What [`bytes_of`] wrote for this key; `None` where it did not.
fn parse(bytes: &[u8], key: &str) -> Option<TrackedSequence> {
    let (checksum, told) = bytes.split_at_checked(64)?;
    if checksum != of_bytes(told).as_bytes() {
        return None;
    }
    let end = told.iter().position(|byte| *byte == b'\n')?;
    let content: Content = serde_json::from_slice(&told[..end]).ok()?;
    if content.key != key {
        return None;
    }
    let mut words = told[end + 1..].as_chunks().0.iter().map(|bytes| u64::from_le_bytes(*bytes));
    let mut frames = Vec::new();
    while let Some(t) = words.next() {
        let [readout_s, clock_s] = [f64::from_bits(words.next()?), f64::from_bits(words.next()?)];
        let count = words.next()?;
        let track = |_| {
            let [id, x, y] = [words.next()?, words.next()?, words.next()?];
            Some(Track { id, px: Vector2::new(f64::from_bits(x), f64::from_bits(y)) })
        };
        let tracks = (0..count).map(track).collect::<Option<_>>()?;
        frames.push(TrackFrame { t: Stamp::from_ns(t.cast_signed()), tracks, readout_s, clock_s });
    }
    let (from_s, to_s) = content.span;
    Some(TrackedSequence { frames, span: Span { from_s, to_s }, images: content.images })
}

#[cfg(test)]
mod tests {
    use super::super::image_report::FrontEndFigures;
    use super::*;

    fn tracked(frames: i64) -> TrackedSequence {
        let track = |t: i64, id: u64| Track { id, px: Vector2::new(0.1 * t as f64, -0.3 * id as f64) };
        let frame = |t| TrackFrame {
            readout_s: 0.001 * t as f64,
            clock_s: -0.002 * t as f64,
            t: Stamp::from_ns(7 * t),
            tracks: (0..(t as u64 % 5)).map(|id| track(t, u64::MAX - id)).collect(),
        };
        let figures = FrontEndFigures {
            images: 9,
            tracks: 0.1 + 0.2,
            inlier_share: Some(1.0 / 3.0),
            ..FrontEndFigures::default()
        };
        TrackedSequence {
            frames: (0..frames).map(frame).collect(),
            span: Span { from_s: 0.5, to_s: None },
            images: Some(ImageReport { figures, ..ImageReport::default() }),
        }
    }

    fn same(a: &TrackedSequence, b: &TrackedSequence) -> bool {
        a.frames == b.frames && a.span == b.span && a.images == b.images
    }

    fn make(frames: i64) -> impl FnOnce() -> Result<TrackedSequence, String> {
        move || Ok(tracked(frames))
    }

    fn never() -> Result<TrackedSequence, String> {
        panic!("it is there")
    }

    #[test]
    fn what_is_kept_comes_back_to_the_bit_and_a_damaged_one_is_made_anew_and_said() {
        let (dir, stop) = (tempfile::tempdir().unwrap(), AtomicBool::new(false));
        let cache = TrackCache::open(dir.path(), 1 << 20).unwrap();
        let (first, there) = cache.get("a", &stop, make(40)).unwrap();
        assert!(!there && same(&first, &tracked(40)));
        let (second, there) = cache.get("a", &stop, never).unwrap();
        assert!(there && same(&second, &first));
        let path = dir.path().join("a.tracks");
        let good = std::fs::read(&path).unwrap();
        for place in (0..good.len()).step_by(97) {
            let mut bad = good.clone();
            bad[place] ^= 4;
            for bytes in [&bad[..], &good[..place]] {
                std::fs::write(&path, bytes).unwrap();
                let (again, _) = cache.get("a", &stop, make(40)).unwrap();
                assert!(same(&again, &first), "byte {place}");
            }
        }
        let words = cache.words();
        assert!(
            words.iter().any(|line| line.contains("a.tracks") && line.ends_with("; made anew")),
            "{words:?}"
        );
        // The name says what it is: another's content under it is none.
        std::fs::copy(&path, dir.path().join("b.tracks")).unwrap();
        assert!(!cache.get("b", &stop, make(3)).unwrap().1);
        assert!(
            std::fs::read_dir(dir.path()).unwrap().all(|f| f
                .unwrap()
                .path()
                .extension()
                .is_some_and(|e| e == "tracks"))
        );
    }

    #[test]
    fn a_fault_of_the_maker_is_handed_on_and_keeps_nothing() {
        let (dir, stop) = (tempfile::tempdir().unwrap(), AtomicBool::new(false));
        let cache = TrackCache::open(dir.path(), 1 << 20).unwrap();
        assert_eq!(cache.get("a", &stop, || Err("no images")).err(), Some("no images"));
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
    }

    #[test]
    fn the_least_recently_used_go_first_and_all_stay_within_the_limit() {
        let (dir, stop) = (tempfile::tempdir().unwrap(), AtomicBool::new(false));
        let one = bytes_of("a", &tracked(40)).len() as u64;
        let cache = TrackCache::open(dir.path(), 3 * one + one / 2).unwrap();
        let age = |key: &str, seconds| {
            let file = File::options().append(true).open(dir.path().join(format!("{key}.tracks"))).unwrap();
            file.set_modified(SystemTime::now() - Duration::from_secs(seconds)).unwrap();
        };
        for (key, seconds) in [("a", 300), ("b", 200), ("c", 100)] {
            cache.get(key, &stop, make(40)).unwrap();
            age(key, seconds);
        }
        // Used: not the oldest any more.
        assert!(cache.get("a", &stop, never).unwrap().1);
        cache.get("d", &stop, make(40)).unwrap();
        let there = |key: &str| dir.path().join(format!("{key}.tracks")).is_file();
        assert_eq!(["a", "b", "c", "d"].map(there), [true, false, true, true]);
        assert!(!cache.get("big", &stop, make(4000)).unwrap().1);
        assert!(!there("big") && cache.words().iter().any(|line| line.contains("more than the cache holds")));
    }

    #[test]
    fn of_two_that_need_the_same_at_once_one_makes_it() {
        let (dir, stop) = (tempfile::tempdir().unwrap(), AtomicBool::new(false));
        let makings = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    // Each its own, as processes have.
                    let cache = TrackCache::open(dir.path(), 1 << 20).unwrap();
                    let make = || {
                        makings.fetch_add(1, Ordering::SeqCst);
                        std::thread::sleep(Duration::from_millis(100));
                        Ok::<_, String>(tracked(40))
                    };
                    assert!(same(&cache.get("a", &stop, make).unwrap().0, &tracked(40)));
                });
            }
        });
        assert_eq!(makings.load(Ordering::SeqCst), 1);
    }
}
