//! What small files may do to the machine: memory at most 64 MB and 40 times the bytes read, unpacked where they are packed, and seconds.
//!
//! One test, one case after the other, so that the allocator counts one case alone. Files are made here: each shows what once took all memory
//! or minutes, or is made to.
#![allow(clippy::unwrap_used)]

use cpu_time::ProcessTime;
use dpn_core::Recorded;
use dpn_core::estimate::NoiseSpec;
use dpn_io::asl::Sequence;
use dpn_io::noise_formats::{self, Given};
use dpn_io::{CsvOptions, ImuLines, parse_image, read_noise_track, read_tracks, read_tum};
use dpn_logs::{Log, LogOptions, read_log, read_stream};
use dpn_probe::allan::AllanLog;
use dpn_probe::doctor::examine_log;
use dpn_probe::log_noise::{Levels, Plan, TrackSummary, report, track};
use dpn_probe::phases::phases;
use dpn_testing::forged;
use peak_alloc::PeakAlloc;
use std::io::{self, Read};
use std::path::Path;
use std::time::Duration;
use tempfile::TempDir;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

const ALWAYS: usize = 64 << 20;
const TIMES: usize = 40;
/// Of the processor, whatever else it does.
const LONGEST: Duration = Duration::from_secs(10);

/// Measures cases and keeps those beyond the budget.
#[derive(Default)]
struct Judge {
    faults: Vec<String>,
}

impl Judge {
    /// `read` bytes may be read in `work`.
    fn case(&mut self, name: &str, read: usize, work: impl FnOnce()) {
        ALLOCATOR.reset_peak_usage();
        let (before, start) = (ALLOCATOR.current_usage(), ProcessTime::now());
        work();
        let (peak, took) = (ALLOCATOR.peak_usage().saturating_sub(before), start.elapsed());
        let budget = ALWAYS + TIMES * read;
        println!("{name}: {} kB read, {} kB of {}, {took:.2?}", read >> 10, peak >> 10, budget >> 10);
        if peak > budget || took > LONGEST {
            self.faults.push(format!("{name}: {peak} bytes of {budget}, {took:.1?}"));
        }
    }

    /// A log of any kind through all that looks at one.
    fn log(&mut self, name: &str, bytes: &[u8], options: &LogOptions) {
        self.case(name, bytes.len(), || {
            if let Ok(log) = read_stream(bytes, Path::new("log"), options) {
                all(log);
            }
        });
    }

    fn file(&mut self, name: &str, bytes: &[u8], read: impl FnOnce(&Path)) {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("file");
        std::fs::write(&path, bytes).unwrap();
        self.case(name, bytes.len(), || read(&path));
    }
}

/// `dpn check`, `noise` by several estimators and `allan`, without their pictures.
fn all(log: Log) {
    let said = serde_json::to_string(&examine_log(&log).unwrap()).unwrap();
    let said = said.replace("with NaN or infinite values", "");
    assert!(!said.contains("inf ") && !said.contains("NaN"), "{said}");
    let recording = &log.recording;
    let stretches = phases(recording).unwrap();
    drop(Levels::of(recording, &stretches).unwrap());
    for spec in ["diff2", "allan", "sg(51,3)", "kalman", "running", "sliding(1000000000)", "sg(999999,3)"] {
        let spec: NoiseSpec = spec.parse().unwrap();
        let Ok(plan) = Plan::new(&spec, recording.rate(), 10, &[]) else { continue };
        let track = track(&plan, recording).unwrap();
        let summary = TrackSummary::of(&track, recording, stretches.clone(), plan.unknown_s()).unwrap();
        report::page(&plan, &summary, recording.rate());
    }
    let recording = log.recording.held().unwrap();
    for everything in [false, true] {
        if let Err(error) = AllanLog::of(&recording, everything) {
            assert!(!error.to_string().contains("fault of the program"), "{error}");
        }
    }
}

