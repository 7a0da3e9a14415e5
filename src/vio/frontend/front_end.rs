//! The front-end itself: images in, tracks out.

use super::config::FrontEndConfig;
use super::corners::{Detector, Mask};
use super::gyro_bias::GyroBias;
use super::image::{ImageStats, Pyramid};
use super::klt::{Klt, KltConfig, Shift, Template};
use super::line_turns::LineTurns;
use super::predict::turned;
use super::ransac::{DOUBT_SHARE, Pair, agree};
use super::report::{Agreement, FrameReport, Lost, LostBy, Status};
use super::schedule::Schedule;
use dpn_core::camera::CameraModel;
use dpn_core::config::{ConfigFault, Validate};
use dpn_core::random::Stream;
use dpn_core::signal::stats::upper_median;
use dpn_core::{GrayImage, GrayView, Stamp, Track, TrackFrame};
use nalgebra::{UnitQuaternion, Vector2, Vector3};
use std::time::{Duration, Instant};

/// Stamps are rounded; a pause is not longer than another by this little \[s\].
const ROUNDING_S: f64 = 1e-6;

/// With fewer tracks in agreement than this share nothing is learnt of the gyroscope.
const BELIEVED_SHARE: f64 = 0.5;

/// A rotation that is right within this share of the consensus' threshold is known.
const KNOWN_SHARE: f64 = 0.5;
/// A known rotation is doubted where fewer tracks than this share agree with it.
const KNOWN_DOUBT: f64 = 0.35;
/// What so many tracks fit, they all fit but for mistakes in tracking.
const ALL_SHARE: f64 = 0.9;

/// The way back ends with a step below this share of what home is held to.
const BACK_SHARE: f64 = 0.1;

/// How long tracks outlive images that show nothing or come twice \[s\].
const BRIDGE_S: f64 = 0.3;
/// Images farther apart than this are not tracked across \[s\].
const GAP_S: f64 = 1.0;
/// Share of dark and saturated pixels above which an image shows nothing.
const BLIND_SHARE: f64 = 0.97;
/// An image whose grey values deviate less than this shows nothing.
const BLIND_STD: f64 = 2.0;

/// A track as it goes on.
#[derive(Debug, Clone)]
struct Point {
    id: u64,
    px: [f32; 2],
    /// What `px` sees, in the camera's frame at the image's stamp.
    bearing: Vector3<f64>,
    /// The same in the last frame that was handed over.
    handed: Option<Vector3<f64>>,
    /// How fast it moved into `px` beyond what the camera's turn explains \[px/s\]; none where it is new or the turn was not known.
    drift: Option<[f32; 2]>,
    /// Images in which it was seen.
    age: u32,
    /// What it is held to; none where it began at the image's edge.
    template: Option<Template>,
}

impl Point {
    fn lost(&self, by: LostBy) -> Lost {
        Lost { id: self.id, px: self.pixel(), by }
    }

    fn pixel(&self) -> Vector2<f64> {
        Vector2::from(self.px.map(f64::from))
    }
}

/// What comes back for an image.
#[derive(Debug, Clone, PartialEq)]
pub struct Fed {
    /// The tracks, where this image was handed over.
    pub frame: Option<TrackFrame>,
    /// What happened.
    pub report: FrameReport,
}

/// Follows points from image to image and hands frames of tracks over at an even rate.
///
/// Its memory does not grow. Its answers are a function of images, stamps, rotations, configuration and stream.
#[derive(Debug, Clone)]
pub struct FrontEnd {
    camera: CameraModel,
    config: FrontEndConfig,
    stream: Stream,
    klt: Klt,
    /// The way back, which need not look like anything: it is compared with home.
    back: Klt,
    detector: Detector,
    allowed: Option<GrayImage>,
    mask: Mask,
    schedule: Schedule,
    /// The last image that was tracked into, and room for the next.
    prev: Pyramid,
    cur: Pyramid,
    /// When that was; none before the first and after a pause.
    tracked: Option<Stamp>,
    /// The last image that was in order.
    last: Option<Stamp>,
    fingerprint: Option<u64>,
    /// When the last frame was handed over.
    handed: Option<Stamp>,
    /// The camera's turn since the last image tracked into, and since the last frame handed over, as measured.
    since_tracked: Option<UnitQuaternion<f64>>,
    since_handed: Option<UnitQuaternion<f64>>,
    /// The camera's turns while the newest image was read out; none where its lines are taken at once.
    lines: Option<LineTurns>,
    gyro_bias: GyroBias,
    points: Vec<Point>,
    next_id: u64,
    frames: u64,
}

