//! Which column of a log is what and in which unit, by the names in its header.
//!
//! A name is read without case, blanks, underscores and dots. It is a word for a sensor and an axis (`gyro_x`, `xgyro`, `Gyr X`,
//! `gyro_rad[0]`, `angular_velocity.x`) or one for time; a unit stands in brackets (`[rad s^-1]`, `(deg/s)`) or at the end (`gyro_x_dps`,
//! `timestamp_ns`). Where several triples or stamps are named, ranks decide: the message's own stamp goes before that of its arrival, an
//! accelerometer before a `linear acceleration` from which gravity was taken, a calibrated triple before the raw one. Two of one rank are an
//! error. What was passed over is in [`Named::passed`].

use super::columns::{AccelUnit, GyroUnit, ImuColumns, SLOTS};
use super::row_fault::RowFault;
use super::rows::Header;
use super::unit::{self, Dimension};
use super::words::{
    ACCEL, APPLES, GYRO, INTERVALS, MAY_LACK_GRAVITY, MICROS, NANOS, TIME, WITHOUT_GRAVITY, Word,
};
use super::{IoError, TimeUnit};
use dpn_core::Sensor;
use std::path::Path;

/// What a header says: columns, and units where it names them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Named {
    pub columns: ImuColumns,
    pub time: Option<TimeUnit>,
    /// The stamps are Xsens' `SampleTimeFine`, which counts in 100 us or in 1 us.
    pub fine: bool,
    pub gyro: Option<GyroUnit>,
    pub accel: Option<AccelUnit>,
    /// The columns of gravity may be of what is in the accelerometer's too: the numbers say.
    pub gravity_may_be_in: bool,
    /// Columns that could have been meant too.
    pub passed: Vec<String>,
}

/// What a column's name means.
#[derive(Debug, Clone, PartialEq)]
struct Meaning {
    /// Of [`SLOTS`].
    slot: usize,
    word: &'static str,
    rank: u8,
    /// Reduced to letters and digits; empty when it names none.
    unit: String,
}

/// Which of [`SLOTS`] the names mean, as flags; of a file with one sensor alone, that one's count for both.
pub(crate) fn slots(names: &[String], only: Option<Sensor>) -> [bool; 7] {
    let mut found = [false; 7];
    let mut meanings: Vec<Option<Meaning>> = names.iter().map(|name| meaning_in(name, only)).collect();
    apples(&mut meanings);
    for meaning in meanings.iter().flatten() {
        found[meaning.slot] = true;
    }
    if let Some(sensor) = only {
        for axis in 0..3 {
            let own = found[first_slot(sensor) + axis];
            (found[1 + axis], found[4 + axis]) = (own, own);
        }
    }
    found
}

/// What the caller says, so that the header need not.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Told {
    /// Stamps are counted.
    pub counted: bool,
    /// The units of stamps, gyroscope and accelerometer.
    pub units: [bool; 3],
}

