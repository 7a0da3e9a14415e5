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

/// A topic of motors.
struct Motors {
    topic: &'static str,
    /// Its outputs, and of outputs with fields of their own their type and the field that counts, in turns a minute.
    outputs: (&'static str, Option<(&'static str, &'static str)>),
    most: usize,
    /// How many they are, where the topic says that.
    count: Option<&'static str>,
}

/// From the best on: turns as measured, outputs as wanted, as given. What is not used is NaN, and of turns 0.
const MOTORS: [Motors; 3] = [
    Motors {
        topic: "esc_status",
        outputs: ("esc", Some(("esc_report", "esc_rpm"))),
        most: 8,
        count: Some("esc_count"),
    },
    Motors { topic: "actuator_motors", outputs: ("control", None), most: 12, count: None },
    Motors { topic: "actuator_outputs", outputs: ("output", None), most: 16, count: Some("noutputs") },
];

/// Where the outputs of motors lie in a topic's data.
#[derive(Debug)]
struct MotorsPlace {
    order: u8,
    stamp: usize,
    /// The first, and how many bytes lie from one to the next.
    outputs: (usize, usize),
    /// Whole numbers: turns.
    are_turns: bool,
    most: usize,
    /// And how many bytes that has.
    count: Option<(usize, usize)>,
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
    let order = MOTORS.iter().position(|motors| motors.topic == topic)?;
    let Motors { outputs: (name, of), most, count, .. } = MOTORS[order];
    let find = |name: &str| field(formats.get(topic)?, name, formats);
    let (mut first, apart) = find(name)?;
    if let Some((kind, name)) = of {
        first = first.checked_add(field(formats.get(kind)?, name, formats)?.0)?;
    }
    let place = MotorsPlace {
        order: order as u8,
        stamp: find("timestamp")?.0,
        outputs: (first, apart),
        are_turns: of.is_some(),
        most,
        count: count.and_then(find),
    };
    Some((number, place))
}

/// Takes them; a message that is too short has none.
fn outputs(data: &[u8], place: &MotorsPlace, records: &mut Records) -> Option<()> {
    let at = |at: usize| data.get(at..).map(Bytes::new);
    let t = i64::try_from(at(place.stamp)?.u64()?).ok()?.checked_mul(1000)?;
    let count = match place.count {
        Some((count, 1)) => usize::from(at(count)?.u8()?).min(place.most),
        Some((count, _)) => (at(count)?.u32()? as usize).min(place.most),
        None => place.most,
    };
    let (first, apart) = place.outputs;
    let output = |i: usize| {
        let bytes = at(first.checked_add(i.checked_mul(apart)?)?)?.array()?;
        Some(match (place.are_turns, i32::from_le_bytes(bytes)) {
            (true, 0) => f64::NAN,
            (true, turns) => f64::from(turns),
            (false, _) => f64::from(f32::from_le_bytes(bytes)),
        })
    };
    records.motors(place.order, Stamp::from_ns(t), (0..count).map_while(output));
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
    use crate::{Kind, LogOptions};
    use std::path::Path;

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

    fn message(kind: u8, parts: &[&[u8]]) -> Vec<u8> {
        let payload = parts.concat();
        [&(payload.len() as u16).to_le_bytes()[..], &[kind], &payload].concat()
    }

    /// A log of an IMU and what is said of motors by topic: name, number, data by message.
    fn motors_of(topics: &[(&str, u8, Vec<Vec<u8>>)]) -> Vec<(Stamp, f64)> {
        let mut file = [MAGIC, &[1], &0_u64.to_le_bytes()].concat();
        for format in [
            "sensor_combined:uint64_t timestamp;float[3] gyro_rad;float[3] accelerometer_m_s2;",
            "esc_report:uint64_t timestamp;uint32_t esc_errorcount;int32_t esc_rpm;float esc_voltage;",
            "esc_status:uint64_t timestamp;uint16_t counter;uint8_t esc_count;uint8_t[5] _padding0;esc_report[8] esc;",
            "actuator_motors:uint64_t timestamp;uint64_t timestamp_sample;float[12] control;",
            "actuator_outputs:uint64_t timestamp;uint32_t noutputs;float[16] output;",
        ] {
            file.extend(message(b'F', &[format.as_bytes()]));
        }
        file.extend(message(b'A', &[&[0, 0, 0], b"sensor_combined"]));
        for i in 0..100_u64 {
            let values = [0.1_f32, 0.2, 0.3, 0.0, 0.1, 9.8].map(f32::to_le_bytes).concat();
            file.extend(message(b'D', &[&[0, 0], &(4000 * i).to_le_bytes(), &values]));
        }
        for (name, number, data) in topics {
            file.extend(message(b'A', &[&[0, *number, 0], name.as_bytes()]));
            data.iter().for_each(|data| file.extend(message(b'D', &[&[*number, 0], data])));
        }
        let path = Path::new("flight.ulg");
        let mut records = Records::default();
        assert_eq!(read(&file[..], &mut records).unwrap(), None);
        records.log(path, Kind::Ulog, None, &LogOptions::default()).unwrap().motors
    }

    #[test]
    fn motors_are_those_of_the_best_topic_that_says_something_of_them() {
        let at = |i: u64| (100_000 * i).to_le_bytes();
        let outputs = |i: u64| {
            let values = [1100.0_f32, 1200.0, 1300.0, 1400.0 + 4.0 * i as f32].map(f32::to_le_bytes).concat();
            [&at(i)[..], &4_u32.to_le_bytes(), &values, &[0xff; 48]].concat()
        };
        let wanted = |i: u64| {
            let values = [0.25_f32, 0.75, f32::NAN].map(f32::to_le_bytes).concat();
            [&at(i)[..], &at(i), &values, &f32::NAN.to_le_bytes().repeat(9)].concat()
        };
        let turns = |i: u64, rpm: i32| {
            let one = |rpm: i32| [&at(i)[..], &[0; 4], &rpm.to_le_bytes(), &[0; 4]].concat();
            let rest = one(7).repeat(6);
            [&at(i)[..], &[1, 0, 2, 0, 0, 0, 0, 0], &one(rpm), &one(2 * rpm), &rest].concat()
        };
        let all = |of: &dyn Fn(u64) -> Vec<u8>| (0..3).map(of).collect::<Vec<_>>();
        let said = |numbers: [f64; 3]| {
            let stamp = |i: usize| Stamp::from_ns(100_000_000 * i as i64);
            numbers.into_iter().enumerate().map(|(i, number)| (stamp(i), number)).collect::<Vec<_>>()
        };
        let given = ("actuator_outputs", 1, all(&outputs));
        assert_eq!(motors_of(std::slice::from_ref(&given)), said([1250.0, 1251.0, 1252.0]));
        let asked = ("actuator_motors", 2, all(&wanted));
        assert_eq!(motors_of(&[given.clone(), asked.clone()]), said([0.5; 3]));
        assert_eq!(motors_of(&[asked.clone(), given.clone()]), said([0.5; 3]));
        let measured = ("esc_status", 3, all(&|i| turns(i, 4000)));
        assert_eq!(motors_of(&[given, asked.clone(), measured]), said([6000.0; 3]));
        // Controllers that measure nothing.
        assert_eq!(motors_of(&[asked, ("esc_status", 3, all(&|i| turns(i, 0)))]), said([0.5; 3]));
    }
}
