//! JSON as phones' loggers write it: objects one after the other, or in arrays, of a sensor each or of both; and the YAML of ROS's `echo`, a message an object.
//!
//! Every object with a number or more is a row: its numbers are columns, called as the keys down to them, `gyro.x`, `values[0]`. Rows are of one table
//! where they are of one sensor: by a key that says it (Android's numbers too), else by the array they stand in. Tables are text, for the readers of text.

use dpn_io::{printable, walk_yaml};
use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::fmt;

/// Keys that say of which sensor an object is.
const SENSOR: [&str; 6] = ["sensor", "sensorType", "sensor_type", "sensorName", "type", "name"];
/// Android's numbers of sensors.
const ANDROID: [(u64, &str); 8] = [
    (1, "accelerometer"),
    (2, "magnetic field"),
    (4, "gyroscope"),
    (9, "gravity"),
    (10, "linear acceleration"),
    (14, "magnetic field uncalibrated"),
    (16, "gyroscope uncalibrated"),
    (35, "accelerometer uncalibrated"),
];
/// Sensors that are told apart, columns of one, letters of a text.
const MOST: usize = 64;
/// Numbers of an array that are columns.
const AXES: usize = 9;

/// Rows of one sensor.
#[derive(Debug, Default)]
pub(crate) struct Table {
    /// Whose they are.
    pub(crate) sensor: String,
    /// Names of the columns.
    pub(crate) names: Vec<String>,
    /// A header and the rows, between commas.
    pub(crate) text: String,
}

/// Whether a file begins as JSON does.
pub(crate) fn is(head: &[u8]) -> bool {
    let head = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head).trim_ascii_start();
    match head {
        [b'{' | b'[', rest @ ..] => {
            let next = rest.trim_ascii_start().first();
            next.is_none_or(|next| b"{[\"".contains(next))
        }
        _ => false,
    }
}

/// Whether a file begins as a message with a header does that `rostopic echo` or `ros2 topic echo` prints.
pub(crate) fn is_echo(head: &[u8]) -> bool {
    let head = head.strip_prefix(b"---\n").unwrap_or(head);
    let line = head.split(|byte| *byte == b'\n').next().filter(|line| line.len() < head.len());
    line.is_some_and(|line| line.trim_ascii_end() == b"header:")
}

/// The tables of messages that were printed, and what was wrong where they ended early. Behind each stands `---`.
pub(crate) fn echoed(bytes: &[u8]) -> (Vec<Table>, Option<String>) {
    let mut tables = Vec::new();
    let text = String::from_utf8_lossy(bytes);
    let (whole, rest) = text.rsplit_once("\n---").unwrap_or(("", &text));
    for message in whole.split("\n---") {
        // Above it ROS 2 says how many were lost.
        let Some(at) = message.find("header:") else { continue };
        let walk = Walk { within: "", tables: &mut tables };
        match walk_yaml(&message[at..], walk) {
            Ok(Leaf::Keys(keys)) => record(&keys, "", &mut tables),
            Ok(_) => {}
            Err(error) => return (tables, Some(format!("a message of it is no YAML: {error}"))),
        }
    }
    (tables, (!rest.trim().is_empty()).then(|| "its last message is cut off".to_owned()))
}

/// The tables of a file, and what was wrong where it ended early. Objects are made rows as they come: no more than one is held.
pub(crate) fn tables(bytes: &[u8]) -> (Vec<Table>, Option<String>) {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut tables = Vec::new();
    // Where a value ends is looked for first: asking a parser whether anything is left counts all lines before it.
    let mut values = serde_json::Deserializer::from_slice(bytes).into_iter::<IgnoredAny>();
    loop {
        let start = values.byte_offset();
        let (end, damage) = match values.next() {
            None => return (tables, None),
            Some(Ok(_)) => (values.byte_offset(), None),
            Some(Err(error)) if error.is_eof() => (bytes.len(), Some("cut off".to_owned())),
            Some(Err(error)) => (bytes.len(), Some(printable(&error.to_string()))),
        };
        let mut value = serde_json::Deserializer::from_slice(&bytes[start..end]);
        if let Ok(Leaf::Keys(keys)) = (Walk { within: "", tables: &mut tables }).deserialize(&mut value) {
            record(&keys, "", &mut tables);
        }
        if let Some(damage) = damage {
            return (tables, Some(format!("its JSON is {damage}")));
        }
    }
}

/// A value as far as a row has use for it.
enum Leaf {
    /// A number, or a short text.
    Text(String),
    /// A few numbers.
    Numbers(Vec<String>),
    /// An object.
    Keys(Vec<(String, Leaf)>),
    Other,
}