/// Finds the columns by their names; of a file with one sensor alone, that one's stand for both.
///
/// # Errors
/// A column that is missing or named twice; a unit that is not known, or differs between axes, and is not told.
pub(crate) fn from_header(
    header: &Header,
    path: &Path,
    only: Option<Sensor>,
    Told { counted, units }: Told,
) -> Result<Named, IoError> {
    let mut meanings: Vec<Option<Meaning>> = header.names.iter().map(|name| meaning_in(name, only)).collect();
    let by_apple = apples(&mut meanings);
    let mut passed = Vec::new();
    let time = match best(&meanings, 0..1, header, path, &mut passed) {
        Ok(time) if !counted => vec![time[0]],
        Ok(time) => {
            passed = vec![format!("stamps counted, not from `{}`", header.names[time[0]])];
            Vec::new()
        }
        Err(_) if counted => Vec::new(),
        Err(error) => return Err(error),
    };
    let [gyro, accel] = match only {
        None => [
            triple(&meanings, Sensor::Gyro, header, path, &mut passed)?,
            triple(&meanings, Sensor::Accel, header, path, &mut passed)?,
        ],
        Some(sensor) => [triple(&meanings, sensor, header, path, &mut passed)?; 2],
    };
    let mut overruled = Vec::new();
    let mut unit_of = |columns: &[usize], slot: usize| -> Result<Option<String>, IoError> {
        let mut said: Option<String> = None;
        for &column in columns {
            let unit = meanings[column].as_ref().map_or("", |m| &m.unit);
            if unit.is_empty() {
                continue;
            }
            let same = said.as_ref().is_none_or(|before| before == unit);
            if !same || !is_known(unit, slot) {
                if !units[slot.div_ceil(3)] {
                    return Err(unknown_unit(header, path, column, unit, slot));
                }
                overruled.push(format!("the unit as told, not that of `{}`", header.names[column]));
                return Ok(None);
            }
            said = Some(unit.to_owned());
        }
        Ok(said)
    };
    let of = |sensor| match only {
        Some(other) if other != sensor => &[][..],
        _ if sensor == Sensor::Gyro => &gyro[..],
        _ => &accel[..],
    };
    let time_said = unit_of(&time, 0)?;
    let gyro_said = unit_of(of(Sensor::Gyro), 1)?;
    let accel_said = unit_of(of(Sensor::Accel), 4)?;
    passed.append(&mut overruled);
    let word = |column: usize| meanings[column].as_ref().map_or("", |m| m.word);
    if by_apple || APPLES.contains(&word(accel[0])) {
        passed.push(
            "an iPhone's accelerometer, which reads -1 g upwards: --accel-scale -9.80665 turns it round"
                .to_owned(),
        );
    }
    let of_user = WITHOUT_GRAVITY.iter().filter(|(user, _)| *user == word(accel[0]));
    let gravity = of_user.into_iter().find_map(|(_, gravity)| {
        let without_unit = |name: &str| reduced(name.split(['[', '(']).next().unwrap_or(name));
        let at = |axis| header.names.iter().position(|name| without_unit(name) == format!("{gravity}{axis}"));
        Some([at('x')?, at('y')?, at('z')?])
    });
    let beside = |words: &[&str], unit: TimeUnit| {
        let found = header.names.iter().position(|name| words.contains(&stripped(&reduced(name))));
        found.map(|column| (column, unit)).filter(|(column, _)| !time.contains(column))
    };
    let is_whole = time.first().map_or("", |time| word(*time)).contains("sec");
    let fraction = beside(&NANOS, TimeUnit::Nanos).or_else(|| beside(&MICROS, TimeUnit::Micros));
    let fraction = fraction.filter(|_| is_whole);
    let interval = |axes: [usize; 3]| -> Result<Option<usize>, IoError> {
        let Some((_, wanted)) = INTERVALS.iter().find(|(increment, _)| *increment == word(axes[0])) else {
            return Ok(None);
        };
        let found = header.names.iter().position(|name| reduced(name) == *wanted);
        found.map(Some).ok_or_else(|| missing(header, path, wanted))
    };
    Ok(Named {
        columns: ImuColumns {
            time: time.first().copied().unwrap_or_default(),
            fraction,
            gyro,
            accel,
            intervals: [interval(gyro)?, interval(accel)?],
            gravity,
        },
        time: time_said.as_deref().and_then(time_unit),
        fine: time_said.as_deref() == Some("fine"),
        gravity_may_be_in: MAY_LACK_GRAVITY.contains(&word(accel[0])),
        gyro: gyro_said.as_deref().and_then(gyro_unit),
        accel: accel_said.as_deref().and_then(accel_unit),
        passed,
    })
}

/// The units that the header names for columns that the caller chose.
pub(crate) fn units_at(
    header: &Header,
    columns: &ImuColumns,
) -> (Option<TimeUnit>, Option<GyroUnit>, Option<AccelUnit>) {
    let said = |column: usize| {
        let name = header.names.get(column)?;
        match meaning(name) {
            Some(meaning) => Some(meaning.unit),
            None => name.find(['[', '(']).map(|at| reduced(&name[at..])),
        }
    };
    (
        said(columns.time).as_deref().and_then(time_unit),
        said(columns.gyro[0]).as_deref().and_then(gyro_unit),
        said(columns.accel[0]).as_deref().and_then(accel_unit),
    )
}

