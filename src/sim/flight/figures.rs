//! The figures of a flight as control points: hover, line, circle, eight, one after the other from where the last ended.
//!
//! A figure's control points are samples, one a knot, of a closed form whose progress eases in and out
//! (s(u) = u^3 (10 - 15 u + 6 u^2)), so that figures join at rest; the spline then rounds what is left.

use super::character::{Character, Mix};
use dpn_core::random::StreamRng;
use nalgebra::{Vector1, Vector3};
use rand::Rng;
use rand_distr::StandardNormal;
use std::f64::consts::{PI, TAU};

/// Control points of position and heading, growing figure by figure.
pub(super) struct Pen<'a> {
    character: &'a Character,
    rng: StreamRng,
    pub(super) position: Vec<Vector3<f64>>,
    pub(super) yaw: Vec<Vector1<f64>>,
    at: Vector3<f64>,
    heading: f64,
}

/// Largest acceleration of a figure before the spline rounds it \[m/s^2\]; a figure too fast for it is slowed down.
const MAX_ACC: f64 = 4.5;

/// Largest first and second derivative of [`ease`].
const EASE_RATE: f64 = 1.875;
const EASE_ACC: f64 = 5.774;

/// From 0 to 1 with zero first and second derivative at both ends.
fn ease(u: f64) -> f64 {
    let u = u.clamp(0.0, 1.0);
    u * u * u * (10.0 + u * (6.0 * u - 15.0))
}

impl<'a> Pen<'a> {
    pub(super) fn new(character: &'a Character, mut rng: StreamRng) -> Self {
        let half = 0.5 * character.half_width;
        let at = Vector3::new(rng.random_range(-half..half), rng.random_range(-half..half), 0.0);
        let heading = rng.random_range(-PI..PI);
        Self { character, rng, position: Vec::new(), yaw: Vec::new(), at, heading }
    }

    /// `n` equal control points: the body stands.
    pub(super) fn stand(&mut self, n: usize) {
        self.position.extend(std::iter::repeat_n(self.at, n));
        self.yaw.extend(std::iter::repeat_n(Vector1::new(self.heading), n));
    }

    /// Straight up or down to height `z` in `n` control points.
    pub(super) fn lift(&mut self, z: f64, n: usize) {
        let from = self.at;
        self.figure(n, 0.0, |u| Vector3::new(from.x, from.y, from.z + (z - from.z) * u));
    }

    /// Figures drawn from the mix for exactly `n` control points; the last is a hover that fills up.
    pub(super) fn fly(&mut self, n: usize) {
        let end = self.position.len() + n;
        // Three seconds of hover at least before landing, so that nothing moves on touching down.
        let calm = (3.0 / self.character.knot_s).ceil() as usize;
        let mut refused = 0;
        while self.position.len() + calm < end && refused < 20 {
            if !self.draw_figure(end - self.position.len() - calm) {
                refused += 1;
            }
        }
        self.hover(end - self.position.len());
    }

    /// Draws one figure; false when it does not fit into `room` control points.
    fn draw_figure(&mut self, room: usize) -> bool {
        let Mix { hover, line, circle, eight } = self.character.mix;
        let speed = self.character.speed * self.rng.random_range(0.7..1.3);
        let draw = self.rng.random_range(0.0..hover + line + circle + eight);
        if draw < hover {
            let seconds = self.rng.random_range(2.0..6.0);
            let n = self.knots(seconds);
            self.hover(n.min(room));
            true
        } else if draw < hover + line {
            self.line(speed, room)
        } else if draw < hover + line + circle {
            self.circle(speed, room)
        } else {
            self.eight(speed, room)
        }
    }

    /// Whole knots in about `seconds`, four at least.
    fn knots(&self, seconds: f64) -> usize {
        ((seconds / self.character.knot_s).round() as usize).max(4)
    }

    fn hover(&mut self, n: usize) {
        let at = self.at;
        self.figure(n, 0.2, |_| at);
    }

