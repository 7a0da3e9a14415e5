//! PX4's ULog from front to back: its formats, and of its data the topics of IMUs.
//!
//! `sensor_combined` has rates, `vehicle_imu` angles and velocities gained with the times over which they were, `sensor_gyro` and
//! `sensor_accel` one sensor each. A message is its size, its type and so many bytes; a format names a topic's fields, a subscription gives
//! topic and instance a number, data begin with that number. Axes stay as PX4 has them: forward, right, down. Source: docs.px4.io, ULog file
//! format. Not here: data appended behind a log's end after a crash.

use crate::bytes::Bytes;
use crate::records::{Holds, Records};
use crate::rosbag1::CountedReader;
use dpn_core::{ImuSample, Stamp};
use std::collections::HashMap;
use std::io::{self, Read};

/// A log begins with this and a version.
pub(crate) const MAGIC: &[u8] = b"ULog\x01\x12\x35";
/// Types may hold types, as deep as this.
const DEEPEST: usize = 8;

/// A topic that is an IMU's: its name, and the names of stamp and axes.
struct Known {
    topic: &'static str,
    stamp: &'static str,
    /// Gyroscope, accelerometer: three numbers one behind the other from this field on, and the time over which they were gained.
    axes: [Option<(&'static str, Option<&'static str>)>; 2],
}

const KNOWN: [Known; 4] = [
    Known {
        topic: "sensor_combined",
        stamp: "timestamp",
        axes: [Some(("gyro_rad", None)), Some(("accelerometer_m_s2", None))],
    },
    Known {
        topic: "vehicle_imu",
        stamp: "timestamp_sample",
        axes: [
            Some(("delta_angle", Some("delta_angle_dt"))),
            Some(("delta_velocity", Some("delta_velocity_dt"))),
        ],
    },
    Known { topic: "sensor_gyro", stamp: "timestamp", axes: [Some(("x", None)), None] },
    Known { topic: "sensor_accel", stamp: "timestamp", axes: [None, Some(("x", None))] },
];

/// Topics of motors from the best on: outputs and how many they are, where the topic says that. What is not used is NaN.
const MOTORS: [(&str, &str, usize, Option<&str>); 2] =
    [("actuator_motors", "control", 12, None), ("actuator_outputs", "output", 16, Some("noutputs"))];

/// Where the outputs of motors lie in a topic's data.
#[derive(Debug)]
struct MotorsPlace {
    order: u8,
    stamp: usize,
    outputs: usize,
    most: usize,
    count: Option<usize>,
}

/// Where a sensor's numbers lie in a topic's data and, of increments, where their interval lies and how many bytes it has.
type Triple = (usize, Option<(usize, usize)>);

/// Where a subscribed topic's numbers lie in its data.
#[derive(Debug)]
struct Place {
    source: usize,
    stamp: usize,
    /// Of each sensor.
    axes: [Option<Triple>; 2],
}

/// Reads a whole log; returns what was wrong where it ended early.
///
/// # Errors
/// The operating system's; a damaged log is none.
pub(crate) fn read(source: impl Read, records: &mut Records) -> io::Result<Option<String>> {
    let mut source = CountedReader { inner: source, at: 0 };
    let head = source.up_to(16)?;
    if head.len() < 16 || !head.starts_with(MAGIC) {
        return Ok(Some("ends within its head".to_owned()));
    }
    let mut formats: HashMap<String, String> = HashMap::new();
    let mut places: HashMap<u16, Place> = HashMap::new();
    let mut motors: HashMap<u16, MotorsPlace> = HashMap::new();
    loop {
        let begin = source.at;
        let head = source.up_to(3)?;
        let [low, high, kind] = head[..] else {
            return Ok((!head.is_empty()).then(|| format!("cut off at byte {begin}")));
        };
        let size = u64::from(u16::from_le_bytes([low, high]));
        if !b"ABCDFILMOPQRS".contains(&kind) {
            return Ok(Some(format!("no message at byte {begin}: its type would be {kind:#04x}")));
        }
        let Some(message) = source.exactly(size)? else {
            return Ok(Some(format!("cut off in the message at byte {begin}")));
        };
        match kind {
            b'F' => {
                let text = String::from_utf8_lossy(&message);
                if let Some((name, fields)) = text.split_once(':') {
                    formats.insert(name.to_owned(), fields.to_owned());
                }
            }
            b'A' => {
                if let Some((number, place)) = subscription(&message, &formats, records) {
                    places.insert(number, place);
                } else if let Some((number, place)) = motors_place(&message, &formats) {
                    motors.insert(number, place);
                }
            }
            b'D' => {
                let mut bytes = Bytes::new(&message);
                let number = bytes.u16();
                if let Some(place) = number.and_then(|number| motors.get(&number)) {
                    outputs(bytes.rest(), place, records);
                } else if let Some(place) = number.and_then(|number| places.get(&number)) {
                    match sample(bytes.rest(), place) {
                        Some(sample) => records.push(place.source, sample),
                        None => {
                            return Ok(Some(format!(
                                "the message at byte {begin} is shorter than its format"
                            )));
                        }
                    }
                }
            }
            _ => {}
        }
    }
}