/// Stray Scanner calls the acceleration `a` and the turning `alpha`, which is the acceleration's name beside Kalibr's `omega`; whether it was so.
fn apples(meanings: &mut [Option<Meaning>]) -> bool {
    let has = |is: fn(&Meaning) -> bool| meanings.iter().flatten().any(is);
    let is_so = has(|m| m.word == "alpha") && has(|m| m.word == "a") && !has(|m| (1..4).contains(&m.slot));
    for meaning in meanings.iter_mut().flatten().filter(|m| is_so && m.word == "alpha") {
        meaning.slot -= 3;
    }
    is_so
}

fn first_slot(sensor: Sensor) -> usize {
    match sensor {
        Sensor::Gyro => 1,
        Sensor::Accel => 4,
    }
}

fn triple(
    meanings: &[Option<Meaning>],
    sensor: Sensor,
    header: &Header,
    path: &Path,
    passed: &mut Vec<String>,
) -> Result<[usize; 3], IoError> {
    let first = first_slot(sensor);
    let found = best(meanings, first..first + 3, header, path, passed)?;
    Ok([found[0], found[1], found[2]])
}

/// Of the words that name all of `slots`, the columns of the one of the highest rank.
fn best(
    meanings: &[Option<Meaning>],
    slots: std::ops::Range<usize>,
    header: &Header,
    path: &Path,
    passed: &mut Vec<String>,
) -> Result<Vec<usize>, IoError> {
    let at = |word: Option<&str>, slot: usize| {
        let mut all = meanings.iter().enumerate().filter(move |(_, m)| {
            m.as_ref().is_some_and(|m| m.slot == slot && word.is_none_or(|word| m.word == word))
        });
        (all.next().map(|(i, _)| i), all.next().map(|(i, _)| i))
    };
    let mut words: Vec<(u8, &str)> = Vec::new();
    for meaning in meanings.iter().flatten().filter(|m| slots.contains(&m.slot)) {
        if !words.iter().any(|(_, word)| *word == meaning.word)
            && slots.clone().all(|slot| at(Some(meaning.word), slot).0.is_some())
        {
            words.push((meaning.rank, meaning.word));
        }
    }
    words.sort_by_key(|(rank, _)| std::cmp::Reverse(*rank));
    let twice = |slot: usize, a: usize, b: usize| {
        let (column, first, second) = (SLOTS[slot].to_owned(), a.min(b), a.max(b));
        IoError::row(path, header.line, RowFault::DoubleColumn { column, first, second })
    };
    let chosen = match words[..] {
        // Words may differ between axes, as long as each axis is named once.
        [] => None,
        [(rank, word), (next, other), ..] if rank == next => {
            let column = |word| at(Some(word), slots.start).0.expect("a word in the list names all slots");
            return Err(twice(slots.start, column(word), column(other)));
        }
        [(_, word), ..] => Some(word),
    };
    let mut columns = Vec::with_capacity(slots.len());
    for slot in slots.clone() {
        match at(chosen, slot) {
            (Some(first), None) => columns.push(first),
            (Some(first), Some(second)) => return Err(twice(slot, first, second)),
            (None, _) => return Err(missing(header, path, SLOTS[slot])),
        }
    }
    if let Some((_, other)) = words.get(1) {
        let other = at(Some(other), slots.start).0.expect("a word in the list names all slots");
        let what = ["stamps", "gyroscope", "accelerometer"][slots.start.div_ceil(3)];
        passed.push(format!("{what} from `{}`, not `{}`", header.names[columns[0]], header.names[other]));
    }
    Ok(columns)
}

/// The error for a column that the header does not name.
pub(crate) fn missing(header: &Header, path: &Path, column: &str) -> IoError {
    let mut found = header.names.join(", ");
    if let Some((cut, _)) = found.char_indices().nth(300) {
        found.truncate(cut);
        found.push_str("...");
    }
    IoError::row(path, header.line, RowFault::MissingColumn { column: column.to_owned(), found })
}