impl FrontEnd {
    /// A front-end for `camera`; `stream` is the chance of its consensus.
    ///
    /// # Errors
    /// Settings outside their bounds, all of them.
    pub fn new(
        camera: CameraModel,
        config: FrontEndConfig,
        stream: &Stream,
    ) -> Result<Self, Vec<ConfigFault>> {
        config.validate()?;
        Ok(Self {
            camera,
            config,
            stream: stream.named("front-end"),
            klt: Klt::new(config.klt),
            // Whether it comes home within half a pixel needs no more than shifts, and these not to a hundredth.
            back: Klt::new(KltConfig {
                min_correlation: 0.0,
                affine: false,
                epsilon_px: config.klt.epsilon_px.max(BACK_SHARE * config.klt.back_px).min(1.0),
                ..config.klt
            }),
            detector: Detector::new(config.corners),
            allowed: circle_of(&camera),
            mask: Mask::default(),
            schedule: Schedule::new(config.rate_hz),
            prev: Pyramid::default(),
            cur: Pyramid::default(),
            tracked: None,
            last: None,
            fingerprint: None,
            handed: None,
            gyro_bias: GyroBias::default(),
            since_tracked: None,
            since_handed: None,
            lines: None,
            points: Vec::new(),
            next_id: 0,
            frames: 0,
        })
    }

    /// Its settings.
    pub fn config(&self) -> &FrontEndConfig {
        &self.config
    }

    /// Takes the image of time `t`.
    ///
    /// `cur_from_last` is the rotation from the camera's frame at the image fed before (whatever became of it, unless it was out of
    /// order) to the camera's frame now, as the gyroscope integrates it (see `gyro_turn`); without it
    /// points are looked for where they were. It may be a little wrong: a bias of .1 rad/s is, and is learnt within a second.
    ///
    /// Whatever the image is, the answer is a report: nothing about it is an error, and no track is made up.
    pub fn feed(
        &mut self,
        image: GrayView<'_>,
        t: Stamp,
        cur_from_last: Option<&UnitQuaternion<f64>>,
    ) -> Fed {
        self.feed_lines(image, t, cur_from_last, None)
    }

    /// The same for an image that was read out line after line: `lines` are the camera's turns meanwhile.
    pub(crate) fn feed_lines(
        &mut self,
        image: GrayView<'_>,
        t: Stamp,
        cur_from_last: Option<&UnitQuaternion<f64>>,
        lines: Option<LineTurns>,
    ) -> Fed {
        let before = self.points.len();
        let report = |status| FrameReport::new(t, status, before);
        if let Some(last) = self.last.filter(|last| *last >= t) {
            let report = FrameReport { kept: before, ..report(Status::OutOfOrder { last_ns: last.ns() }) };
            return Fed { frame: None, report };
        }
        let since_last = self.last.map_or(0.0, |last| t.seconds_since(last));
        self.last = Some(t);
        self.turn(cur_from_last);

        let (width, height) = (image.width(), image.height());
        if [width, height] != self.camera.size().map(|side| side as usize) {
            return self.pass_over(report(Status::WrongSize { width, height }));
        }
        let start = Instant::now();
        let stats = ImageStats::of(image);
        let mut report = FrameReport { image: Some(stats), ..report(Status::Tracked) };
        let repeated = self.fingerprint.replace(stats.fingerprint) == Some(stats.fingerprint);
        let blind = stats.unusable() >= BLIND_SHARE || stats.std < BLIND_STD;
        if blind || repeated {
            report.times.image = start.elapsed();
            report.status = if blind { Status::Blind } else { Status::Repeated };
            return self.pass_over(report);
        }
        self.lines = lines;
        let klt = self.config.klt;
        self.cur.build(image, klt.levels.max(klt.foreseen_levels).max(klt.back_levels));
        report.times.image = start.elapsed();

        if self.tracked.is_some_and(|tracked| t.seconds_since(tracked) > GAP_S + ROUNDING_S) {
            self.give_up(&mut report);
        }
        let (tracking, elapsed) = timed(|| self.track(&mut report));
        report.times.track = elapsed;
        report.motion_px = tracking;
        std::mem::swap(&mut self.prev, &mut self.cur);
        (self.tracked, self.since_tracked) = (Some(t), Some(UnitQuaternion::identity()));

        let frame = self.schedule.is_due(t, since_last).then(|| self.hand_over(t, &mut report));
        report.kept = self.points.len() - report.new;
        let ages: u64 = self.points.iter().map(|point| u64::from(point.age)).sum();
        report.mean_age = ages as f64 / self.points.len().max(1) as f64;
        Fed { frame, report }
    }