fn logs(judge: &mut Judge) {
    let options = LogOptions::default();
    for file in forged::logs().into_iter().chain(forged::bags().into_iter().map(|(bag, _)| bag)) {
        judge.log(&file.name, &file.bytes(), &options);
    }
    let long: String = (0..1 << 17).map(|i| format!("gyro,{i},1,2,3\naccel,{i},1,2,9\n")).collect();
    let cycles: String = (0..1i64 << 19).map(|i| format!("{},0,0,0,0,0,9.81\n", i * 7919 % 1009)).collect();
    for (name, text) in [
        ("a million objects of JSON", format!("[{}{{}}]", "{\"a\":1},".repeat(1 << 20))),
        ("a million arrays of JSON", format!("[{}[]]", "[1],".repeat(1 << 20))),
        (
            "objects of a sensor each",
            "{\"sensor\":\"gyro\",\"t\":1,\"x\":1,\"y\":2,\"z\":3}\n".repeat(1 << 17),
        ),
        ("a row a sensor", long),
        ("stamps in no order", cycles),
    ] {
        judge.log(name, text.as_bytes(), &options);
    }
    judge.case("a million comments, line by line", 5 << 20, || {
        let mut lines = ImuLines::new(Path::new("stdin"), CsvOptions::default());
        for _ in 0..1 << 20 {
            let _ = lines.push(b"#t,x\n");
        }
    });
    for (name, gyro, accel) in [
        ("two files of one time", 5_000_000, 5_000_000),
        ("two files, one 1 ns apart", 1, 5_000_000),
        ("two files of which none has time in common", 5_000_000, 60_000_000_000),
    ] {
        let table = |step: i64| {
            let row =
                |i: i64| format!("{},0.1,0.2,9.{}\n", 1_700_000_000_000_000_000 + i * step, i % 89 + 10);
            ["time,x,y,z\n".to_owned(), (0..40_000).map(row).collect()].concat().into_bytes()
        };
        let (gyro, accel) = (table(gyro), table(accel));
        let dir = folder(&[("Gyroscope.csv", &gyro), ("Accelerometer.csv", &accel)]);
        judge.case(name, gyro.len() + accel.len(), || {
            if let Ok(log) = read_log(dir.path(), &LogOptions::default()) {
                all(log);
            }
        });
    }
    let wanted = LogOptions { topic: Some("/150001".to_owned()), ..options };
    judge.log("a topic that is none of 150,000", &forged::many_channels(), &wanted);
}

/// A folder of a sequence that holds these files alone.
fn folder(files: &[(&str, &[u8])]) -> TempDir {
    let dir = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        let path = dir.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    dir
}

fn configurations(judge: &mut Judge) {
    for file in forged::yaml() {
        let (name, text) = (&file.name, file.bytes());
        judge.file(&format!("YAML: {name}"), &text, |path| {
            let _ = noise_formats::read(path, None, &Given::default());
        });
        judge.case(&format!("YAML of a camera: {name}"), text.len(), || {
            let dir =
                folder(&[("imu0/data.csv", b""), ("imu0/sensor.yaml", &text), ("cam0/sensor.yaml", &text)]);
            let sequence = Sequence::open(dir.path()).unwrap();
            let _ = (sequence.camera_config(), sequence.imu_config());
        });
    }
}

fn tables(judge: &mut Judge) {
    for file in forged::tables() {
        let (name, text) = (&file.name, file.bytes());
        judge.file(&format!("tracks: {name}"), &text, |path| {
            let read = read_tracks(path);
            assert!(read.is_err() || !name.starts_with("20,000 tracks"));
        });
        judge.file(&format!("noise: {name}"), &text, |path| drop(read_noise_track(path)));
        judge.file(&format!("trajectory: {name}"), &text, |path| drop(read_tum(path)));
        judge.case(&format!("list of images: {name}"), text.len(), || {
            let dir = folder(&[("imu0/data.csv", b""), ("cam0/data.csv", &text)]);
            drop(Sequence::open(dir.path()).unwrap().camera_frames());
        });
    }
}

fn images(judge: &mut Judge) {
    for size in [[752, 480], [65535, 65535]] {
        judge.case("a head of a giant image", forged::GIANT_PNG.len(), || {
            assert!(parse_image(forged::GIANT_PNG, Path::new("a.png"), size).is_err());
        });
        // Baseline and progressive: height and width stand five bytes behind their marker.
        for (file, marker) in [("0.jpg", 0xc0), ("1.jpg", 0xc2)] {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../golden/rigs/folder_jpeg/images");
            let mut giant = std::fs::read(folder.join(file)).unwrap();
            let at = giant.windows(2).position(|pair| pair == [0xff, marker]).unwrap();
            giant[at + 5..at + 9].fill(0xff);
            judge.case("a head of a giant JPEG", giant.len(), || {
                assert!(parse_image(&giant, Path::new("a.jpg"), size).is_err());
            });
        }
    }
}

#[test]
fn no_file_takes_more_than_64_mb_and_40_times_its_bytes() {
    let mut judge = Judge::default();
    logs(&mut judge);
    configurations(&mut judge);
    tables(&mut judge);
    images(&mut judge);
    // A source without an end is cut off too, where a whole file must be held.
    judge.case("a configuration without an end", 4 << 20, || {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("endless");
        let mut file = std::fs::File::create(&path).unwrap();
        io::copy(&mut io::repeat(b'#').take(64 << 20), &mut file).unwrap();
        assert!(noise_formats::read(&path, None, &Given::default()).is_err());
    });
    assert!(judge.faults.is_empty(), "beyond the budget:\n{}", judge.faults.join("\n"));
}
