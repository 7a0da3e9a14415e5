//! Which column of a log is what, from its header's names or by position.
//!
//! A name is read without case, blanks, underscores and dots, in common spellings: `timestamp`, `time`, `t`, `stamp` for time;
//! `w_RS_S_x`, `gyro_x`, `gx`, `angular_velocity.x` for the gyroscope; `a_RS_S_x`, `acc_x`, `ax`, `linear_acceleration.x` for
//! the accelerometer. A unit stands in brackets (`[rad s^-1]`, `(deg/s)`) or at the end (`gyro_x_dps`, `timestamp_ns`).

use super::rows::Header;
use super::unit::{self, Dimension, STANDARD_GRAVITY};
use super::{IoError, TimeUnit};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Unit of a log's gyroscope columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum GyroUnit {
    /// Radians a second.
    #[serde(rename = "rad/s")]
    RadPerSecond,
    /// Degrees a second.
    #[serde(rename = "deg/s")]
    DegPerSecond,
}

impl GyroUnit {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::RadPerSecond, Self::DegPerSecond];

    /// `"rad/s"` or `"deg/s"`.
    pub fn name(self) -> &'static str {
        match self {
            Self::RadPerSecond => "rad/s",
            Self::DegPerSecond => "deg/s",
        }
    }

    /// One of these in rad/s.
    pub fn factor(self) -> f64 {
        match self {
            Self::RadPerSecond => 1.0,
            Self::DegPerSecond => std::f64::consts::PI / 180.0,
        }
    }
}

/// Unit of a log's accelerometer columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum AccelUnit {
    /// Metres a second squared.
    #[serde(rename = "m/s^2")]
    MetrePerSecond2,
    /// Standard gravity, 9.80665 m/s^2.
    #[serde(rename = "g")]
    StandardGravity,
    /// A thousandth of standard gravity.
    #[serde(rename = "mg")]
    MilliGravity,
}

impl AccelUnit {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::MetrePerSecond2, Self::StandardGravity, Self::MilliGravity];

    /// `"m/s^2"`, `"g"` or `"mg"`.
    pub fn name(self) -> &'static str {
        match self {
            Self::MetrePerSecond2 => "m/s^2",
            Self::StandardGravity => "g",
            Self::MilliGravity => "mg",
        }
    }

    /// One of these in m/s^2.
    pub fn factor(self) -> f64 {
        match self {
            Self::MetrePerSecond2 => 1.0,
            Self::StandardGravity => STANDARD_GRAVITY,
            Self::MilliGravity => STANDARD_GRAVITY * 1e-3,
        }
    }
}

/// Where a log keeps its stamps and its six axes: column indices from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ImuColumns {
    /// The stamp.
    pub time: usize,
    /// Gyroscope x, y, z.
    pub gyro: [usize; 3],
    /// Accelerometer x, y, z.
    pub accel: [usize; 3],
}

impl ImuColumns {
    /// ASL's order: stamp, gyroscope x y z, accelerometer x y z.
    pub const ASL: Self = Self { time: 0, gyro: [1, 2, 3], accel: [4, 5, 6] };
}

/// What a header says: columns, and units where it names them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Named {
    pub columns: ImuColumns,
    pub time: Option<TimeUnit>,
    pub gyro: Option<GyroUnit>,
    pub accel: Option<AccelUnit>,
}