    /// Adds a turn to those under way; one that is not known makes them unknown.
    fn turn(&mut self, cur_from_last: Option<&UnitQuaternion<f64>>) {
        let turn = cur_from_last.filter(|turn| turn.coords.iter().all(|v| v.is_finite()));
        for sum in [&mut self.since_tracked, &mut self.since_handed] {
            *sum = sum.zip(turn).map(|(sum, turn)| turn * sum);
        }
    }

    /// An image that tracks are not followed into: they wait, but not for ever.
    fn pass_over(&mut self, mut report: FrameReport) -> Fed {
        if self.tracked.is_some_and(|tracked| report.t.seconds_since(tracked) > BRIDGE_S + ROUNDING_S) {
            self.give_up(&mut report);
        }
        report.kept = self.points.len();
        Fed { frame: None, report }
    }

    /// Ends all tracks; the next image begins anew.
    fn give_up(&mut self, report: &mut FrameReport) {
        report.lost.extend(self.points.drain(..).map(|point| point.lost(LostBy::Blind)));
        self.tracked = None;
    }

    /// Follows all points from the last image into this one, and back; returns the median distance they moved \[px\].
    fn track(&mut self, report: &mut FrameReport) -> f64 {
        if self.points.is_empty() {
            return 0.0;
        }
        let tracked = self.tracked.expect("points are of an image that was tracked into");
        let seconds = report.t.seconds_since(tracked);
        let turn = self.since_tracked.map(|turn| self.gyro_bias.corrected(&turn, seconds));
        let by_turn = |point: &Point| {
            let px = turn.and_then(|turn| {
                let px = turned(&self.camera, &point.bearing, &turn)?;
                match &self.lines {
                    None => Some(px),
                    Some(lines) => {
                        lines.pixel(&self.camera, &(turn * point.bearing), px, &self.gyro_bias.bias())
                    }
                }
            });
            px.map(|px| [px.x as f32, px.y as f32])
        };
        let by_turn: Vec<Option<[f32; 2]>> = self.points.iter().map(by_turn).collect();
        let klt = self.config.klt;
        let shift = |at: usize, guess: [f32; 2]| (at, Shift { from: self.points[at].px, guess });
        let foreseen = |at: usize| {
            let (by_turn, drift) = (by_turn[at]?, self.points[at].drift?);
            Some(shift(at, [0, 1].map(|i| by_turn[i] + drift[i] * seconds as f32)))
        };
        let near: Vec<(usize, Shift)> = (0..self.points.len()).filter_map(foreseen).collect();
        // Who is not looked for near is looked for far: every answer is written over.
        let mut found = vec![Err(LostBy::Outside); self.points.len()];
        self.there_and_back(&near, klt.foreseen_levels, &mut found);
        // Who was not found near where it was foreseen, or has no past, is looked for from farther away.
        let far: Vec<(usize, Shift)> = (0..self.points.len())
            .filter(|at| found[*at].is_err())
            .map(|at| shift(at, by_turn[at].unwrap_or(self.points[at].px)))
            .collect();
        self.there_and_back(&far, klt.levels, &mut found);

        let mut distances = Vec::with_capacity(self.points.len());
        let (camera, lines, bias) = (self.camera, self.lines, self.gyro_bias.bias());
        let mut found = found.into_iter().zip(by_turn);
        self.points.retain_mut(|point| {
            let (answer, by_turn) = found.next().expect("an answer for every point");
            let place = match answer {
                Ok(place) => place,
                Err(loss) => {
                    report.lost.push(point.lost(loss));
                    return false;
                }
            };
            let Some(bearing) = sight(&camera, lines.as_ref(), place, &bias) else {
                report.lost.push(point.lost(LostBy::Outside));
                return false;
            };
            distances.push(distance(place, point.px));
            (point.px, point.bearing) = (place, bearing);
            point.drift = by_turn.map(|by_turn| [0, 1].map(|i| (place[i] - by_turn[i]) / seconds as f32));
            point.age += 1;
            true
        });
        upper_median(distances).unwrap_or(0.0)
    }

