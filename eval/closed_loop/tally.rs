//! What is counted while images go through the front-end.

use super::image_report::{FrontEndFigures, ImageEvent, ImageReport, PassedOver};
use super::rhythm::Rhythm;
use crate::stats::percentile;
use cpu_time::ThreadTime;
use dpn_core::signal::stats::upper_median;
use dpn_core::{GrayImage, Stamp};
use dpn_vio::estimator::FrontEndObserver;
use dpn_vio::frontend::ransac::Geometry;
use dpn_vio::frontend::{Fed, LostBy, Status};
use std::collections::BTreeMap;

/// Most events that are kept.
const MOST_EVENTS: usize = 200;

/// Which ids there were: a bit each, for they are given in a row.
#[derive(Debug, Default)]
struct IdSet(BTreeMap<u64, u64>);

impl IdSet {
    fn insert(&mut self, id: u64) {
        *self.0.entry(id / 64).or_default() |= 1 << (id % 64);
    }

    fn len(&self) -> usize {
        self.0.values().map(|bits| bits.count_ones() as usize).sum()
    }
}

/// Counts, of which [`finish`](Self::finish) makes figures.
#[derive(Debug, Default)]
pub(super) struct Tally {
    /// Stamps of all that came.
    images: Vec<Stamp>,
    over: usize,
    events: Vec<ImageEvent>,
    more_events: usize,
    /// Why the image before was passed over.
    before: Option<PassedOver>,
    asked: usize,
    agreed: usize,
    consensus: usize,
    by_gyro: usize,
    followed: usize,
    not_home: usize,
    /// Frames handed over, their tracks, and which these were.
    frames: usize,
    sightings: usize,
    ids: IdSet,
    /// Mean grey of the last image that was looked at, and by what share it changed from image to image.
    grey: Option<f64>,
    changes: Vec<f64>,
    /// When the image under way was begun.
    clock: Option<ThreadTime>,
    /// CPU time of each image \[s\].
    seconds: Vec<f64>,
}

impl Tally {
    /// Images so far.
    pub(super) fn images(&self) -> usize {
        self.images.len()
    }

    /// An image of which nothing was made.
    pub(super) fn passed_over(&mut self, t: Stamp, reason: PassedOver, words: String) {
        self.count(t);
        self.over += 1;
        let at_s = t.seconds_since(self.images[0]);
        let same = self.before.replace(reason) == Some(reason);
        let room = self.events.len() < MOST_EVENTS;
        match self.events.last_mut() {
            Some(event) if same && self.more_events == 0 => {
                (event.to_s, event.images) = (at_s, event.images + 1);
            }
            _ if room => self.events.push(ImageEvent { from_s: at_s, to_s: at_s, images: 1, reason, words }),
            _ => self.more_events += usize::from(!same),
        }
    }

    fn count(&mut self, t: Stamp) {
        self.images.push(t);
    }

    /// What was wrong with most of the images that nothing was made of.
    pub(super) fn worst(&self) -> Option<&ImageEvent> {
        self.events.iter().max_by_key(|event| event.images)
    }

    /// Frames handed over so far.
    pub(super) fn frames(&self) -> usize {
        self.frames
    }

    /// The figures; a frame was handed over.
    pub(super) fn finish(self) -> ImageReport {
        let share = |part: usize, of: usize| (of > 0).then(|| part as f64 / of as f64);
        let mut stamps = self.images;
        stamps.sort();
        let (first, last) = stamps.first().zip(stamps.last()).expect("a frame is of an image");
        let p95_s = percentile(&self.seconds, 0.95).expect("an image was worked off");
        let figures = FrontEndFigures {
            images: stamps.len(),
            passed_over: self.over,
            tracks: self.sightings as f64 / self.frames as f64,
            track_length: self.sightings as f64 / self.ids.len().max(1) as f64,
            inlier_share: share(self.agreed, self.asked),
            by_gyro_share: share(self.by_gyro, self.consensus),
            not_home_share: share(self.not_home, self.followed),
            cpu_per_data_s: self.seconds.iter().sum::<f64>() / last.seconds_since(*first),
            p95_ms: 1e3 * p95_s,
        };
        ImageReport {
            figures,
            events: self.events,
            more_events: self.more_events,
            flicker: upper_median(self.changes).unwrap_or(0.0),
            rhythm: Rhythm::of(stamps.into_iter()),
        }
    }
}

impl FrontEndObserver for Tally {
    fn begin(&mut self, _: Stamp) {
        self.clock = Some(ThreadTime::now());
    }

    fn end(&mut self, _: &GrayImage, fed: &Fed) {
        let clock = self.clock.take().expect("an image is begun before it ends");
        self.seconds.push(clock.elapsed().as_secs_f64());
        if let Some(frame) = &fed.frame {
            self.frames += 1;
            self.sightings += frame.tracks.len();
            frame.tracks.iter().for_each(|track| self.ids.insert(track.id));
        }
        let report = &fed.report;
        match report.status {
            Status::Tracked | Status::HandedOver => {}
            Status::Blind => {
                return self.passed_over(report.t, PassedOver::Blind, "dark, saturated, or all alike".into());
            }
            Status::Repeated => {
                let words = "the image before over again".into();
                return self.passed_over(report.t, PassedOver::Repeated, words);
            }
            Status::WrongSize { .. } | Status::OutOfOrder { .. } => {
                unreachable!("the tracker refuses such an image before the front-end sees it")
            }
        }
        self.count(report.t);
        if let Some(grey) = report.image.map(|image| image.mean) {
            let change = |before: f64| (grey - before).abs() / before.max(1.0);
            self.changes.extend(self.grey.replace(grey).map(change));
        }
        self.before = None;
        self.followed += report.before;
        self.not_home += report.lost_by(LostBy::Back);
        if let Some(agreement) = report.agreement {
            self.asked += agreement.asked;
            self.agreed += agreement.agreed;
            self.consensus += 1;
            self.by_gyro += usize::from(agreement.geometry == Geometry::TwoPoint);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_in_a_row_with_one_fault_are_one_event() {
        let mut tally = Tally::default();
        let at = |i: i64| Stamp::from_ns(i * 50_000_000);
        for i in 0..10 {
            let reason = if (3..7).contains(&i) { PassedOver::Repeated } else { PassedOver::Unreadable };
            tally.passed_over(at(i), reason, format!("no {i}"));
        }
        assert_eq!(tally.events.iter().map(|e| e.images).collect::<Vec<_>>(), [3, 4, 3]);
        assert_eq!((tally.images(), tally.over), (10, 10));
        let words = tally.worst().unwrap().to_string();
        assert_eq!(words, "4 images passed over from 0.15 to 0.30 s: no 3");
    }

    #[test]
    fn an_id_is_counted_once_however_large() {
        let mut ids = IdSet::default();
        for id in [0, 1, 63, 64, 64, 1, u64::MAX, u64::MAX] {
            ids.insert(id);
        }
        assert_eq!(ids.len(), 5);
    }

    #[test]
    fn a_recording_full_of_faults_keeps_few_of_them() {
        let mut tally = Tally::default();
        for i in 0..1000 {
            let reason = if i % 2 == 0 { PassedOver::Repeated } else { PassedOver::Blind };
            tally.passed_over(Stamp::from_ns(i), reason, String::new());
        }
        assert_eq!((tally.events.len(), tally.more_events), (200, 800));
    }
}