    fn line(&mut self, speed: f64, room: usize) -> bool {
        let c = self.character;
        let to = Vector3::new(
            self.rng.random_range(-c.half_width..c.half_width),
            self.rng.random_range(-c.half_width..c.half_width),
            self.rng.random_range(c.floor..c.ceiling),
        );
        let from = self.at;
        let length = (to - from).norm();
        let n = self.knots(f64::max(length / speed, (EASE_ACC * length / MAX_ACC).sqrt()));
        n <= room && {
            self.figure(n, 1.0, |u| from + (to - from) * u);
            true
        }
    }

    /// One to two turns about a point between here and the middle of the room, rising or sinking.
    fn circle(&mut self, speed: f64, room: usize) -> bool {
        let c = self.character;
        let inward = Vector3::new(-self.at.x, -self.at.y, 0.0);
        let bend = self.rng.random_range(-0.6..0.6);
        let angle = if inward.norm() > 0.2 { inward.y.atan2(inward.x) + bend } else { bend * 5.0 };
        let radius = self.rng.random_range(0.3..0.6) * c.half_width;
        let turns = self.rng.random_range(1.0..2.0) * if self.rng.random::<bool>() { 1.0 } else { -1.0 };
        let to_z = self.rng.random_range(c.floor..c.ceiling);
        let from = self.at;
        let angle_all = TAU * f64::abs(turns);
        let fastest = EASE_RATE * angle_all * (radius / MAX_ACC).sqrt();
        let n = self.knots(f64::max(radius * angle_all / speed, fastest));
        n <= room && {
            let centre = from + Vector3::new(angle.cos(), angle.sin(), 0.0) * radius;
            self.figure(n, 1.0, |u| {
                let a = angle + PI + TAU * turns * u;
                Vector3::new(
                    centre.x + radius * a.cos(),
                    centre.y + radius * a.sin(),
                    from.z + (to_z - from.z) * u,
                )
            });
            true
        }
    }

    /// A lemniscate of Gerono through the current point, in a plane that is tilted a little.
    fn eight(&mut self, speed: f64, room: usize) -> bool {
        let c = self.character;
        let size = self.rng.random_range(0.4..0.8) * c.half_width;
        let turn = self.rng.random_range(-PI..PI);
        let tilt = self.rng.random_range(-0.25..0.25);
        let from = self.at;
        // The curve with unit half width is 6.1 long, and its second derivative at most sqrt(1 + 4).
        let fastest = EASE_RATE * TAU * (2.24 * size / MAX_ACC).sqrt();
        let n = self.knots(f64::max(6.1 * size / speed, fastest));
        n <= room && {
            self.figure(n, 1.0, |u| {
                let a = TAU * u;
                let (along, across) = (size * a.sin(), size * a.sin() * a.cos());
                from + Vector3::new(
                    along * turn.cos() - across * turn.sin(),
                    along * turn.sin() + across * turn.cos(),
                    along * tilt,
                )
            });
            true
        }
    }

    /// `n` control points along `curve` over \[0, 1\], with corrections, inside the flight space; the heading turns
    /// by a rate drawn for this figure, times `turning`.
    fn figure(&mut self, n: usize, turning: f64, curve: impl Fn(f64) -> Vector3<f64>) {
        if n == 0 {
            return;
        }
        let c = self.character;
        let rate = 1.3 * self.rng.random_range(-1.0..1.0) * c.yaw_rate * turning;
        let turn = rate * n as f64 * c.knot_s;
        let (from_heading, flying) = (self.heading, turning > 0.0);
        for k in 1..=n {
            let u = ease(k as f64 / n as f64);
            let mut point = curve(u);
            let mut heading = from_heading + turn * u;
            self.heading = heading;
            if flying {
                point.x = point.x.clamp(-c.half_width, c.half_width);
                point.y = point.y.clamp(-c.half_width, c.half_width);
                point.z = point.z.clamp(c.floor, c.ceiling);
                self.at = point;
                for axis in 0..3 {
                    point[axis] += c.correction * self.rng.sample::<f64, _>(StandardNormal);
                }
                heading += c.yaw_correction * self.rng.sample::<f64, _>(StandardNormal);
            } else {
                self.at = point;
            }
            self.position.push(point);
            self.yaw.push(Vector1::new(heading));
        }
    }
}
