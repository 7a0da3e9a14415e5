//! An archive of one log, as phones share it: a file for each sensor, or one file of any kind.
//!
//! Its tables are laid down in a temporary folder and read as that of a phone; a single file is read as it comes. What comes out is held to
//! the [`Budget`] of everything that is packed.

use crate::budget::Budget;
use crate::topics::shortened;
use crate::two_files::{TwoFiles, is_table};
use crate::{Log, LogError, LogOptions};
use dpn_io::{IoError, printable};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use zip::ZipArchive;
use zip::result::ZipError;

/// Reads the log in the archive `file`, which lies at `path`; a single file in it by `read_stream`, a phone's by `read_tables`.
///
/// # Errors
/// An archive that is cut off, damaged, or encrypted; one that unpacks to too much; no log in it, or several.
pub(crate) fn read(
    file: File,
    path: &Path,
    options: &LogOptions,
    read_stream: &dyn Fn(&mut dyn Read, &Path) -> Result<Log, LogError>,
    read_tables: &dyn Fn(TwoFiles) -> Result<Log, LogError>,
) -> Result<Log, LogError> {
    let reading = |e| IoError::reading(path, e);
    let damaged = |what: String| LogError::Damaged { path: path.to_owned(), what };
    let of_zip = |e: ZipError| damaged(format!("a zip archive that cannot be read: {e}"));
    let mut budget = Budget::new(options.max_uncompressed);
    let mut left = budget.open(file.metadata().map_err(reading)?.len() as usize);
    let mut archive = ZipArchive::new(file).map_err(of_zip)?;

    let mut files: Vec<(usize, PathBuf)> = Vec::new();
    for at in 0..archive.len() {
        let entry = archive.by_index_raw(at).map_err(of_zip)?;
        // A name that leads out of the folder is none; neither is what a file system keeps for itself.
        if let Some(name) = entry.enclosed_name().filter(|name| entry.is_file() && !is_hidden(name)) {
            files.push((at, name));
        }
    }
    let dir = tempfile::tempdir().map_err(|e| IoError::reading(&std::env::temp_dir(), e))?;
    for (at, name) in files.iter().filter(|(_, name)| is_table(name)) {
        let to = dir.path().join(name.file_name().expect("a file has a name"));
        let mut out = File::create(&to).map_err(|e| IoError::reading(&to, e))?;
        let entry = archive.by_index(*at).map_err(of_zip)?;
        let laid = io::copy(&mut entry.take(left.saturating_add(1)), &mut out).map_err(|e| {
            damaged(format!("`{}` in it is damaged: {e}", printable(&name.to_string_lossy())))
        })?;
        budget.unpacked(laid as usize);
        left = left.checked_sub(laid).ok_or_else(|| damaged(budget.exceeded()))?;
    }
    if let Some(tables) = TwoFiles::find(dir.path())? {
        return read_tables(tables.shown_in(path));
    }
    match files.as_slice() {
        [(at, name)] => {
            let mut entry = archive.by_index(*at).map_err(of_zip)?.take(left.saturating_add(1));
            let log = read_stream(&mut entry, &path.join(name));
            if entry.limit() == 0 { Err(damaged(budget.exceeded())) } else { log }
        }
        [] => Err(damaged("a zip archive without a file".to_owned())),
        several => Err(LogError::SeveralInZip {
            path: path.to_owned(),
            count: several.len(),
            names: shortened(several.iter().map(|(_, name)| printable(&name.to_string_lossy()))),
        }),
    }
}

