//! `sensor_msgs/Imu` from its bytes.
//!
//! Header, orientation and its covariance, angular velocity and its, linear acceleration and its: 37 doubles after the header. Source:
//! sensor_msgs/Imu.msg.

use crate::fields::{Encoding, Fields, Undecodable};
use dpn_core::{ImuSample, Stamp};

/// Whether messages of this type are an IMU's, in ROS 1 or ROS 2.
pub(crate) fn is_imu(kind: &str) -> bool {
    matches!(kind, "sensor_msgs/Imu" | "sensor_msgs/msg/Imu")
}

/// One message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ImuMessage {
    /// With the header's stamp.
    pub(crate) sample: ImuSample,
    /// Whether the header has a stamp.
    pub(crate) stamped: bool,
    /// Variances of a sample, gyroscope's and accelerometer's x, y, z; zeros and what begins with -1 are not known.
    pub(crate) variances: [Option<[f64; 3]>; 2],
}

/// Reads a message.
///
/// # Errors
/// One that is too short or in no known representation.
pub(crate) fn decode(data: &[u8], encoding: Encoding) -> Result<ImuMessage, Undecodable> {
    let mut fields = Fields::new(data, encoding)?;
    message(&mut fields).ok_or(Undecodable::Short)
}

/// Writes variances into a message's covariances of angular velocity and linear acceleration, their diagonals; everything else stays as it is.
///
/// # Errors
/// As [`decode`]; the message is as it was.
#[cfg(feature = "write")]
pub(crate) fn fill_covariances(
    data: &mut [u8],
    encoding: Encoding,
    gyro_var: [f64; 3],
    accel_var: [f64; 3],
) -> Result<(), Undecodable> {
    let mut fields = Fields::new(data, encoding)?;
    let places: Option<Vec<_>> =
        fields.header().and_then(|_| (0..37).map(|_| fields.place_of_f64()).collect());
    let places = places.ok_or(Undecodable::Short)?;
    for (first, variances) in [(16, gyro_var), (28, accel_var)] {
        for (k, (place, little)) in places[first..first + 9].iter().enumerate() {
            let value = if k % 4 == 0 { variances[k / 4] } else { 0.0 };
            let bytes = if *little { value.to_le_bytes() } else { value.to_be_bytes() };
            data[place.clone()].copy_from_slice(&bytes);
        }
    }
    Ok(())
}

fn message(fields: &mut Fields<'_>) -> Option<ImuMessage> {
    let header = fields.header()?;
    let mut values = [0.0; 37];
    for value in &mut values {
        *value = fields.f64()?;
    }
    let variances = [16, 28].map(|at| {
        let diagonal = [values[at], values[at + 4], values[at + 8]];
        diagonal.iter().all(|v| v.is_finite() && *v > 0.0).then_some(diagonal)
    });
    Some(ImuMessage {
        variances,
        sample: ImuSample {
            t: Stamp::from_ns(header.t_ns),
            gyro: [values[13], values[14], values[15]],
            accel: [values[25], values[26], values[27]],
        },
        stamped: header.t_ns != 0,
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

    #[cfg(feature = "write")]
    #[test]
    fn variances_go_to_the_diagonals_and_nowhere_else() {
        for frame in [&b"imu\0"[..], b"imu_link\0"] {
            for (id, align, little) in [(0, 8, false), (1, 8, true), (6, 4, false), (7, 4, true)] {
                let before = bytes(id, align, little, frame);
                let mut data = before.clone();
                fill_covariances(&mut data, Encoding::Cdr, [1.0, 2.0, 3.0], [4.0, 5.0, 6.0]).unwrap();
                let [filled, plain] = [&data, &before].map(|data| decode(data, Encoding::Cdr).unwrap());
                assert_eq!(filled.sample, plain.sample);
                assert_eq!(filled.variances, [Some([1.0, 2.0, 3.0]), Some([4.0, 5.0, 6.0])]);
                let mut fields = Fields::new(&data, Encoding::Cdr).unwrap();
                fields.header().unwrap();
                let values: Vec<f64> = (0..37).map(|_| fields.f64().unwrap()).collect();
                assert_eq!(values[16..25], [1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0]);
                assert_eq!(values[28..37], [4.0, 0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 6.0]);
                assert_eq!(values[4], 4.5, "the orientation's stay");
                assert!(fill_covariances(&mut data[..300], Encoding::Cdr, [1.0; 3], [1.0; 3]).is_err());
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
        assert_eq!(said(&whole[..whole.len() - 1]), "end before their fields do");
        assert_eq!(said(&[0, 1]), "end before their fields do");
    }
}