/// Finds the seven columns by their names.
///
/// # Errors
/// A column that is missing or named twice; a unit that is not known, or differs between axes.
pub(crate) fn from_header(header: &Header, path: &Path) -> Result<Named, IoError> {
    let mut found = [None; 7];
    let mut named = Named { columns: ImuColumns::ASL, time: None, gyro: None, accel: None };
    for (index, name) in header.names.iter().enumerate() {
        let Some((slot, unit)) = meaning(name) else {
            continue;
        };
        if let Some(first) = found[slot] {
            return Err(IoError::DoubleColumn {
                path: path.to_path_buf(),
                line: header.line,
                column: SLOTS[slot].to_owned(),
                first,
                second: index,
            });
        }
        found[slot] = Some(index);
        if unit.is_empty() {
            continue;
        }
        let known = match slot {
            0 => take(&mut named.time, time_unit(&unit)),
            1..=3 => take(&mut named.gyro, gyro_unit(&unit)),
            _ => take(&mut named.accel, accel_unit(&unit)),
        };
        if !known {
            return Err(IoError::UnknownUnit {
                path: path.to_path_buf(),
                line: header.line,
                column: name.clone(),
                unit,
                known: match slot {
                    0 => "s, ms, us, ns",
                    1..=3 => "rad/s, deg/s (the same for all axes)",
                    _ => "m/s^2, g, mg (the same for all axes)",
                },
            });
        }
    }
    let mut at = [0; 7];
    for ((at, found), slot) in at.iter_mut().zip(found).zip(SLOTS) {
        *at = found.ok_or_else(|| missing(header, path, slot))?;
    }
    named.columns = ImuColumns { time: at[0], gyro: [at[1], at[2], at[3]], accel: [at[4], at[5], at[6]] };
    Ok(named)
}

/// The error for a column that the header does not name.
pub(crate) fn missing(header: &Header, path: &Path, column: &str) -> IoError {
    let mut found = header.names.join(", ");
    if let Some((cut, _)) = found.char_indices().nth(300) {
        found.truncate(cut);
        found.push_str("...");
    }
    IoError::MissingColumn { path: path.to_path_buf(), line: header.line, column: column.to_owned(), found }
}

/// What the seven columns are called in messages.
pub(crate) const SLOTS: [&str; 7] = ["time", "gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"];

const TIME: [&str; 8] = ["t", "time", "timestamp", "timestamps", "stamp", "unixtime", "epoch", "headerstamp"];
const GYRO: [&str; 11] = [
    "w",
    "wrss",
    "g",
    "gyr",
    "gyro",
    "gyroscope",
    "omega",
    "angvel",
    "angularvelocity",
    "angularrate",
    "rotationrate",
];
const ACCEL: [&str; 10] = [
    "a",
    "arss",
    "acc",
    "accel",
    "accelerometer",
    "acceleration",
    "linacc",
    "linearacceleration",
    "specificforce",
    "f",
];

/// Keeps `unit`; `false` when it is not known or another axis has another one.
fn take<U: Copy + PartialEq>(slot: &mut Option<U>, unit: Option<U>) -> bool {
    match (unit, *slot) {
        (None, _) => false,
        (Some(unit), Some(before)) => unit == before,
        (Some(unit), None) => {
            *slot = Some(unit);
            true
        }
    }
}

/// Which of [`SLOTS`] a column's name means, and the unit it names, reduced to letters and digits; empty when it names none.
fn meaning(name: &str) -> Option<(usize, String)> {
    let (name, unit) = match name.find(['[', '(']) {
        Some(at) => (&name[..at], reduced(&name[at..])),
        None => (name, String::new()),
    };
    if let Some(slot) = slot_of(&reduced(name)) {
        return Some((slot, unit));
    }
    // A unit behind the name: one more word at the end, then two, then three (`gyro_x_rad_s`, `acc_x_m_s_2`).
    let is_break = |c: char| !c.is_alphanumeric();
    let mut cut = name.len();
    for _ in 0..4 {
        cut = name[..cut].rfind(is_break)?;
        if let Some(slot) = slot_of(&reduced(&name[..cut])) {
            let suffix = reduced(&name[cut..]);
            return Some((slot, if unit.is_empty() { suffix } else { unit }));
        }
    }
    None
}