fn subscription(
    message: &[u8],
    formats: &HashMap<String, String>,
    records: &mut Records,
) -> Option<(u16, Place)> {
    let mut bytes = Bytes::new(message);
    let (instance, number) = (bytes.u8()?, bytes.u16()?);
    let topic = std::str::from_utf8(bytes.rest()).ok()?;
    let order = KNOWN.iter().position(|known| known.topic == topic)?;
    let known = &KNOWN[order];
    let fields = formats.get(topic)?;
    let find = |name: &str| field(fields, name, formats);
    let (stamp, _) = find(known.stamp)?;
    let mut axes = [None; 2];
    for (place, axes) in axes.iter_mut().zip(known.axes) {
        if let Some((name, interval)) = axes {
            let interval = match interval {
                Some(name) => Some(find(name)?),
                None => None,
            };
            *place = Some((find(name)?.0, interval));
        }
    }
    let holds = match known.axes {
        [Some(_), None] => Holds::Gyro,
        [None, _] => Holds::Accel,
        _ => Holds::Both,
    };
    let source = records.source(topic, u32::from(instance), holds, order as u32)?;
    Some((number, Place { source, stamp, axes }))
}

/// The same of motors; the first instance's alone, which are those that fly.
fn motors_place(message: &[u8], formats: &HashMap<String, String>) -> Option<(u16, MotorsPlace)> {
    let mut bytes = Bytes::new(message);
    let (instance, number) = (bytes.u8()?, bytes.u16()?);
    let topic = std::str::from_utf8(bytes.rest()).ok().filter(|_| instance == 0)?;
    let order = MOTORS.iter().position(|(name, ..)| *name == topic)?;
    let (_, name, most, count) = MOTORS[order];
    let find = |name: &str| Some(field(formats.get(topic)?, name, formats)?.0);
    let count = count.and_then(find);
    Some((
        number,
        MotorsPlace { order: order as u8, stamp: find("timestamp")?, outputs: find(name)?, most, count },
    ))
}

/// Takes them; a message that is too short has none.
fn outputs(data: &[u8], place: &MotorsPlace, records: &mut Records) -> Option<()> {
    let at = |at: usize| data.get(at..).map(Bytes::new);
    let t = i64::try_from(at(place.stamp)?.u64()?).ok()?.checked_mul(1000)?;
    let count = match place.count {
        Some(count) => (at(count)?.u32()? as usize).min(place.most),
        None => place.most,
    };
    let mut numbers = at(place.outputs)?;
    let outputs = (0..count).map_while(|_| numbers.array().map(|bytes| f64::from(f32::from_le_bytes(bytes))));
    records.motors(place.order, Stamp::from_ns(t), outputs);
    Some(())
}

/// Where a field begins and how many bytes one of its elements has.
fn field(fields: &str, wanted: &str, formats: &HashMap<String, String>) -> Option<(usize, usize)> {
    let mut at = 0usize;
    for (kind, name) in parts(fields) {
        let (element, count) = size(kind, formats, 0)?;
        if name == wanted {
            return Some((at, element));
        }
        at = at.checked_add(element.checked_mul(count)?)?;
    }
    None
}

/// Types and names of a format.
fn parts(fields: &str) -> impl Iterator<Item = (&str, &str)> {
    fields.split(';').filter_map(|field| field.trim().split_once(' '))
}

/// Bytes of one element of a type, and how many it has.
fn size(kind: &str, formats: &HashMap<String, String>, depth: usize) -> Option<(usize, usize)> {
    let (kind, count) = match kind.split_once('[') {
        Some((kind, count)) => (kind, count.trim_end_matches(']').parse().ok()?),
        None => (kind, 1),
    };
    let element = match kind {
        "int8_t" | "uint8_t" | "bool" | "char" => 1,
        "int16_t" | "uint16_t" => 2,
        "int32_t" | "uint32_t" | "float" => 4,
        "int64_t" | "uint64_t" | "double" => 8,
        // A damaged format may hold itself, twice a time.
        _ if depth >= DEEPEST => return None,
        other => {
            let mut sum = 0usize;
            for (kind, _) in parts(formats.get(other)?).take(64) {
                let (element, count) = size(kind, formats, depth + DEEPEST / 4)?;
                sum = sum.checked_add(element.checked_mul(count)?)?;
            }
            sum
        }
    };
    Some((element, count))
}

fn sample(data: &[u8], place: &Place) -> Option<ImuSample> {
    let stamp_us = Bytes::new(data.get(place.stamp..)?).u64()?;
    let t = Stamp::from_ns(i64::try_from(stamp_us).ok()?.checked_mul(1000)?);
    let triple = |axes: Option<Triple>| -> Option<[f64; 3]> {
        let Some((at, interval)) = axes else { return Some([0.0; 3]) };
        let mut bytes = Bytes::new(data.get(at..)?);
        let mut values = [0.0; 3];
        for value in &mut values {
            *value = f64::from(f32::from_le_bytes(bytes.array()?));
        }
        if let Some((at, size)) = interval {
            let mut bytes = Bytes::new(data.get(at..)?);
            let us = if size == 2 { u32::from(bytes.u16()?) } else { bytes.u32()? };
            values = values.map(|v| v / (f64::from(us) * 1e-6));
        }
        Some(values)
    };
    let [gyro, accel] = place.axes;
    Some(ImuSample { t, gyro: triple(gyro)?, accel: triple(accel)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_format_that_holds_itself_has_no_size_and_nested_ones_add_up() {
        let formats: HashMap<String, String> = [
            ("a", "a x;a y;"),
            ("esc", "float[2] v;uint8_t n;"),
            ("status", "uint64_t timestamp;esc[3] all;float[3] gyro;uint16_t dt;"),
        ]
        .map(|(name, fields)| (name.to_owned(), fields.to_owned()))
        .into();
        assert_eq!(size("a", &formats, 0), None);
        assert_eq!(field(&formats["status"], "gyro", &formats), Some((8 + 27, 4)));
        assert_eq!(field(&formats["status"], "dt", &formats), Some((8 + 27 + 12, 2)));
        assert_eq!(field(&formats["status"], "none", &formats), None);
    }
}
