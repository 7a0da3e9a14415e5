//! Plain CDR written: numbers at multiples of their size, the lowest byte first, counted from a message's first field.
//!
//! Source: OMG DDS-XTypes 1.3, 7.4 (version 1).

use dpn_core::Stamp;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

/// A message's fields, one after the other.
#[derive(Debug, Default)]
pub(crate) struct Cdr(Vec<u8>);

impl Cdr {
    pub(crate) fn u8(&mut self, value: u8) {
        self.0.push(value);
    }

    pub(crate) fn u32(&mut self, value: u32) {
        self.number(value.to_le_bytes());
    }

    pub(crate) fn i32(&mut self, value: i32) {
        self.number(value.to_le_bytes());
    }

    pub(crate) fn f64(&mut self, value: f64) {
        self.number(value.to_le_bytes());
    }

    pub(crate) fn f64s(&mut self, values: &[f64]) {
        values.iter().for_each(|value| self.f64(*value));
    }

    /// Its length with the zero that ends it, then both.
    pub(crate) fn text(&mut self, text: &str) {
        self.u32(text.len() as u32 + 1);
        self.0.extend(text.as_bytes());
        self.0.push(0);
    }

    /// `builtin_interfaces/Time`; what lies beyond its 32 bits of seconds ends there.
    pub(crate) fn stamp(&mut self, t: Stamp) {
        let (seconds, nanos) = (t.ns().div_euclid(1_000_000_000), t.ns().rem_euclid(1_000_000_000));
        self.i32(seconds.clamp(i32::MIN.into(), i32::MAX.into()) as i32);
        self.u32(nanos as u32);
    }

    /// `std_msgs/Header`.
    pub(crate) fn header(&mut self, t: Stamp, frame: &str) {
        self.stamp(t);
        self.text(frame);
    }

    /// x, y, z.
    pub(crate) fn vector(&mut self, v: &Vector3<f64>) {
        self.f64s(v.as_slice());
    }

    /// x, y, z, w.
    pub(crate) fn rotation(&mut self, q: &UnitQuaternion<f64>) {
        self.f64s(q.coords.as_slice());
    }

    /// `geometry_msgs/Pose` and `geometry_msgs/Transform` alike.
    pub(crate) fn pose(&mut self, pose: &Isometry3<f64>) {
        self.vector(&pose.translation.vector);
        self.rotation(&pose.rotation);
    }

    pub(crate) fn done(self) -> Vec<u8> {
        self.0
    }

    fn number<const N: usize>(&mut self, bytes: [u8; N]) {
        self.0.resize(self.0.len().next_multiple_of(N), 0);
        self.0.extend(bytes);
    }
}
