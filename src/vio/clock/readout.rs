//! How long the lines of an image take to be read out, from how a turning camera bends the flow of points.
//!
//! Line y of h is exposed `readout (y/(h - 1) - 1/2)` after the image's stamp (`frontend::line_turns`). A camera that turns at the rate `w` meanwhile sees a
//! ray `y` of that line where the camera of the stamp sees `y + share readout w x y`. Between two frames the planes of points that stand still
//! (`frontend::two_view`) hold for rays at the stamps alone, so that
//!
//! ```text
//! e(readout) = p . (y x z) / |p x y| + readout * de/dreadout,   dy = share_y R (w_a x a),  dz = share_z w_b x z
//! ```
//!
//! with the pair's own turn and path beside it as unknowns: what is left is the change of `w` from frame to frame, and a point's way across lines. A path at an
//! even speed keeps its planes. Gauss-Newton over all pairs; turn and path are found anew at each step, for before a camera that hardly moves any path fits, and
//! with the wrong readout it is one that explains the readout.

use super::flow_turn::{FlowTurn, TRACK_STD_PX};
use super::gyro_course::GyroCourse;
use super::{ALIKE_PAIRS, weight};
use crate::frontend::{TwoView, line_delay, two_view};
use dpn_core::camera::CameraModel;
use dpn_core::geometry::so3;
use dpn_core::{Stamp, TrackFrame};
use nalgebra::{Matrix3, Matrix6, UnitQuaternion, Vector2, Vector3, Vector6};
use serde::Serialize;
use std::collections::VecDeque;

/// Fewest pairs for an answer: five seconds.
const FEWEST: usize = 50;
/// Pairs between two looks.
const EVERY: usize = 25;
/// Pairs that are looked at: ten seconds.
const MOST_PAIRS: usize = 100;
/// Rays of a pair that are.
const MOST_RAYS: usize = 60;
/// Steps of Gauss-Newton a look: each goes half the way, or more, and the next look goes on.
const STEPS: usize = 5;
/// A readout is one where it is so many deviations from none ...
const SURE: f64 = 5.0;
/// ... and so much \[s\]: less moves no point by a pixel.
const LEAST_S: f64 = 0.005;
/// What is in force is followed where it is off by so much, and by two deviations \[s\].
const FOLLOWED_S: f64 = 0.002;
/// Longest readout there is \[s\].
const LONGEST_S: f64 = 0.1;

/// A ray, and where in the image its line is, from -1/2 to 1/2.
#[derive(Debug, Clone, Copy)]
struct LineRay {
    ray: Vector3<f64>,
    share: f64,
}

/// What a pair of frames shares, until its samples are there.
#[derive(Debug, Clone)]
pub(super) struct LinePair {
    rays: Vec<[LineRay; 2]>,
    /// What was taken into account \[s\].
    readout_s: f64,
}

impl LinePair {
    /// None where other readouts were taken into account in both.
    pub(super) fn of(
        (a, b): (&TrackFrame, &TrackFrame),
        shared: &[(Vector2<f64>, Vector2<f64>)],
        camera: &CameraModel,
    ) -> Option<Self> {
        let seen = |px| Some(LineRay { ray: camera.bearing(px)?, share: line_delay(camera, px, 1.0) });
        let every = shared.len().div_ceil(MOST_RAYS).max(1);
        let rays = shared.iter().step_by(every).filter_map(|(a, b)| Some([seen(a)?, seen(b)?])).collect();
        (a.readout_s == b.readout_s).then_some(Self { rays, readout_s: a.readout_s })
    }
}

/// A pair whose samples are there.
#[derive(Debug, Clone)]
struct Seen {
    flow: FlowTurn,
    lines: LinePair,
    /// How the camera turns at both frames, in its axes \[rad/s\].
    rates: [Vector3<f64>; 2],
}

/// The last pairs, and what was found.
#[derive(Debug, Clone, Default)]
pub(super) struct ReadoutMeter {
    pairs: VecDeque<Seen>,
    /// Pairs since the last look.
    new: usize,
    /// Where Gauss-Newton goes on: beyond what was taken into account \[s\].
    beyond_s: f64,
    found: Option<Readout>,
}

/// Equations of one unknown, added up.
#[derive(Debug, Default)]
struct Sum {
    information: f64,
    gradient: f64,
    squares: f64,
    rows: f64,
}

/// A readout time that shows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Readout {
    /// From the first line's exposure to the last's \[s\]; below zero where an image is read out from below.
    pub seconds: f64,
    /// Its deviation \[s\].
    pub std_s: f64,
    /// The frame after which it was in force first, on the camera's clock.
    pub since: Stamp,
}