fn unknown_unit(header: &Header, path: &Path, column: usize, unit: &str, slot: usize) -> IoError {
    let known = match slot {
        0 => "s, ms, us, ns",
        1..=3 => "rad/s, deg/s, mdeg/s, deg/h, rpm (the same for all axes)",
        _ => "m/s^2, g, mg, cm/s^2, ft/s^2 (the same for all axes)",
    };
    let (column, unit) = (header.names[column].clone(), unit.to_owned());
    IoError::row(path, header.line, RowFault::UnknownUnit { column, unit, known })
}

fn is_known(unit: &str, slot: usize) -> bool {
    match slot {
        0 => unit == "fine" || time_unit(unit).is_some(),
        1..=3 => gyro_unit(unit).is_some(),
        _ => accel_unit(unit).is_some(),
    }
}

/// The same; in a file of one sensor, bare axes are that one's, measured values too, and the other's are nobody's.
fn meaning_in(name: &str, only: Option<Sensor>) -> Option<Meaning> {
    let Some(sensor) = only else { return meaning(name) };
    let own = |meaning: &Meaning| meaning.slot == 0 || (meaning.slot < 4) == (sensor == Sensor::Gyro);
    let word = if sensor == Sensor::Gyro { "gyro" } else { "accel" };
    let bare = ["measurement", "values", "value"].iter().find_map(|said| {
        name.get(..said.len()).filter(|head| head.eq_ignore_ascii_case(said)).map(|_| &name[said.len()..])
    });
    meaning(name).or_else(|| meaning(&format!("{word} {}", bare.unwrap_or(name)))).filter(own)
}

fn meaning(original: &str) -> Option<Meaning> {
    // Axes by number: `gyro_rad[0]`.
    let numbered =
        [("[0]", "_x"), ("[1]", "_y"), ("[2]", "_z")].into_iter().find(|(at, _)| original.contains(at));
    let axis = numbered.map(|(at, axis)| original.replacen(at, axis, 1));
    let name = axis.as_deref().unwrap_or(original);
    let (name, unit) = match name.find(['[', '(']) {
        Some(at) => (&name[..at], reduced(&name[at..])),
        None => (name, String::new()),
    };
    let with = |(slot, (word, rank, implied)): (usize, Word), said: String| {
        let unit = [unit.clone(), said, implied.to_owned()].into_iter().find(|unit| !unit.is_empty());
        Some(Meaning { slot, word, rank, unit: unit.unwrap_or_default() })
    };
    let whole = reduced(name);
    // The rest of a stamp in two columns is no stamp of its own.
    if NANOS.contains(&stripped(&whole)) {
        return None;
    }
    // `ts` is a stamp's name, `t_s` a time in seconds.
    let is_in_seconds = stripped(&whole) == "ts" && !name.trim().to_ascii_lowercase().ends_with("ts");
    if let Some(found) = slot_of(&whole).filter(|_| !is_in_seconds) {
        return with(found, String::new());
    }
    // A unit behind the name: one more word at the end, then two, then three (`gyro_x_rad_s`, `acc_x_m_s_2`, `UncalGyroXRadPerSec`).
    let is_break = |c: char| !c.is_alphanumeric();
    let mut words = String::with_capacity(name.len());
    for c in name.chars() {
        if c.is_uppercase()
            && words.ends_with(|before: char| {
                before.is_lowercase() || before == 'X' || before == 'Y' || before == 'Z'
            })
        {
            words.push(' ');
        }
        words.push(c);
    }
    let name = words.as_str();
    let mut cut = name.trim_end_matches(is_break).len();
    for _ in 0..4 {
        let Some(at) = name[..cut].rfind(is_break) else { break };
        cut = at;
        if let Some(found) = slot_of(&reduced(&name[..cut])) {
            return with(found, reduced(&name[cut..]));
        }
    }
    // A unit grown together with a word for time: `timestampns`, `sincestartinms`.
    let grown = TIME.into_iter().find_map(|word| {
        let unit = stripped(&whole).strip_prefix(word.0)?;
        time_unit(unit).and_then(|_| with((0, word), unit.to_owned()))
    });
    // A part's name before the sensor's, as HyperIMU has it: `LSM6DSO Accelerometer.x`.
    let is_part = |word: &str| {
        word.chars().any(|c| c.is_ascii_digit()) && word.starts_with(|c: char| c.is_ascii_uppercase())
    };
    grown.or_else(|| {
        original.split_once(' ').filter(|(part, _)| is_part(part)).and_then(|(_, rest)| meaning(rest))
    })
}