    /// Follows points, each with its number, into this image and back; what became of each goes to its place in `found`.
    fn there_and_back(
        &self,
        points: &[(usize, Shift)],
        levels: usize,
        found: &mut [Result<[f32; 2], LostBy>],
    ) {
        let klt = self.config.klt;
        let shifts: Vec<Shift> = points.iter().map(|(_, shift)| *shift).collect();
        let places = self.klt.track(&self.prev, &self.cur, &shifts, levels);
        // Back, from where a point was found, with home as the first guess.
        let back: Vec<Shift> = (shifts.iter().zip(&places))
            .filter_map(|(shift, place)| Some(Shift { from: place.ok()?, guess: shift.from }))
            .collect();
        let homes = if klt.back_px > 0.0 {
            self.back.track(&self.cur, &self.prev, &back, klt.back_levels)
        } else {
            back.iter().map(|shift| Ok(shift.guess)).collect()
        };
        let mut homes = homes.into_iter();
        for ((at, shift), place) in points.iter().zip(places) {
            found[*at] = place.and_then(|place| {
                let home = homes.next().expect("as many ways back as points were found");
                let came_home = home.is_ok_and(|home| distance(home, shift.from) <= klt.back_px);
                if came_home { Ok(place) } else { Err(LostBy::Back) }
            });
        }
    }

    /// Takes out what does not agree, fills up with new points, and makes the frame.
    fn hand_over(&mut self, t: Stamp, report: &mut FrameReport) -> TrackFrame {
        if self.config.klt.template {
            let ((), elapsed) = timed(|| self.hold(report));
            report.times.track += elapsed;
        }
        let ((), elapsed) = timed(|| self.reject(report));
        report.times.ransac = elapsed;
        let ((), elapsed) = timed(|| {
            self.thin_out(report);
            self.fill_up(report);
        });
        report.times.corners = elapsed;

        report.status = Status::HandedOver;
        self.schedule.handed_over(t);
        self.frames += 1;
        (self.handed, self.since_handed) = (Some(t), Some(UnitQuaternion::identity()));
        self.points.iter_mut().for_each(|point| point.handed = Some(point.bearing));
        // Of lines that were taken one after the other, the pixels at which the camera of the stamp would have seen the same.
        let px = |point: &Point| match self.lines {
            None => Some(point.pixel()),
            Some(_) => self.camera.project(&point.bearing),
        };
        let tracks = self.points.iter().filter_map(|p| Some(Track { id: p.id, px: px(p)? })).collect();
        let readout_s = self.lines.map_or(0.0, |lines| lines.readout_s());
        TrackFrame { readout_s, ..TrackFrame::new(t, tracks) }
    }