fn is_hidden(name: &Path) -> bool {
    name.components().any(|part| {
        let part = part.as_os_str().to_string_lossy();
        part.starts_with('.') || part == "__MACOSX"
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Kind, read_log, read_stream};
    use dpn_core::Samples;
    use std::fmt::Write as _;
    use std::io::Write as _;
    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    fn zipped(dir: &Path, files: &[(&str, &[u8])]) -> PathBuf {
        let path = dir.join("log.zip");
        let mut zip = ZipWriter::new(File::create(&path).unwrap());
        for (name, bytes) in files {
            zip.start_file(*name, SimpleFileOptions::default()).unwrap();
            zip.write_all(bytes).unwrap();
        }
        zip.finish().unwrap();
        path
    }

    /// phyphox' table of one sensor.
    fn table(unit: &str, z: f64) -> Vec<u8> {
        let mut text = format!("\"Time (s)\",\"X ({unit})\",\"Y ({unit})\",\"Z ({unit})\"\n");
        for i in 0..200 {
            writeln!(text, "{:.4},{},0.02,{z}", 0.01 * f64::from(i), 0.01 * f64::from(i % 7)).unwrap();
        }
        text.into_bytes()
    }

    fn error(path: &Path, options: &LogOptions) -> String {
        read_log(path, options).unwrap_err().to_string()
    }

    #[test]
    fn a_phones_archive_is_its_folder() {
        let dir = tempfile::tempdir().unwrap();
        let [gyro, accel] = [table("rad/s", 0.0), table("m/s^2", 9.8)];
        let files: [(&str, &[u8]); 5] = [
            ("run/Gyroscope.csv", &gyro),
            ("run/Accelerometer.csv", &accel),
            ("run/meta/device.csv", b"property,value\nbrand,x\n"),
            ("__MACOSX/run/._Gyroscope.csv", b"\0\0"),
            ("../Gyroscope.csv", b"outside"),
        ];
        let log = read_log(&zipped(dir.path(), &files), &LogOptions::default()).unwrap();
        let folder = dir.path().join("folder");
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(folder.join("Gyroscope.csv"), &gyro).unwrap();
        std::fs::write(folder.join("Accelerometer.csv"), &accel).unwrap();
        let unpacked = read_log(&folder, &LogOptions::default()).unwrap();
        assert_eq!((log.kind, log.recording.len()), (Kind::TwoFiles, 200));
        assert_eq!(log.guesses, unpacked.guesses);
        assert_eq!(log.recording.all().unwrap(), unpacked.recording.all().unwrap());
    }

    #[test]
    fn one_file_of_any_kind_is_read_and_several_are_named() {
        let dir = tempfile::tempdir().unwrap();
        let mut text = "t,gx,gy,gz,ax,ay,az\n".to_owned();
        (0..50).for_each(|i| {
            writeln!(text, "{},0.01,0.02,0.03,0.1,0.2,9.8", 1_000_000_000u64 + 5_000_000 * i).unwrap();
        });
        let log =
            read_log(&zipped(dir.path(), &[("imu.csv", text.as_bytes())]), &LogOptions::default()).unwrap();
        assert_eq!((log.kind, log.recording.len()), (Kind::Csv, 50));
        let both = zipped(dir.path(), &[("a.csv", text.as_bytes()), ("b.csv", text.as_bytes())]);
        assert!(
            error(&both, &LogOptions::default())
                .ends_with("2 files in a zip archive, and none is a phone's: a.csv, b.csv")
        );
        assert!(
            error(&zipped(dir.path(), &[]), &LogOptions::default()).ends_with("a zip archive without a file")
        );
    }

    #[test]
    fn a_faulty_archive_is_named_with_its_fault() {
        let dir = tempfile::tempdir().unwrap();
        let [gyro, accel] = [table("rad/s", 0.0), table("m/s^2", 9.8)];
        let path = zipped(dir.path(), &[("Gyroscope.csv", &gyro), ("Accelerometer.csv", &accel)]);
        let whole = std::fs::read(&path).unwrap();
        for cut in [30, whole.len() / 2, whole.len() - 8] {
            std::fs::write(&path, &whole[..cut]).unwrap();
            assert!(
                error(&path, &LogOptions::default()).contains("a zip archive that cannot be read"),
                "{cut}"
            );
        }
        let mut bad = whole.clone();
        bad[60..90].fill(0xff);
        std::fs::write(&path, &bad).unwrap();
        assert!(error(&path, &LogOptions::default()).contains("`Gyroscope.csv` in it is damaged"));
        let bomb =
            zipped(dir.path(), &[("Gyroscope.csv", &vec![b' '; 40 << 20]), ("Accelerometer.csv", &accel)]);
        assert!(error(&bomb, &LogOptions::default()).contains("unpacks to more than"));
        // What cannot be sought in is not copied behind the caller's back.
        let stream = read_stream(whole.as_slice(), Path::new("stdin"), &LogOptions::default()).unwrap_err();
        assert!(stream.to_string().contains("stdin: a zip archive"), "{stream}");
    }
}