/// Lower case, letters and digits only; a degree sign is spelt out.
fn reduced(text: &str) -> String {
    text.replace(['°', 'º'], "deg")
        .chars()
        .filter(|c| c.is_alphanumeric())
        .flat_map(char::to_lowercase)
        .collect()
}

/// Without what messages and drivers put in front: `field.`, `imu0_`.
fn stripped(name: &str) -> &str {
    let name = name.strip_prefix("field").unwrap_or(name);
    name.strip_prefix("imu").map_or(name, |rest| rest.trim_start_matches(|c: char| c.is_ascii_digit()))
}

fn slot_of(name: &str) -> Option<(usize, Word)> {
    let name = stripped(name);
    let find = |words: &[Word], base: &str| words.iter().copied().find(|(word, ..)| *word == base);
    if let Some(word) = find(&TIME, name) {
        return Some((0, word));
    }
    let name = name.strip_suffix("axis").unwrap_or(name);
    let axis = |byte: Option<&u8>| byte.and_then(|b| b"xyz".iter().position(|axis| axis == b));
    let bytes = name.as_bytes();
    let of = |axis: usize, base: &str| {
        let gyro = find(&GYRO, base).map(|word| (1 + axis, word));
        gyro.or_else(|| find(&ACCEL, base).map(|word| (4 + axis, word)))
    };
    let last = axis(bytes.last()).and_then(|axis| of(axis, &name[..name.len() - 1]));
    last.or_else(|| axis(bytes.first()).and_then(|axis| of(axis, &name[1..])))
}

