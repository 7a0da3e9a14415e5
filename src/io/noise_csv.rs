//! Noise tracks as CSV: a stamp in nanoseconds and six standard deviations of one sample a row.
//!
//! Header: `#timestamp [ns],accel_std_x [m s^-2],...,gyro_std_x [rad s^-1],...`. Read by these names in any order; other columns
//! are passed over.

use super::decimal::TimeUnit;
use super::names::missing;
use super::row_fault::RowFault;
use super::rows::Rows;
use super::{IoError, ResultPath, atomic_write};
use dpn_core::imu::Sensor;
use dpn_core::noise::{ImuNoise, NoiseTrack};
use dpn_core::time::Stamp;
use std::io;
use std::path::Path;

const TIME: &str = "timestamp";
const ACCEL: [&str; 3] = ["accel_std_x", "accel_std_y", "accel_std_z"];
const GYRO: [&str; 3] = ["gyro_std_x", "gyro_std_y", "gyro_std_z"];
const HEADER: &str = "#timestamp [ns],accel_std_x [m s^-2],accel_std_y [m s^-2],accel_std_z [m s^-2],\
    gyro_std_x [rad s^-1],gyro_std_y [rad s^-1],gyro_std_z [rad s^-1]";

/// Writes a noise track, all of it or nothing; every number comes back with the same bits.
///
/// # Errors
/// As [`atomic_write`].
pub fn write_noise_track(path: impl Into<ResultPath>, track: &NoiseTrack) -> Result<(), IoError> {
    let mut rows = track.stamps().iter().zip(track.noises());
    write_noise_rows(path, |row| rows.try_for_each(|(t, noise)| row(*t, noise)))
}

/// The same from rows that `rows` hands over as it goes through them, in increasing time.
///
/// # Errors
/// As [`atomic_write`], and those of `rows`.
pub fn write_noise_rows(
    path: impl Into<ResultPath>,
    rows: impl FnOnce(&mut dyn FnMut(Stamp, &ImuNoise) -> io::Result<()>) -> io::Result<()>,
) -> Result<(), IoError> {
    atomic_write(path, |out| {
        writeln!(out, "{HEADER}")?;
        rows(&mut |t, noise| {
            let ([ax, ay, az], [gx, gy, gz]) = (noise.of(Sensor::Accel), noise.of(Sensor::Gyro));
            writeln!(out, "{},{ax:?},{ay:?},{az:?},{gx:?},{gy:?},{gz:?}", t.ns())
        })
    })
}

/// Reads a noise track.
///
/// # Errors
/// A file that cannot be read or holds no row; no header or a column it does not name; a row that holds what is no finite number, or
/// a negative deviation; stamps that do not increase.
pub fn read_noise_track(path: &Path) -> Result<NoiseTrack, IoError> {
    let bytes = std::fs::read(path).map_err(|e| IoError::reading(path, e))?;
    parse(&bytes, path)
}

/// The same from bytes at hand; `path` is for messages.
pub(crate) fn parse(bytes: &[u8], path: &Path) -> Result<NoiseTrack, IoError> {
    let mut rows = Rows::open(bytes, path)?;
    let Some(header) = rows.header() else {
        return Err(rows.unknown_layout("a header with timestamp, accel_std_x to _z and gyro_std_x to _z"));
    };
    let column = |name: &str| {
        let is_it = |n: &String| n.split('[').next().map(str::trim) == Some(name);
        header.names.iter().position(is_it).ok_or_else(|| missing(header, path, name))
    };
    let time = column(TIME)?;
    let [ax, ay, az] = ACCEL;
    let accel_at = [column(ax)?, column(ay)?, column(az)?];
    let [gx, gy, gz] = GYRO;
    let gyro_at = [column(gx)?, column(gy)?, column(gz)?];

    let mut stamps: Vec<Stamp> = Vec::with_capacity(rows.rows_left());
    let mut noises = Vec::with_capacity(rows.rows_left());
    while rows.advance()? {
        stamps.push(rows.stamp_after(stamps.last().copied(), time, TimeUnit::Nanos)?);
        let accel = rows.numbers(accel_at, ACCEL)?;
        let gyro = rows.numbers(gyro_at, GYRO)?;
        noises.push(ImuNoise::from_values(accel, gyro).map_err(|bad| {
            let named = ACCEL.iter().zip(accel).chain(GYRO.iter().zip(gyro));
            let column = named.into_iter().find(|(_, value)| *value == bad.0);
            let column = column.map(|(name, _)| (*name).to_owned());
            let column = column.expect("the refused value is one of this row's");
            rows.fault(RowFault::BadNoise { column, value: bad.0 })
        })?);
    }
    Ok(NoiseTrack::new(stamps, noises).expect("order was checked row by row, and a row has one of each"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn error(text: &str) -> String {
        parse(text.as_bytes(), Path::new("n.csv")).unwrap_err().to_string()
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_back_bit_by_bit(
            start in -1i64 << 62..1 << 62,
            rows in prop::collection::vec((1i64..1 << 40, prop::array::uniform6(0.0f64..2.0)), 1..20),
        ) {
            let mut t = start;
            let (mut stamps, mut noises) = (Vec::new(), Vec::new());
            for (step, [a, b, c, d, e, f]) in rows {
                t += step;
                stamps.push(Stamp::from_ns(t));
                noises.push(ImuNoise::from_values([a, b, c], [d * 1e-12, e, f]).unwrap());
            }
            let track = NoiseTrack::new(stamps, noises).unwrap();
            let dir = tempfile::tempdir().unwrap();
            let path = dir.path().join("n.csv");
            write_noise_track(&path, &track).unwrap();
            prop_assert_eq!(read_noise_track(&path).unwrap(), track);
        }
    }

    #[test]
    fn a_missing_header_column_or_a_negative_deviation_is_named() {
        assert!(error("1,2,3,4,5,6,7\n").starts_with("n.csv:1: 7 columns; a header with"));
        assert!(
            error(&format!("{}\n1,2,3,4,5,6,7\n", HEADER.replace("gyro_std_y", "other")))
                .starts_with("n.csv:1: no column `gyro_std_y`")
        );
        assert_eq!(
            error(&format!("{HEADER}\n1,2,3,4,5,6,7\n2,2,3,4,5,-6,7\n")),
            "n.csv:3: gyro_std_y is -6; a noise figure is not negative"
        );
    }
}