    /// Moves points to where the windows they began with are.
    fn hold(&mut self, report: &mut FrameReport) {
        // The image is the earlier one already: it was put there when it had been tracked into.
        let plane = self.prev.planes().first().expect("a pyramid that was built has its base");
        self.klt.hold(plane, self.points.iter_mut().map(|point| (&mut point.template, &mut point.px)));
        let (camera, lines, bias) = (self.camera, self.lines, self.gyro_bias.bias());
        self.points.retain_mut(|point| {
            let bearing = sight(&camera, lines.as_ref(), point.px, &bias);
            match bearing {
                Some(bearing) => point.bearing = bearing,
                None => report.lost.push(point.lost(LostBy::Outside)),
            }
            bearing.is_some()
        });
    }

    /// Asks the tracks what they agree on since the last frame that was handed over.
    fn reject(&mut self, report: &mut FrameReport) {
        let asked: Vec<Pair> = self
            .points
            .iter()
            .filter_map(|point| Some(Pair { prev: point.handed?, cur: point.bearing }))
            .collect();
        let stream = self.stream.index(self.frames);
        let focal = self.camera.px_per_rad();
        let seconds = self.handed.map_or(0.0, |handed| report.t.seconds_since(handed));
        let turn = self.since_handed.map(|turn| self.gyro_bias.corrected(&turn, seconds));
        let threshold_px = self.config.ransac.threshold_px;
        let known = self.gyro_bias.is_known(seconds, KNOWN_SHARE * threshold_px / focal);
        // A rotation that is known is doubted when few tracks agree with it, not when a bus drives by.
        let doubt = if known { KNOWN_DOUBT } else { DOUBT_SHARE };
        let mut found = agree(&asked, turn.as_ref(), focal, threshold_px, doubt, &stream);
        if let (true, Some(measured), Some(essential)) = (known, self.since_handed, found.essential)
            && found.share() < DOUBT_SHARE
        {
            // Unless all tracks together agree with another bias: then it is the gyroscope that changed.
            let mut anew = self.gyro_bias.forgotten();
            if anew.learn(&asked, &measured, &essential, focal, seconds) >= ALL_SHARE {
                self.gyro_bias = anew;
                let turn = self.gyro_bias.corrected(&measured, seconds);
                found = agree(&asked, Some(&turn), focal, threshold_px, DOUBT_SHARE, &stream);
            }
        }
        if found.essential.is_none() {
            return;
        }
        // A free matrix fits what moves by itself as well: where half agree with the rotation, these are the ones to learn from.
        let of_rotation = found.by_rotation.as_deref().filter(|known| known.share() >= BELIEVED_SHARE);
        let believed = of_rotation.unwrap_or(&found);
        let sure = believed.share() >= BELIEVED_SHARE;
        if let (Some(measured), Some(essential)) = (self.since_handed.filter(|_| sure), believed.essential) {
            let agreeing: Vec<Pair> = asked
                .iter()
                .zip(&believed.inliers)
                .filter_map(|(pair, agrees)| agrees.then_some(*pair))
                .collect();
            self.gyro_bias.learn(&agreeing, &measured, &essential, focal, seconds);
        }
        report.gyro_bias = self.gyro_bias.bias();
        report.agreement = Some(Agreement {
            geometry: found.geometry,
            asked: asked.len(),
            agreed: found.agreeing,
            trials: found.trials,
        });
        let mut inliers = found.inliers.into_iter();
        self.points.retain(|point| {
            let agrees = point.handed.is_none() || inliers.next().expect("an answer for every pair asked");
            if !agrees {
                report.lost.push(point.lost(LostBy::Ransac));
            }
            agrees
        });
    }

    /// Ends tracks that came within half the distance of new points of an older one: both would soon be the same.
    fn thin_out(&mut self, report: &mut FrameReport) {
        let [width, height] = self.camera.size().map(|side| side as usize);
        self.mask.reset(width, height, None);
        let radius = 0.5 * self.config.corners.distance_px;
        let mask = &mut self.mask;
        // Older tracks have smaller numbers and stand first.
        self.points.retain(|point| {
            let [x, y] = point.px.map(|c| c.round() as usize);
            let alone = mask.is_free(x, y);
            if alone {
                mask.take_disc(point.px, radius);
            } else {
                report.lost.push(point.lost(LostBy::Crowded));
            }
            alone
        });
    }