/// Lower case, letters and digits only; a degree sign is spelt out.
fn reduced(text: &str) -> String {
    text.replace('°', "deg").chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

fn slot_of(name: &str) -> Option<usize> {
    let name = name.strip_prefix("field").unwrap_or(name);
    let name = name.strip_prefix("imu").unwrap_or(name);
    if TIME.contains(&name) {
        return Some(0);
    }
    let axis = match name.as_bytes().last()? {
        b'x' => 0,
        b'y' => 1,
        b'z' => 2,
        _ => return None,
    };
    let base = &name[..name.len() - 1];
    if GYRO.contains(&base) {
        Some(1 + axis)
    } else if ACCEL.contains(&base) {
        Some(4 + axis)
    } else {
        None
    }
}

fn time_unit(unit: &str) -> Option<TimeUnit> {
    known(unit, Dimension::TIME, &TimeUnit::ALL, TimeUnit::seconds)
}

fn gyro_unit(unit: &str) -> Option<GyroUnit> {
    known(unit, Dimension::RATE, &GyroUnit::ALL, GyroUnit::factor)
}

fn accel_unit(unit: &str) -> Option<AccelUnit> {
    known(unit, Dimension::ACCELERATION, &AccelUnit::ALL, AccelUnit::factor)
}

/// Which of `all` a [reduced] unit is.
fn known<U: Copy>(unit: &str, dimension: Dimension, all: &[U], scale: fn(U) -> f64) -> Option<U> {
    // What a column's name cannot hold, put back.
    let unit = match unit {
        "rads1" | "rads" | "radsec" | "radpersec" => "rad/s",
        "degs1" | "degs" | "degsec" | "degpersec" => "deg/s",
        "ms2" | "mss" | "mps2" | "msec2" | "mpers2" | "ms²" => "m/s^2",
        unit => unit,
    };
    let unit = unit::parse(unit).ok()?;
    all.iter().copied().find(|one| unit.is(scale(*one), dimension))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(names: &str) -> Result<Named, IoError> {
        let header = Header { line: 1, names: names.split(',').map(|n| n.trim().to_owned()).collect() };
        from_header(&header, Path::new("f.csv"))
    }

    #[test]
    fn common_headers_are_understood() {
        let asl = named(
            "timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],\
             a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]",
        )
        .unwrap();
        assert_eq!(
            asl,
            Named {
                columns: ImuColumns::ASL,
                time: Some(TimeUnit::Nanos),
                gyro: Some(GyroUnit::RadPerSecond),
                accel: Some(AccelUnit::MetrePerSecond2),
            }
        );
        let phone = named("ax (g),ay (g),az (g),gyroX_dps,gyroY_dps,gyroZ_dps,temperature,time_us").unwrap();
        assert_eq!(
            phone,
            Named {
                columns: ImuColumns { time: 7, gyro: [3, 4, 5], accel: [0, 1, 2] },
                time: Some(TimeUnit::Micros),
                gyro: Some(GyroUnit::DegPerSecond),
                accel: Some(AccelUnit::StandardGravity),
            }
        );
        let ros = named(
            "time,field.header.seq,field.angular_velocity.x,field.angular_velocity.y,field.angular_velocity.z,\
             field.angular_velocity_covariance0,field.linear_acceleration.x,field.linear_acceleration.y,\
             field.linear_acceleration.z",
        )
        .unwrap();
        assert_eq!(ros.columns.gyro, [2, 3, 4]);
        assert_eq!(ros.columns.accel, [6, 7, 8]);
        assert_eq!(ros.time, None);
        let long =
            named("t_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,acc_x_m_s_2,acc_y_m_s_2,acc_z_m_s_2").unwrap();
        assert_eq!((long.time, long.accel), (Some(TimeUnit::Seconds), Some(AccelUnit::MetrePerSecond2)));
    }

    #[test]
    fn what_is_missing_double_or_in_an_unknown_unit_is_named() {
        let case = |names: &str| named(names).unwrap_err().to_string();
        assert_eq!(
            case("t,gx,gy,gz,ax,ay"),
            "f.csv:1: no column `accel_z`; the header names t, gx, gy, gz, ax, ay"
        );
        assert_eq!(case("t,time,gx,gy,gz,ax,ay,az"), "f.csv:1: columns 1 and 2 both read as `time`");
        assert!(case("t,gx [mdps],gy,gz,ax,ay,az").contains("has the unit \"mdps\"; known are rad/s, deg/s"));
        assert!(case("t,gx [dps],gy [rad/s],gz,ax,ay,az").contains("the same for all axes"));
    }
}
