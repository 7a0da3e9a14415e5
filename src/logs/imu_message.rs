//! `sensor_msgs/Imu` from its bytes, in ROS 1's encoding and in CDR.
//!
//! Header (ROS 1: sequence number; stamp; frame), orientation and its covariance, angular velocity and its, linear acceleration and its: 37
//! doubles after the header. Source: sensor_msgs/Imu.msg; OMG DDS-XTypes 1.3, 7.4 for CDR's alignment.

use crate::bytes::Bytes;
use dpn_core::{ImuSample, Stamp};

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

/// Reads a message; `None` when it is too short or in no known encoding.
pub(crate) fn decode(data: &[u8], encoding: Encoding) -> Option<ImuMessage> {
    match encoding {
        Encoding::Ros1 => ros1(data),
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

fn cdr(data: &[u8]) -> Option<ImuMessage> {
    let [_, kind, _, _] = *data.first_chunk::<4>()?;
    // Plain CDR, version 1 or 2: doubles at multiples of 8 or of 4, counted from behind these four bytes; odd is little-endian.
    let (align, little) = match kind {
        0 | 1 => (8, kind == 1),
        6 | 7 => (4, kind == 7),
        _ => return None,
    };
    let body = &data[4..];
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