impl ReadoutMeter {
    /// Adds a pair whose stamps are `offset_s` short of the gyroscope's clock; one that samples do not cover adds nothing.
    pub(super) fn add(
        &mut self,
        flow: FlowTurn,
        lines: LinePair,
        course: &GyroCourse,
        offset_s: f64,
        cam_from_body: &UnitQuaternion<f64>,
    ) {
        let rate = |t: Stamp| Some(cam_from_body * course.rate(t.plus_seconds(offset_s))?);
        let Some((a, b)) = rate(flow.from).zip(rate(flow.to)) else { return };
        if self.pairs.front().is_some_and(|before| before.lines.readout_s != lines.readout_s) {
            self.forget();
        }
        self.pairs.push_back(Seen { flow, lines, rates: [a, b] });
        self.new += 1;
        while self.pairs.len() > MOST_PAIRS {
            self.pairs.pop_front();
        }
    }

    /// What was found.
    pub(super) fn found(&self) -> Option<Readout> {
        self.found
    }

    /// Forgets the pairs: they were of another clock, or another readout.
    pub(super) fn forget(&mut self) {
        self.pairs.clear();
        (self.new, self.beyond_s) = (0, 0.0);
    }

    /// Looks at what has come, every so often; `t` is the newest frame's.
    pub(super) fn look(&mut self, t: Stamp, camera: &CameraModel) {
        if self.pairs.len() < FEWEST || self.new < EVERY {
            return;
        }
        self.new = 0;
        let Some((beyond_s, std_s, last_step)) = self.beyond(camera) else { return };
        self.beyond_s = beyond_s;
        if last_step.abs() > 0.3 * std_s {
            // On its way still.
            return;
        }
        let seconds = self.pairs[0].lines.readout_s + beyond_s;
        let least =
            if self.found.is_some() { FOLLOWED_S.max(2.0 * std_s) } else { LEAST_S.max(SURE * std_s) };
        if beyond_s.abs() > least && seconds.abs() < LONGEST_S {
            let since = self.found.map_or(t, |found| found.since);
            self.found = Some(Readout { seconds, std_s, since });
            self.forget();
        }
    }

    /// By how much the readout is longer than what was taken into account, its deviation, and the last step towards it \[s\].
    fn beyond(&self, camera: &CameraModel) -> Option<(f64, f64, f64)> {
        let std = TRACK_STD_PX / camera.px_per_rad();
        let (mut seconds, mut std_s, mut step) = (self.beyond_s, f64::INFINITY, 0.0);
        for _ in 0..STEPS {
            let mut sum = Sum::default();
            self.pairs.iter().for_each(|pair| {
                pair.add_to(&mut sum, seconds, std);
            });
            if sum.information.is_nan() || sum.information <= 0.0 {
                return None;
            }
            step = sum.gradient / sum.information;
            seconds = (seconds + step).clamp(-LONGEST_S, LONGEST_S);
            std_s = (ALIKE_PAIRS * sum.squares / sum.rows.max(1.0) / sum.information).sqrt();
        }
        Some((seconds, std_s, step))
    }
}