/// Goes through a value; objects in arrays are rows of their own, of the sensor that `within` names where they do not.
struct Walk<'a> {
    within: &'a str,
    tables: &'a mut Vec<Table>,
}

impl<'de> DeserializeSeed<'de> for Walk<'_> {
    type Value = Leaf;

    fn deserialize<D: Deserializer<'de>>(self, input: D) -> Result<Leaf, D::Error> {
        input.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Walk<'_> {
    type Value = Leaf;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_bool<E>(self, _: bool) -> Result<Leaf, E> {
        Ok(Leaf::Other)
    }

    fn visit_unit<E>(self) -> Result<Leaf, E> {
        Ok(Leaf::Other)
    }

    fn visit_u64<E>(self, v: u64) -> Result<Leaf, E> {
        Ok(Leaf::Text(v.to_string()))
    }

    fn visit_i64<E>(self, v: i64) -> Result<Leaf, E> {
        Ok(Leaf::Text(v.to_string()))
    }

    fn visit_f64<E>(self, v: f64) -> Result<Leaf, E> {
        Ok(Leaf::Text(v.to_string()))
    }

    fn visit_str<E>(self, v: &str) -> Result<Leaf, E> {
        Ok(if v.len() <= MOST { Leaf::Text(v.trim().to_owned()) } else { Leaf::Other })
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Leaf, A::Error> {
        let Self { within, tables } = self;
        let (mut numbers, mut plain) = (Vec::new(), true);
        while let Some(leaf) = list.next_element_seed(Walk { within, tables: &mut *tables })? {
            match leaf {
                Leaf::Text(text) if plain && numbers.len() < AXES && is_number(&text) => numbers.push(text),
                Leaf::Keys(keys) => {
                    record(&keys, within, tables);
                    plain = false;
                }
                _ => plain = false,
            }
        }
        Ok(if plain && !numbers.is_empty() { Leaf::Numbers(numbers) } else { Leaf::Other })
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Leaf, A::Error> {
        let mut keys = Vec::new();
        while let Some(key) = map.next_key::<String>()? {
            let leaf = map.next_value_seed(Walk { within: &key, tables: &mut *self.tables })?;
            if keys.len() < MOST && !matches!(leaf, Leaf::Other) {
                keys.push((key, leaf));
            }
        }
        Ok(Leaf::Keys(keys))
    }
}

/// Whether a field is a number.
pub(crate) fn is_number(text: &str) -> bool {
    text.parse::<f64>().is_ok()
}

/// A row of an object's numbers, where it has a few.
fn record(keys: &[(String, Leaf)], within: &str, tables: &mut Vec<Table>) {
    let mut row = Vec::new();
    flatten(keys, "", &mut row);
    if row.len() >= 3 {
        take(&row, sensor(keys, within), tables);
    }
}

fn sensor(keys: &[(String, Leaf)], within: &str) -> String {
    let said = SENSOR.iter().find_map(|name| match keys.iter().find(|(key, _)| key == name)? {
        (_, Leaf::Text(text)) => match text.parse::<u64>() {
            Ok(number) => ANDROID.iter().find(|(one, _)| *one == number).map(|(_, name)| *name),
            Err(_) => Some(text.as_str()),
        },
        _ => None,
    });
    said.unwrap_or(within).to_owned()
}

/// The numbers below an object, with the keys down to them. Sensor Logger writes numbers as text.
fn flatten(keys: &[(String, Leaf)], above: &str, row: &mut Vec<(String, String)>) {
    for (key, leaf) in keys.iter().take(MOST) {
        let name = format!("{above}{}", key.replace([',', '\n', '\r', '"', '#'], " "));
        match leaf {
            Leaf::Text(text) if is_number(text) => row.push((name, text.clone())),
            Leaf::Numbers(list) => {
                row.extend(list.iter().enumerate().map(|(i, v)| (format!("{name}[{i}]"), v.clone())));
            }
            Leaf::Keys(inner) if row.len() < MOST => flatten(inner, &format!("{name}."), row),
            _ => {}
        }
    }
}

fn take(row: &[(String, String)], sensor: String, tables: &mut Vec<Table>) {
    let at = tables.iter().position(|table| table.sensor == sensor).or_else(|| {
        (tables.len() < MOST).then(|| {
            let names: Vec<String> = row.iter().map(|(name, _)| name.clone()).collect();
            let text = names.join(",") + "\n";
            tables.push(Table { sensor, names, text });
            tables.len() - 1
        })
    });
    let Some(table) = at.map(|at| &mut tables[at]) else { return };
    for (i, name) in table.names.iter().enumerate() {
        let here = row.get(i).filter(|(one, _)| one == name);
        let value = here.or_else(|| row.iter().find(|(one, _)| one == name)).map_or("", |(_, value)| value);
        table.text.push_str(if i == 0 { "" } else { "," });
        table.text.push_str(value);
    }
    table.text.push('\n');
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Vec<(String, String)> {
        let (tables, damage) = tables(text.as_bytes());
        assert_eq!(damage, None);
        tables.into_iter().map(|table| (table.sensor, table.text)).collect()
    }

    #[test]
    fn objects_of_every_app_are_rows_of_their_sensor() {
        let pretty = "{\n \"sensorType\": 4, \"timestamp\": 312434759331803, \"values\": [0.5, -1e-3, 2]\n}\n{\"sensorType\":1,\"timestamp\":7,\"values\":[1,2,3]}";
        assert_eq!(
            of(pretty),
            [
                (
                    "gyroscope".to_owned(),
                    "sensorType,timestamp,values[0],values[1],values[2]\n4,312434759331803,0.5,-0.001,2\n"
                        .to_owned()
                ),
                (
                    "accelerometer".to_owned(),
                    "sensorType,timestamp,values[0],values[1],values[2]\n1,7,1,2,3\n".to_owned()
                ),
            ]
        );
        let named = r#"{"rotations": [{"x": 0.5, "y": 1, "z": 2, "time_usec": 9}], "accelerations": [{"x": "3", "y": 4, "z": 5, "time_usec": 9}]}"#;
        let sensors: Vec<String> = of(named).into_iter().map(|(sensor, _)| sensor).collect();
        assert_eq!(sensors, ["rotations", "accelerations"]);
        let wide = r#"[{"t": 1, "gyro": {"x": 1, "y": 2, "z": 3}, "accel": [4, 5, 6]}]"#;
        assert_eq!(of(wide)[0].1, "t,gyro.x,gyro.y,gyro.z,accel[0],accel[1],accel[2]\n1,1,2,3,4,5,6\n");
    }

    #[test]
    fn messages_as_ros_prints_them_are_rows() {
        let message = |secs: &str, nsecs: &str| {
            format!(
                "header: \n  stamp: \n    {secs}: 5\n    {nsecs}: 70\n  frame_id: \"imu\"\nangular_velocity: \n  x: 1e-05\n  y: -2\n  z: .5\n\
                 angular_velocity_covariance: [-1.0, 0.0]\nlinear_acceleration: \n  x: nan\n  y: 0.0\n  z: 9.8\n---\n"
            )
        };
        let (ros1, ros2) = (message("secs", "nsecs"), message("sec", "nanosec"));
        assert!(is_echo(&ros1.as_bytes()[..18]) && !is_echo(b"header: t,gx,gy,gz") && !is_echo(b"header:"));
        let lost = "A message was lost!!!\n\ttotal count change:1\n\ttotal count: 1---\n";
        let (tables, damage) = echoed(format!("{ros2}{lost}{ros2}{}", &ros2[..90]).as_bytes());
        let names = "header.stamp.sec,header.stamp.nanosec,angular_velocity.x,angular_velocity.y,angular_velocity.z,\
                     angular_velocity_covariance[0],angular_velocity_covariance[1],linear_acceleration.x,linear_acceleration.y,linear_acceleration.z\n";
        let row = "5,70,0.00001,-2,0.5,-1,0,nan,0,9.8\n";
        assert_eq!((&tables[0].text, damage.is_some()), (&format!("{names}{row}{row}"), true));
        let ros1 = format!("---\n{ros1}");
        assert!(is_echo(&ros1.as_bytes()[..18]));
        let (tables, damage) = echoed(ros1.as_bytes());
        assert!(dpn_io::names_all(&tables[0].names) && damage.is_none(), "{damage:?}");
    }

    #[test]
    fn what_is_cut_off_gives_all_before_it_and_nothing_panics() {
        let line = r#"{"sensor":"gyro","t":1,"x":1,"y":2,"z":3}"#;
        let (tables, damage) = tables(format!("{line}\n{line}\n{}", &line[..20]).as_bytes());
        assert_eq!((tables[0].text.lines().count(), damage.unwrap().as_str()), (3, "its JSON is cut off"));
        for text in ["", "[", "{}", "[[[[1]]]]", "{\"a\":{\"b\":[{}]}}", &"[".repeat(5000)] {
            let (tables, _) = super::tables(text.as_bytes());
            assert!(tables.is_empty());
        }
        assert!(is(b"{\"a") && is(b" [\n{") && !is(b"[rad/s]") && !is(b"t,gx"));
    }
}