fn time_unit(unit: &str) -> Option<TimeUnit> {
    let unit = unit.strip_prefix("in").unwrap_or(unit);
    if ["d", "day", "days"].contains(&unit) {
        return Some(TimeUnit::Days);
    }
    known(unit, Dimension::TIME, &TimeUnit::USUAL, TimeUnit::seconds)
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
        "nanosec" | "nanos" => "ns",
        "microsec" | "micros" | "usec" => "us",
        "millisec" | "millis" | "msec" => "ms",
        "rads1" | "rads" | "radsec" | "radpersec" => "rad/s",
        "degs1" | "degs" | "degsec" | "degpersec" => "deg/s",
        "ms2" | "mss" | "mps2" | "msec2" | "mpers2" | "ms²" => "m/s^2",
        "cms2" | "cmss" | "cms²" | "gal" | "gals" => "cm/s^2",
        "mdegs" | "mdegsec" => "mdeg/s",
        "degh" | "deghr" | "deghour" | "degperh" | "degperhr" | "degperhour" => "deg/h",
        "revmin" | "rmin" => "rpm",
        "fts2" | "ftss" | "fts²" | "ftsec2" | "ftpers2" => "ft/s^2",
        unit => unit,
    };
    let unit = unit::parse(unit).ok()?;
    all.iter().copied().find(|one| unit.is(scale(*one), dimension))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(names: &str) -> Header {
        Header { line: 1, names: names.split(',').map(|n| n.trim().to_owned()).collect() }
    }

    fn named(names: &str) -> Result<Named, IoError> {
        from_header(&header(names), Path::new("f.csv"), None, Told::default())
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
                fine: false,
                gravity_may_be_in: false,
                gyro: Some(GyroUnit::RadPerSecond),
                accel: Some(AccelUnit::MetrePerSecond2),
                passed: Vec::new(),
            }
        );
        let phone = named("ax (g),ay (g),az (g),gyroX_dps,gyroY_dps,gyroZ_dps,temperature,time_us").unwrap();
        assert_eq!(phone.columns, ImuColumns::new(7, [3, 4, 5], [0, 1, 2]));
        assert_eq!(
            (phone.time, phone.gyro, phone.accel),
            (Some(TimeUnit::Micros), Some(GyroUnit::DegPerSecond), Some(AccelUnit::StandardGravity))
        );
        for (gyro, accel, units) in [
            ("rpm", "ft/s^2", (GyroUnit::TurnPerMinute, AccelUnit::FootPerSecond2)),
            ("deg/h", "ft/s2", (GyroUnit::DegPerHour, AccelUnit::FootPerSecond2)),
            ("°/h", "ft s^-2", (GyroUnit::DegPerHour, AccelUnit::FootPerSecond2)),
            ("mdps", "m/s²", (GyroUnit::MilliDegPerSecond, AccelUnit::MetrePerSecond2)),
        ] {
            let named = named(&format!("t,gx [{gyro}],gy,gz,ax ({accel}),ay,az")).unwrap();
            assert_eq!((named.gyro, named.accel), (Some(units.0), Some(units.1)), "{gyro}");
        }
        let long =
            named("t_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,acc_x_m_s_2,acc_y_m_s_2,acc_z_m_s_2").unwrap();
        assert_eq!((long.time, long.accel), (Some(TimeUnit::Seconds), Some(AccelUnit::MetrePerSecond2)));
        let mavlink = named("time_usec,xacc,yacc,zacc,xgyro,ygyro,zgyro").unwrap();
        assert_eq!(mavlink.columns, ImuColumns::new(0, [4, 5, 6], [1, 2, 3]));
        assert_eq!(mavlink.time, Some(TimeUnit::Micros));
        let split = named("header.stamp.sec,header.stamp.nanosec,gx,gy,gz,ax,ay,az").unwrap();
        assert_eq!(split.columns.fraction, Some((1, TimeUnit::Nanos)));
    }

    #[test]
    fn of_several_stamps_and_triples_the_sensors_own_are_taken_and_the_others_named() {
        let ros = named(
            "time,field.header.seq,field.header.stamp,field.angular_velocity.x,field.angular_velocity.y,\
             field.angular_velocity.z,field.linear_acceleration.x,field.linear_acceleration.y,field.linear_acceleration.z",
        )
        .unwrap();
        assert_eq!(ros.columns, ImuColumns::new(2, [3, 4, 5], [6, 7, 8]));
        assert_eq!(ros.passed, ["stamps from `field.header.stamp`, not `time`"]);
        let toolbox = named("time,gFx,gFy,gFz,ax,ay,az,wx,wy,wz").unwrap();
        assert_eq!((toolbox.columns.accel, toolbox.accel), ([1, 2, 3], Some(AccelUnit::StandardGravity)));
        assert_eq!(toolbox.passed, ["accelerometer from `gFx`, not `ax`"]);
        // T is temperature where something else is time.
        assert_eq!(named("TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T").unwrap().columns.time, 0);
        let android = named("Time since start in ms ,gx,gy,gz,ax,ay,az").unwrap();
        assert_eq!((android.columns.time, android.time), (0, Some(TimeUnit::Millis)));
        assert_eq!(named("sincestartinms,gx,gy,gz,ax,ay,az").unwrap().time, Some(TimeUnit::Millis));
        let mars = named(
            "Timestamp[nanosec], gx[rad/s], gy[rad/s], gz[rad/s], ax[m/s^2], ay[m/s^2], az[m/s^2], Unix time[nanosec]",
        );
        let mars = mars.unwrap();
        assert_eq!((mars.columns, mars.time), (ImuColumns::ASL, Some(TimeUnit::Nanos)));
        let stray = named("timestamp, a_x, a_y, a_z, alpha_x, alpha_y, alpha_z").unwrap();
        assert_eq!(stray.columns, ImuColumns::new(0, [4, 5, 6], [1, 2, 3]));
        assert!(stray.passed[0].contains("-1 g upwards"), "{:?}", stray.passed);
        let kalibr = named("timestamp,omega_x,omega_y,omega_z,alpha_x,alpha_y,alpha_z").unwrap();
        assert_eq!((kalibr.columns, kalibr.passed), (ImuColumns::ASL, Vec::new()));
    }

    #[test]
    fn increments_need_their_intervals() {
        let px4 = "timestamp,delta_angle[0],delta_angle[1],delta_angle[2],delta_velocity[0],delta_velocity[1],delta_velocity[2],\
                   delta_angle_dt";
        let error = named(px4).unwrap_err().to_string();
        assert!(error.starts_with("f.csv:1: no column `deltavelocitydt`"), "{error}");
        let whole = named(&format!("{px4},delta_velocity_dt")).unwrap();
        assert_eq!(whole.columns.intervals, [Some(7), Some(8)]);
        assert_eq!(whole.gyro, Some(GyroUnit::RadPerSecond));
    }

    #[test]
    fn a_file_of_one_sensor_needs_no_word_for_it() {
        let path = Path::new("f.csv");
        let named =
            from_header(&header("time,seconds_elapsed,z,y,x"), path, Some(Sensor::Gyro), Told::default())
                .unwrap();
        assert_eq!(named.columns, ImuColumns::new(0, [4, 3, 2], [4, 3, 2]));
        let phyphox = header("Time (s),X (m/s^2),Y (m/s^2),Z (m/s^2)");
        let named = from_header(&phyphox, path, Some(Sensor::Accel), Told::default()).unwrap();
        assert_eq!((named.columns.accel, named.accel), ([1, 2, 3], Some(AccelUnit::MetrePerSecond2)));
        assert_eq!((named.time, named.gyro), (Some(TimeUnit::Seconds), None));
        let long = header(
            "MessageType,utcTimeMillis,elapsedRealtimeNanos,MeasurementX,MeasurementY,MeasurementZ,BiasX,BiasY,BiasZ",
        );
        let named = from_header(&long, path, Some(Sensor::Gyro), Told::default()).unwrap();
        assert_eq!(
            (named.columns.time, named.columns.gyro, named.time),
            (2, [3, 4, 5], Some(TimeUnit::Nanos))
        );
        let gnss = header(
            "UncalGyro,utcTimeMillis,elapsedRealtimeNanos,UncalGyroXRadPerSec,UncalGyroYRadPerSec,UncalGyroZRadPerSec,DriftXRadPerSec,DriftYRadPerSec,DriftZRadPerSec",
        );
        let named = from_header(&gnss, path, Some(Sensor::Gyro), Told::default()).unwrap();
        assert_eq!((named.columns.gyro, named.gyro), ([3, 4, 5], Some(GyroUnit::RadPerSecond)));
    }

    #[test]
    fn what_is_missing_double_or_in_an_unknown_unit_is_named() {
        let case = |names: &str| named(names).unwrap_err().to_string();
        assert_eq!(
            case("t,gx,gy,gz,ax,ay"),
            "f.csv:1: no column `accel_z`; the header names t, gx, gy, gz, ax, ay"
        );
        assert_eq!(case("stamp,time,gx,gy,gz,ax,ay,az"), "f.csv:1: columns 1 and 2 both read as `time`");
        assert_eq!(case("t,gx,gy,gz,ax,ay,ay,az"), "f.csv:1: columns 6 and 7 both read as `accel_y`");
        assert!(
            case("t,gx [turns],gy,gz,ax,ay,az").contains("has the unit \"turns\"; known are rad/s, deg/s")
        );
        let told = Told { units: [false, true, false], ..Told::default() };
        let named =
            from_header(&header("t,gx [turns],gy,gz,ax,ay,az"), Path::new("f.csv"), None, told).unwrap();
        assert_eq!((named.gyro, &named.passed[0][..]), (None, "the unit as told, not that of `gx [turns]`"));
        assert!(case("t,gx [dps],gy [rad/s],gz,ax,ay,az").contains("the same for all axes"));
    }

    #[test]
    fn a_stamp_called_ts_has_no_unit_and_a_time_called_t_s_has_seconds() {
        let unit = |time: &str| named(&format!("{time},gx,gy,gz,ax,ay,az")).unwrap().time;
        assert_eq!(unit("ts"), None);
        assert_eq!(unit("ts_us"), Some(TimeUnit::Micros));
        assert_eq!(unit("t_s"), Some(TimeUnit::Seconds));
        assert_eq!(unit("t [s]"), Some(TimeUnit::Seconds));
        // As boards' examples print them.
        assert!(named("millis,AcX,AcY,AcZ,Tmp,GyX,GyY,GyZ").is_ok());
    }
}
