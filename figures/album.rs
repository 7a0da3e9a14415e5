//! Pictures of frames with their tracks, taken while a recording's images go through the front-end.

use crate::{FigureError, TrackDot, TrackEnd, TrackPicture};
use dpn_core::{GrayImage, Stamp};
use dpn_io::{ResultPath, write_file};
use dpn_vio::estimator::FrontEndObserver;
use dpn_vio::frontend::{Fed, Lost, LostBy};
use nalgebra::Vector2;
use std::collections::BTreeMap;

/// Takes a picture of a frame handed over every so often; it remembers where tracks were and how old they are.
#[derive(Debug)]
pub struct Album {
    dir: ResultPath,
    every_s: f64,
    first: Option<Stamp>,
    due_s: f64,
    /// Frames handed over in which a track has been, and its place in the last of them.
    known: BTreeMap<u64, (u32, Vector2<f64>)>,
    /// Tracks that ended since the last frame handed over.
    ended: Vec<TrackEnd>,
    /// The pictures so far.
    taken: usize,
    /// The first that could not be written; after it none is tried.
    failed: Option<FigureError>,
}

impl Album {
    /// Pictures go to `dir`, one every `every_s` seconds of data; 0 takes every frame handed over.
    pub fn new(dir: ResultPath, every_s: f64) -> Self {
        Self {
            dir,
            every_s,
            first: None,
            due_s: 0.0,
            known: BTreeMap::new(),
            ended: Vec::new(),
            taken: 0,
            failed: None,
        }
    }

    /// How many pictures there are.
    ///
    /// # Errors
    /// One that could not be drawn or written.
    pub fn finish(self) -> Result<usize, FigureError> {
        self.failed.map_or(Ok(self.taken), Err)
    }

    fn write(&self, picture: &TrackPicture<'_>, seconds: f64) -> Result<(), FigureError> {
        let bytes = picture.png()?;
        let path = self.dir.join(format!("tracks-{seconds:08.3}s.png"));
        write_file(&path, &bytes)?;
        Ok(())
    }
}

impl FrontEndObserver for Album {
    fn end(&mut self, image: &GrayImage, fed: &Fed) {
        if self.failed.is_some() {
            return;
        }
        let seconds = fed.report.t.seconds_since(*self.first.get_or_insert(fed.report.t));
        self.ended.extend(fed.report.lost.iter().filter_map(end));
        let Some(frame) = &fed.frame else { return };
        let mut known = BTreeMap::new();
        let mut dots = Vec::with_capacity(frame.tracks.len());
        for track in &frame.tracks {
            let before = self.known.get(&track.id);
            let age = before.map_or(1, |(age, _)| age + 1);
            dots.push(TrackDot { px: track.px.into(), before: before.map(|(_, px)| (*px).into()), age });
            known.insert(track.id, (age, track.px));
        }
        self.known = known;
        let ended = std::mem::take(&mut self.ended);
        // A microsecond for stamps that were rounded.
        if seconds < self.due_s - 1e-6 {
            return;
        }
        self.due_s =
            if self.every_s > 0.0 { (seconds / self.every_s + 1e-6).floor() * self.every_s } else { 0.0 };
        self.due_s += self.every_s;
        let outliers = ended.iter().filter(|end| end.outlier).count();
        let words = format!(
            "{seconds:.2} s: {} tracks, {} of them new, {outliers} outliers, {} lost",
            dots.len(),
            fed.report.new,
            ended.len() - outliers
        );
        let picture = TrackPicture { image, tracks: &dots, ended: &ended, words: &words };
        match self.write(&picture, seconds) {
            Ok(()) => self.taken += 1,
            Err(error) => self.failed = Some(error),
        }
    }
}

/// Where a track that ended is marked; those that left the image, or made room, are not worth a mark.
fn end(lost: &Lost) -> Option<TrackEnd> {
    let px = lost.px.into();
    match lost.by {
        LostBy::Ransac => Some(TrackEnd { px, outlier: true }),
        LostBy::Flat | LostBy::Back | LostBy::Unlike => Some(TrackEnd { px, outlier: false }),
        LostBy::Outside | LostBy::Crowded | LostBy::Blind => None,
    }
}