impl Seen {
    /// Adds its equation at a readout of `seconds`, turn and path taken out; none where they cannot be told.
    fn add_to(&self, sum: &mut Sum, seconds: f64, std: f64) -> Option<()> {
        let b_from_a = so3::exp(&self.flow.turn).inverse();
        let [rate_a, rate_b] = self.rates;
        let moved = |line: &LineRay, rate: &Vector3<f64>| line.share * rate.cross(&line.ray);
        let (rays, by_readout): (Vec<_>, Vec<_>) = (self.lines.rays.iter())
            .map(|[a, b]| {
                let (by_a, by_b) = (moved(a, &rate_a), moved(b, &rate_b));
                let (y, z) = (b_from_a * (a.ray + seconds * by_a), b.ray + seconds * by_b);
                ([y.normalize(), z.normalize()], [b_from_a * by_a, by_b])
            })
            .unzip();
        let none = (Vector3::zeros(), Matrix3::zeros());
        let found = TwoView::of(&rays, none, self.flow.path, std)?;
        let basis = [1, 2].map(|k| two_view::across(&found.path, k));
        let (mut normal, mut right) = (Matrix6::<f64>::zeros(), Vector6::<f64>::zeros());
        let (mut squares, mut rows) = (0.0, 0.0);
        for ([y, z], [dy, dz]) in rays.iter().zip(&by_readout) {
            let Some((residual, by_pair)) = two_view::plane(&found.path, &basis, &found.turn, y, z) else {
                continue;
            };
            let turned = y + found.turn.cross(y);
            let by_readout =
                found.path.dot(&(dy.cross(z) + turned.cross(dz))) / found.path.cross(&turned).norm();
            let residual = residual / std;
            let slope = by_pair.push(by_readout) / std;
            let weight = weight(residual * residual, 1.0);
            normal += weight * slope * slope.transpose();
            right -= weight * residual * slope;
            squares += weight * residual * residual;
            rows += weight;
        }
        // A path that nothing is said of stays where it is.
        normal[(3, 3)] += 1.0;
        normal[(4, 4)] += 1.0;
        let across = (normal.fixed_view::<5, 5>(0, 0).into_owned().cholesky()?)
            .solve(&normal.fixed_view::<5, 1>(0, 5).into_owned());
        let information = normal[(5, 5)] - normal.fixed_view::<5, 1>(0, 5).dot(&across);
        let gradient = right[5] - right.fixed_rows::<5>(0).dot(&across);
        if information.is_finite() && gradient.is_finite() {
            sum.information += information;
            sum.gradient += gradient;
            sum.squares += squares;
            sum.rows += rows;
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::ClockWatch;
    use super::*;
    use dpn_core::random::Stream;
    use dpn_core::{ImuSample, Track};
    use nalgebra::Isometry3;
    use rand::Rng;
    use rand_distr::StandardNormal;

    fn rate(s: f64) -> Vector3<f64> {
        Vector3::new((4.0 * s).sin(), 0.8 * (5.1 * s + 1.0).sin(), 0.6 * (3.3 * s + 2.0).sin())
    }

    /// What of `readout_s` is found in seventeen seconds of a camera that is carried and turned by hand, half a pixel of noise on its tracks; what was found is
    /// taken into account from then on.
    fn found(readout_s: f64) -> Option<Readout> {
        let mut rng = Stream::new(11).named("readout").rng();
        let mut normal = move || -> f64 { rng.sample(StandardNormal) };
        let camera = CameraModel::euroc_cam0();
        // World from body every millisecond from half a second before the first image.
        let mut rotation = UnitQuaternion::identity();
        let poses: Vec<Isometry3<f64>> = (0..18_500)
            .map(|ms| {
                let s = f64::from(ms) * 1e-3;
                let pose =
                    Isometry3::from_parts(Vector3::new(0.3 * (2.0 * s).sin(), 0.2 * s, 0.1).into(), rotation);
                rotation *= so3::exp(&(rate(s + 5e-4) * 1e-3));
                pose
            })
            .collect();
        let at = |s: f64| poses[(s * 1e3).round() as usize];
        let points: Vec<Vector3<f64>> = (0..4_000)
            .map(|_| Vector3::new(normal(), normal(), normal()).normalize() * (4.0 + 2.0 * normal().tanh()))
            .collect();
        let mut watch = ClockWatch::new(camera, UnitQuaternion::identity(), None);
        for k in 0..3_700 {
            let t = Stamp::from_ns(5_000_000 * k);
            watch.feed_imu(&ImuSample { t, gyro: rate(5e-3 * k as f64).into(), accel: [0.0, 0.0, 9.81] });
        }
        for k in 0..170 {
            let s = 0.5 + 0.1 * f64::from(k);
            let mut tracks = Vec::new();
            let known = watch.readout().map_or(0.0, |found| found.seconds);
            for (id, point) in points.iter().enumerate() {
                let mut px = None;
                let mut delay = 0.0;
                for _ in 0..4 {
                    px = camera.project(&at(s + delay).inverse_transform_point(&(*point).into()).coords);
                    delay = px.map_or(0.0, |px| line_delay(&camera, &px, readout_s).clamp(-0.1, 0.1));
                }
                let at_stamp = |px: Vector2<f64>| {
                    let turned = at(s).rotation.inverse() * at(s + line_delay(&camera, &px, known)).rotation;
                    camera.project(&(turned * camera.bearing(&px)?))
                };
                let px = px.filter(|px| camera.contains(px, 0.0)).and_then(at_stamp);
                tracks.extend(
                    px.map(|px| Track { id: id as u64, px: px + 0.4 * Vector2::new(normal(), normal()) }),
                );
            }
            let t = Stamp::from_ns((1e9 * s) as i64);
            watch.feed_frame(&TrackFrame { readout_s: known, ..TrackFrame::new(t, tracks) });
        }
        watch.readout()
    }

    #[test]
    fn the_readout_of_a_rolling_shutter_is_found_and_none_where_there_is_none() {
        assert_eq!(found(0.0), None);
        for readout_s in [0.02, 0.03, -0.02] {
            let found = found(readout_s).unwrap();
            assert!((found.seconds - readout_s).abs() < 0.002, "{readout_s}: {found:?}");
        }
    }
}