    /// Begins new tracks where there is room.
    fn fill_up(&mut self, report: &mut FrameReport) {
        let [width, height] = self.camera.size().map(|side| side as usize);
        self.mask.reset(width, height, self.allowed.as_ref().map(GrayImage::view));
        let places: Vec<[f32; 2]> = self.points.iter().map(|point| point.px).collect();
        // The image is the earlier one already: it was put there when it had been tracked into.
        let plane = self.prev.planes().first().expect("a pyramid that was built has its base");
        for corner in self.detector.detect(plane, &mut self.mask, &places) {
            let Some(bearing) = sight(&self.camera, self.lines.as_ref(), corner.px, &self.gyro_bias.bias())
            else {
                continue;
            };
            self.points.push(Point {
                id: self.next_id,
                px: corner.px,
                bearing,
                handed: None,
                drift: None,
                age: 1,
                template: None,
            });
            self.next_id += 1;
            report.new += 1;
        }
        if self.config.klt.template {
            let new = self.points.iter_mut().skip(places.len());
            self.klt.hold(plane, new.map(|point| (&mut point.template, &mut point.px)));
        }
    }
}

/// A fish-eye's edge is a contour that stands still: new points keep so far from it \[px\].
const EDGE_PX: f64 = 12.0;

/// Where a lens sees something of use, with room beside; `None` where it does everywhere.
fn circle_of(camera: &CameraModel) -> Option<GrayImage> {
    if camera.sees_all() {
        return None;
    }
    let [width, height] = camera.size().map(|side| side as usize);
    let allowed = |x: usize, y: usize| {
        let from_centre = Vector2::new(x as f64, y as f64) - camera.principal();
        let outwards = from_centre + from_centre.try_normalize(1e-9).unwrap_or_default() * EDGE_PX;
        u8::from(camera.sight(&(camera.principal() + outwards)).is_some())
    };
    GrayImage::from_fn(width, height, allowed).ok()
}

/// What `px` sees, in the camera's frame at the image's stamp; `bias` is the gyroscope's, in that frame.
fn sight(
    camera: &CameraModel,
    lines: Option<&LineTurns>,
    px: [f32; 2],
    bias: &Vector3<f64>,
) -> Option<Vector3<f64>> {
    let px = Vector2::from(px.map(f64::from));
    match lines {
        None => camera.sight(&px),
        Some(lines) => lines.sight(camera, &px, bias),
    }
}

fn distance(a: [f32; 2], b: [f32; 2]) -> f64 {
    f64::from(a[0] - b[0]).hypot(f64::from(a[1] - b[1]))
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed())
}

#[cfg(test)]
mod circle {
    use super::*;

    #[test]
    fn a_fish_eye_has_points_inside_its_circle_alone() {
        let camera = CameraModel::tumvi_cam0();
        let speckle =
            |x: usize, y: usize| (x.wrapping_mul(2_654_435_761) ^ y.wrapping_mul(40_503) >> 3) as u8;
        let image = GrayImage::from_fn(512, 512, |x, y| speckle(x / 9, y / 9)).unwrap();
        let mut front_end = FrontEnd::new(camera, FrontEndConfig::default(), &Stream::new(1)).unwrap();
        let frame = front_end.feed(image.view(), Stamp::from_ns(0), None).frame.unwrap();
        let seen: Vec<_> = frame.tracks.iter().map(|track| track.px).collect();
        assert!(seen.len() > 50, "{}", seen.len());
        let at_edge = |px: &Vector2<f64>| {
            let outwards = (px - camera.principal()).normalize() * (EDGE_PX - 2.0);
            camera.sight(&(px + outwards)).is_none()
        };
        assert!(!seen.iter().any(at_edge));
        // A pinhole's image has no such circle.
        assert_eq!(circle_of(&CameraModel::euroc_cam0()), None);
    }
}
