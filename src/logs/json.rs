//! JSON as phones' loggers write it: objects one after the other, or in arrays, of a sensor each or of both.
//!
//! Every object with a number or more is a row: its numbers are columns, called as the keys down to them, `gyro.x`, `values[0]`. Rows are of one table
//! where they are of one sensor: by a key that says it (Android's numbers too), else by the array they stand in. Tables are text, for the readers of text.

use dpn_io::printable;
use serde_json::{Map, Value};

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
/// Sensors that are told apart, columns of one, and objects within each other.
const MOST: usize = 64;

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

/// The tables of a file, and what was wrong where it ended early.
pub(crate) fn tables(bytes: &[u8]) -> (Vec<Table>, Option<String>) {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut tables = Vec::new();
    let mut values = serde_json::Deserializer::from_slice(bytes).into_iter::<Value>();
    loop {
        match values.next() {
            None => return (tables, None),
            Some(Ok(value)) => walk(&value, "", &mut tables),
            Some(Err(error)) => {
                let what = if error.is_eof() { "cut off".to_owned() } else { printable(&error.to_string()) };
                return (tables, Some(format!("its JSON is {what}")));
            }
        }
    }
}

fn walk(value: &Value, within: &str, tables: &mut Vec<Table>) {
    match value {
        Value::Array(list) => list.iter().for_each(|value| walk(value, within, tables)),
        Value::Object(keys) => {
            let mut row = Vec::new();
            flatten(keys, "", &mut row);
            if row.len() >= 3 {
                take(&row, sensor(keys, within), tables);
            }
            for (key, value) in keys.iter().filter(|(_, value)| holds_objects(value)) {
                walk(value, key, tables);
            }
        }
        _ => {}
    }
}

/// Whether rows of their own may stand in a value: objects in an array, or an object that holds such.
fn holds_objects(value: &Value) -> bool {
    match value {
        Value::Array(list) => list.iter().any(Value::is_object),
        Value::Object(keys) => keys.values().any(holds_objects),
        _ => false,
    }
}

fn sensor(keys: &Map<String, Value>, within: &str) -> String {
    let said = SENSOR.iter().find_map(|key| match keys.get(*key)? {
        Value::String(name) => Some(name.as_str()),
        Value::Number(number) => {
            let number = number.as_u64()?;
            ANDROID.iter().find(|(one, _)| *one == number).map(|(_, name)| *name)
        }
        _ => None,
    });
    said.unwrap_or(within).to_owned()
}

/// The numbers below an object, with the keys down to them.
fn flatten(keys: &Map<String, Value>, above: &str, row: &mut Vec<(String, String)>) {
    for (key, value) in keys {
        if row.len() >= MOST {
            return;
        }
        let name = format!("{above}{}", key.replace([',', '\n', '\r', '"', '#'], " "));
        match value {
            Value::Number(number) => row.push((name, number.to_string())),
            // Sensor Logger writes numbers as text.
            Value::String(text) if text.trim().parse::<f64>().is_ok() => {
                row.push((name, text.trim().to_owned()));
            }
            Value::Array(list) if list.len() <= 9 && list.iter().all(Value::is_number) => {
                row.extend(list.iter().enumerate().map(|(i, v)| (format!("{name}[{i}]"), v.to_string())));
            }
            Value::Object(inner) if !holds_objects(value) => flatten(inner, &format!("{name}."), row),
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
        assert_eq!(sensors, ["accelerations", "rotations"]);
        let wide = r#"[{"t": 1, "gyro": {"x": 1, "y": 2, "z": 3}, "accel": [4, 5, 6]}]"#;
        assert_eq!(of(wide)[0].1, "accel[0],accel[1],accel[2],gyro.x,gyro.y,gyro.z,t\n4,5,6,1,2,3,1\n");
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
