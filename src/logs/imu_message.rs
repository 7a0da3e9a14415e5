//! `sensor_msgs/Imu` from its bytes, in ROS 1's encoding and in CDR.
//!
//! Header (ROS 1: sequence number; stamp; frame), orientation and its covariance, angular velocity and its, linear acceleration and its: 37
//! doubles after the header. Source: sensor_msgs/Imu.msg; OMG DDS-XTypes 1.3, 7.4 for CDR's alignment.

use crate::bytes::Bytes;
use dpn_core::{ImuSample, Stamp};
use std::fmt;

/// One message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ImuMessage {
    /// With the header's stamp.
    pub(crate) sample: ImuSample,
    /// Whether the header has a stamp.
    pub(crate) stamped: bool,
}

/// How a message was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Encoding {
    Ros1,
    Cdr,
}

impl Encoding {
    /// As MCAP's channels and rosbag2's topics name it.
    ///
    /// # Errors
    /// A name that is not known, back.
    pub(crate) fn named(name: &str) -> Result<Self, String> {
        match name {
            "ros1" => Ok(Self::Ros1),
            "cdr" => Ok(Self::Cdr),
            other => Err(other.to_owned()),
        }
    }
}

/// Why a message is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Undecodable {
    /// Its bytes end before its fields.
    Short,
    /// It begins with another representation than plain CDR.
    Representation(u16),
}

impl fmt::Display for Undecodable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Short => f.write_str("are no sensor_msgs/Imu"),
            Self::Representation(id @ (8 | 9)) => {
                write!(f, "are in delimited CDR (XCDR2, {id:#06x}), which is not known")
            }
            Self::Representation(id @ (2 | 3 | 10 | 11)) => {
                write!(f, "are in CDR with parameter lists ({id:#06x}), which is not known")
            }
            Self::Representation(id) => write!(f, "begin with {id:#06x}, which is no CDR"),
        }
    }
}

/// Reads a message.
///
/// # Errors
/// One that is too short or in no known representation.
pub(crate) fn decode(data: &[u8], encoding: Encoding) -> Result<ImuMessage, Undecodable> {
    match encoding {
        Encoding::Ros1 => ros1(data).ok_or(Undecodable::Short),
        Encoding::Cdr => cdr(data),
    }
}

fn ros1(data: &[u8]) -> Option<ImuMessage> {
    let mut bytes = Bytes::new(data);
    let _sequence = bytes.u32()?;
    let (seconds, nanos) = (bytes.u32()?, bytes.u32()?);
    let _frame = bytes.counted()?;
    message(i64::from(seconds), nanos, |_| bytes.array().map(f64::from_le_bytes))
}

fn cdr(data: &[u8]) -> Result<ImuMessage, Undecodable> {
    let Some(([high, low, _, _], body)) = data.split_first_chunk::<4>() else {
        return Err(Undecodable::Short);
    };
    // Plain CDR, version 1 or 2: doubles at multiples of 8 or of 4, counted from behind these four bytes; odd is little-endian.
    let (align, little) = match u16::from_be_bytes([*high, *low]) {
        kind @ (0 | 1) => (8, kind == 1),
        kind @ (6 | 7) => (4, kind == 7),
        other => return Err(Undecodable::Representation(other)),
    };
    plain_cdr(body, align, little).ok_or(Undecodable::Short)
}

fn plain_cdr(body: &[u8], align: usize, little: bool) -> Option<ImuMessage> {
    let mut at = 0;
    let mut word = || {
        let bytes: [u8; 4] = body.get(at..at + 4)?.try_into().ok()?;
        at += 4;
        Some(if little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) })
    };
    let (seconds, nanos, frame) = (word()?, word()?, word()?);
    let start = 12usize.checked_add(frame as usize)?.checked_next_multiple_of(align)?;
    let numbers = body.get(start..)?;
    message(i64::from(seconds.cast_signed()), nanos, |i| {
        let bytes: [u8; 8] = numbers.get(8 * i..8 * i + 8)?.try_into().ok()?;
        Some(if little { f64::from_le_bytes(bytes) } else { f64::from_be_bytes(bytes) })
    })
}

/// Takes the 37 doubles in order.
fn message(seconds: i64, nanos: u32, mut number: impl FnMut(usize) -> Option<f64>) -> Option<ImuMessage> {
    let mut values = [0.0; 37];
    for (i, value) in values.iter_mut().enumerate() {
        *value = number(i)?;
    }
    let t = seconds.checked_mul(1_000_000_000)?.checked_add(i64::from(nanos))?;
    Some(ImuMessage {
        sample: ImuSample {
            t: Stamp::from_ns(t),
            gyro: [values[13], values[14], values[15]],
            accel: [values[25], values[26], values[27]],
        },
        stamped: t != 0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A message as its bytes behind the four of the representation: doubles at multiples of `align`.
    fn bytes(id: u16, align: usize, little: bool, frame: &[u8]) -> Vec<u8> {
        let mut body = Vec::new();
        let mut word = |v: u32| body.extend(if little { v.to_le_bytes() } else { v.to_be_bytes() });
        word(1_600_000_000);
        word(250_000_000);
        word(frame.len() as u32);
        body.extend(frame);
        body.resize(body.len().next_multiple_of(align), 0);
        for i in 0..37 {
            let v = f64::from(i) + 0.5;
            body.extend(if little { v.to_le_bytes() } else { v.to_be_bytes() });
        }
        [&id.to_be_bytes()[..], &[0, 0], &body].concat()
    }

    #[test]
    fn plain_cdr_of_both_versions_and_both_orders_of_bytes_is_read() {
        // Frames whose padding differs between alignments of 8 and of 4, the terminating zero counted.
        for frame in [&b"imu\0"[..], b"imu_link\0", b"\0", b"imu_link_left\0"] {
            for (id, align, little) in [(0, 8, false), (1, 8, true), (6, 4, false), (7, 4, true)] {
                let message = decode(&bytes(id, align, little, frame), Encoding::Cdr).unwrap();
                assert_eq!(message.sample.t, Stamp::from_ns(1_600_000_000_250_000_000), "{id} {frame:?}");
                assert_eq!(message.sample.gyro, [13.5, 14.5, 15.5], "{id} {frame:?}");
                assert_eq!(message.sample.accel, [25.5, 26.5, 27.5], "{id} {frame:?}");
                assert!(message.stamped);
            }
        }
    }

    #[test]
    fn other_representations_are_named_and_short_ones_are_no_imu() {
        let said = |data: &[u8]| decode(data, Encoding::Cdr).unwrap_err().to_string();
        assert_eq!(
            said(&bytes(9, 4, true, b"a\0")),
            "are in delimited CDR (XCDR2, 0x0009), which is not known"
        );
        assert_eq!(
            said(&bytes(3, 4, true, b"a\0")),
            "are in CDR with parameter lists (0x0003), which is not known"
        );
        assert_eq!(said(b"{\"orientation\": 1}"), "begin with 0x7b22, which is no CDR");
        let whole = bytes(1, 8, true, b"imu_link\0");
        // The last covariance ends the message.
        assert_eq!(said(&whole[..whole.len() - 1]), "are no sensor_msgs/Imu");
        assert_eq!(said(&[0, 1]), "are no sensor_msgs/Imu");
    }
}
