//! Tables with a row a sensor, as Android's loggers write them: `UncalGyro,1663164669189,65972053803181,-0.0016,0.418,0.363` beside rows of other sensors.
//!
//! One of the first fields names the sensor. The rows of each are a table of its own, with the comment above that begins with the sensor's name for a
//! header (GnssLogger), else the file's; without either the name is cut out.

use std::collections::BTreeMap;

/// Fields among which the sensor's name is looked for.
const FIELDS: usize = 4;
/// Rows that a name must stand in, of those that are looked at.
const LEAST: usize = 3;

/// How a table is split.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Long {
    delimiter: char,
    /// The field with the sensor's name.
    field: usize,
    pub(crate) gyro: String,
    pub(crate) accel: String,
}

/// Of names the gyroscope's and the accelerometer's: what was calibrated before what was not, and none from which gravity was taken.
pub(crate) fn gyro_and_accel<'a>(names: &(impl Iterator<Item = &'a str> + Clone)) -> [Option<&'a str>; 2] {
    [&["gyr", "rotationrate", "rotations", "angularvel"][..], &["acc"][..]].map(|words| {
        let rank = |name: &&str| {
            let name = name.to_lowercase().replace([' ', '_'], "");
            let is = words.iter().any(|word| name.contains(word));
            let lacks = ["linear", "user", "gravity"].iter().any(|word| name.contains(word));
            (is && !lacks).then(|| u8::from(name.contains("uncal")))
        };
        names
            .clone()
            .filter_map(|name| Some((rank(&name)?, name)))
            .min_by_key(|(rank, _)| *rank)
            .map(|(_, name)| name)
    })
}

fn field(line: &str, delimiter: char, at: usize) -> Option<&str> {
    line.split(delimiter).nth(at).map(|field| field.trim().trim_matches('"'))
}

impl Long {
    /// Looks at the first lines of a file.
    pub(crate) fn of(head: &[u8]) -> Option<Self> {
        let text = String::from_utf8_lossy(head);
        let rows = || text.lines().filter(|line| !line.trim().is_empty() && !line.starts_with(['#', '%']));
        let delimiter = [',', ';', '\t', ' ']
            .into_iter()
            .find(|d| rows().nth(1).is_some_and(|line| line.contains(*d)))?;
        (0..FIELDS).find_map(|at| {
            let mut names: BTreeMap<&str, usize> = BTreeMap::new();
            for name in rows().filter_map(|line| field(line, delimiter, at)) {
                if !name.is_empty() && name.parse::<f64>().is_err() {
                    *names.entry(name).or_default() += 1;
                }
            }
            let often = names.iter().filter(|(_, rows)| **rows >= LEAST).map(|(name, _)| *name);
            match gyro_and_accel(&often) {
                [Some(gyro), Some(accel)] => {
                    Some(Self { delimiter, field: at, gyro: gyro.to_owned(), accel: accel.to_owned() })
                }
                _ => None,
            }
        })
    }

    /// The rows of one sensor, with their header.
    pub(crate) fn rows_of(&self, text: &str, sensor: &str) -> String {
        let named = |line: &str| field(line, self.delimiter, self.field) == Some(sensor);
        let comment = |line: &'_ str| line.strip_prefix(['#', '%']).map(str::trim_start).map(str::to_owned);
        let own = text.lines().filter_map(comment).find(|line| named(line));
        let first = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with(['#', '%']));
        let is_number = |field: &str| field.trim().trim_matches('"').parse::<f64>().is_ok();
        let plain = first.filter(|line| !line.split(self.delimiter).any(is_number)).map(str::to_owned);
        let header = own.or(plain);
        let mut out = header.as_ref().map_or_else(String::new, |header| format!("{header}\n"));
        for line in text.lines().filter(|line| named(line)) {
            if header.is_some() {
                out.push_str(line);
            } else {
                let rest = line.split(self.delimiter).enumerate().filter(|(at, _)| *at != self.field);
                let rest: Vec<&str> = rest.map(|(_, field)| field).collect();
                out.push_str(&rest.join(&self.delimiter.to_string()));
            }
            out.push('\n');
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_each_sensor_are_a_table_with_the_header_that_is_theirs() {
        let rows = "UncalGyro,1,10,.1,.2,.3\nUncalAccel,1,11,1,2,3\nRaw,5,6\n".repeat(4);
        let own =
            format!("# Version: 3\n# UncalGyro,utcTimeMillis,elapsedRealtimeNanos,X,Y,Z\n# Raw,a,b\n{rows}");
        let long = Long::of(own.as_bytes()).unwrap();
        assert_eq!((long.gyro.as_str(), long.accel.as_str(), long.field), ("UncalGyro", "UncalAccel", 0));
        let gyro = long.rows_of(&own, "UncalGyro");
        assert!(
            gyro.starts_with("UncalGyro,utcTimeMillis,elapsedRealtimeNanos,X,Y,Z\nUncalGyro,1,10,.1,.2,.3\n"),
            "{gyro}"
        );
        let plain = format!("MessageType,t,e,x,y,z\n{rows}");
        assert_eq!(
            Long::of(plain.as_bytes()).unwrap().rows_of(&plain, "UncalAccel").lines().next(),
            Some("MessageType,t,e,x,y,z")
        );
        let bare = Long::of(rows.as_bytes()).unwrap();
        assert_eq!(bare.rows_of(&rows, "UncalAccel").lines().next(), Some("1,11,1,2,3"));
        for other in ["t,gyro_x,acc_x\n1,2,3\n2,3,4\n", "", "imu,1,2\nimu,2,3\nimu,4,5\n"] {
            assert_eq!(Long::of(other.as_bytes()), None);
        }
    }

    #[test]
    fn of_several_that_are_named_alike_the_calibrated_with_gravity_are_taken() {
        let names = ["Accelerometer Uncalibrated", "linear_acceleration", "TotalAcceleration", "Gyroscope"];
        assert_eq!(gyro_and_accel(&names.into_iter()), [Some("Gyroscope"), Some("TotalAcceleration")]);
    }
}
