//! What small files may do to the machine: memory at most 64 MB and 40 times the bytes read, unpacked where they are packed, and seconds.
//!
//! One test, one case after the other, so that the allocator counts one case alone. Files are made here: each shows what once took all memory
//! or minutes, or is made to.
#![allow(clippy::unwrap_used)]

use dpn_core::estimate::NoiseSpec;
use dpn_io::asl::Sequence;
use dpn_io::noise_formats::{self, Given};
use dpn_io::{CsvOptions, ImuLines, parse_png, read_noise_track, read_tracks, read_tum};
use dpn_logs::{Log, LogOptions, read_stream};
use dpn_probe::allan::AllanLog;
use dpn_probe::doctor::examine_log;
use dpn_probe::log_noise::{Levels, Plan, TrackSummary, report, track};
use dpn_probe::phases::phases;
use peak_alloc::PeakAlloc;
use std::io::{self, Read};
use std::path::Path;
use std::time::{Duration, Instant};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

const ALWAYS: usize = 64 << 20;
const TIMES: usize = 40;
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
        let (before, start) = (ALLOCATOR.current_usage(), Instant::now());
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
                all(&log);
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
fn all(log: &Log) {
    let said = serde_json::to_string(&examine_log(log)).unwrap();
    let said = said.replace("with NaN or infinite values", "");
    assert!(!said.contains("inf ") && !said.contains("NaN"), "{said}");
    let recording = &log.recording;
    let stretches = phases(recording);
    let _ = Levels::of(recording, &stretches);
    for spec in ["diff2", "allan", "sg(51,3)", "kalman", "running", "sliding(1000000000)", "sg(999999,3)"] {
        let spec: NoiseSpec = spec.parse().unwrap();
        let Ok(plan) = Plan::new(&spec, recording.rate(), 10, &[]) else { continue };
        let track = track(&plan, recording).unwrap();
        let summary = TrackSummary::of(&track, recording, stretches.clone(), plan.unknown_s());
        report::page(&plan, &summary, recording.rate());
    }
    for everything in [false, true] {
        if let Err(error) = AllanLog::of(recording, everything) {
            assert!(!error.to_string().contains("fault of the program"), "{error}");
        }
    }
}

/// A CSV log of `count` rows by stamp and value.
fn rows(count: usize, t: impl Fn(usize) -> i64, v: impl Fn(usize) -> String) -> Vec<u8> {
    let mut text = String::from("t_ns,gx,gy,gz,ax,ay,az\n");
    for i in 0..count {
        text.push_str(&format!("{},{}\n", t(i), v(i)));
    }
    text.into_bytes()
}

/// Some noise, the same each time.
fn still(i: usize) -> String {
    let noise = |k: usize| {
        (i.wrapping_mul(2_654_435_761).wrapping_add(k * 40_503) >> 7) as f64 % 1000.0 / 1000.0 - 0.5
    };
    let n: [f64; 6] = std::array::from_fn(noise);
    format!(
        "{:.5},{:.5},{:.5},{:.4},{:.4},{:.4}",
        0.004 * n[0],
        0.004 * n[1],
        0.004 * n[2],
        0.1 * n[3],
        0.1 * n[4],
        9.81 + 0.1 * n[5]
    )
}

fn logs(judge: &mut Judge) {
    let options = LogOptions::default();
    let mut log = |name: &str, bytes: Vec<u8>| judge.log(name, &bytes, &options);
    // What a wrong unit of time makes of a log: the rate says nothing of how much there is.
    for (name, count, step) in [
        ("100 rows 1 ns apart", 100, 1),
        ("50,000 rows 1 ns apart", 50_000, 1),
        ("50,000 rows 1 us apart", 50_000, 1000),
        ("100,000 rows at 32 kHz", 100_000, 31_250),
        ("50,000 rows at 4 kHz", 50_000, 250_000),
        ("20,000 rows at 200 Hz", 20_000, 5_000_000),
        ("2000 rows a minute apart", 2000, 60_000_000_000),
        ("200 rows a year apart", 200, 31_557_600_000_000_000),
    ] {
        log(name, rows(count, |i| i as i64 * step, still));
    }
    log("stamps that repeat", rows(50_000, |_| 5, still));
    log("stamps that go back", rows(50_000, |i| -(i as i64), still));
    log(
        "a first stamp of 976",
        rows(5000, |i| if i == 0 { 976 } else { 1_403_715_285_000_000_000 + i as i64 * 5_000_000 }, still),
    );
    log("a dead sensor", rows(5000, |i| i as i64 * 5_000_000, |_| "0,0,0,0,0,9.81".to_owned()));
    for value in ["1e308", "1e30", "1e-300", "5e-324", "nan", "0", "16384", "1e11"] {
        let all = [value; 6].join(",");
        log(&format!("nothing but {value}"), rows(5000, |i| i as i64 * 5_000_000, |_| all.clone()));
        let turns =
            |i: usize| if i.is_multiple_of(2) { all.clone() } else { format!("-{}", [value; 6].join(",-")) };
        log(&format!("{value} by turns"), rows(5000, |i| i as i64 * 5_000_000, turns));
        let one = |i: usize| if i == 2500 { all.clone() } else { still(i) };
        log(&format!("one sample of {value}"), rows(5000, |i| i as i64 * 5_000_000, one));
    }
    // Shapes.
    log("nothing", Vec::new());
    log("a line's end", b"\n".to_vec());
    log("a mark of order", b"\xef\xbb\xbf".to_vec());
    log("zeros", vec![0; 1 << 20]);
    log("line ends", vec![b'\n'; 4 << 20]);
    log("one column", b"1\n".repeat(1 << 20));
    log("a line of delimiters", vec![b','; 8 << 20]);
    log("a line of blanks and digits", b"1 ".repeat(4 << 20));
    log("a line of digits", vec![b'7'; 8 << 20]);
    log("a header of a million names", [b"t,".repeat(1 << 20), b"\n1,2\n".to_vec()].concat());
    log("a million comments", b"#t,x\n".repeat(1 << 20));
    log("quotes", b"\"\",".repeat(1 << 20));
    judge.case("a million comments, line by line", 5 << 20, || {
        let mut lines = ImuLines::new(Path::new("stdin"), CsvOptions::default());
        for _ in 0..1 << 20 {
            let _ = lines.push(b"#t,x\n");
        }
    });
}

/// A record of an MCAP file.
fn record(op: u8, content: &[u8]) -> Vec<u8> {
    [&[op][..], &(content.len() as u64).to_le_bytes(), content].concat()
}

fn counted(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
}

fn mcap(records: &[Vec<u8>]) -> Vec<u8> {
    [b"\x89MCAP0\r\n".to_vec(), records.concat()].concat()
}

/// A chunk that says it unpacks to a gigabyte.
fn chunk(compression: &str, packed: &[u8]) -> Vec<u8> {
    let head = [vec![0; 16], (1u64 << 30).to_le_bytes().to_vec(), vec![0; 4], counted(compression)].concat();
    record(6, &[head, (packed.len() as u64).to_le_bytes().to_vec(), packed.to_vec()].concat())
}

/// Forty million zeros, as bz2 packs them.
const ZEROS: [u8; 51] = [
    0x42, 0x5a, 0x68, 0x39, 0x31, 0x41, 0x59, 0x26, 0x53, 0x59, 0xd8, 0xec, 0xdd, 0xfe, 0x01, 0x32, 0x5f,
    0x40, 0x08, 0xc0, 0x00, 0x00, 0x10, 0x00, 0x08, 0x20, 0x00, 0x30, 0xcc, 0x09, 0xaa, 0x69, 0xa0, 0x4a,
    0x51, 0x5b, 0x50, 0x12, 0x94, 0x57, 0x8b, 0xb9, 0x22, 0x9c, 0x28, 0x48, 0x6c, 0x76, 0x6e, 0xff, 0x00,
];

fn bags(judge: &mut Judge) {
    let options = LogOptions::default();
    let field = |name: &str, value: &[u8]| {
        let text = [name.as_bytes(), b"=", value].concat();
        [(text.len() as u32).to_le_bytes().to_vec(), text].concat()
    };
    let ros1 = |fields: &[Vec<u8>], data: &[u8]| {
        let header = fields.concat();
        [
            (header.len() as u32).to_le_bytes().to_vec(),
            header,
            (data.len() as u32).to_le_bytes().to_vec(),
            data.to_vec(),
        ]
        .concat()
    };
    let bomb = ros1(
        &[field("op", &[5]), field("compression", b"bz2"), field("size", &(1u32 << 30).to_le_bytes())],
        &ZEROS.repeat(25),
    );
    judge.log("a bz2 bag of a gigabyte", &[b"#ROSBAG V2.0\n".to_vec(), bomb.clone()].concat(), &options);
    judge.log(
        "a bz2 bag of twenty gigabytes",
        &[b"#ROSBAG V2.0\n".to_vec(), bomb.repeat(20)].concat(),
        &options,
    );
    judge.log(
        "a header of four gigabytes",
        &[b"#ROSBAG V2.0\n".to_vec(), vec![0xff; 100]].concat(),
        &options,
    );
    judge.log("an MCAP record of many gigabytes", &mcap(&[[&[6][..], &[0xff; 7], &[0]].concat()]), &options);
    // A window of 64 MB, then blocks that each repeat a byte 128,000 times.
    let blocks = [0x02u8, 0x00, 0x10, 0x00].repeat(8000);
    let zstd = [b"\x28\xb5\x2f\xfd\x00\x80".to_vec(), blocks].concat();
    judge.log("an MCAP of a zstd bomb", &mcap(&[chunk("zstd", &zstd)]), &options);
    judge.log("an MCAP of a bz2 bomb", &mcap(&[chunk("bz2", &ZEROS.repeat(25))]), &options);
    judge.log(
        "chunks that say a gigabyte and hold nothing",
        &mcap(&vec![chunk("lz4", b"\x04\x22\x4d\x18"); 20_000]),
        &options,
    );
    let imu = record(
        3,
        &[1u16.to_le_bytes().to_vec(), counted("sensor_msgs/msg/Imu"), counted(""), counted("")].concat(),
    );
    let channels = (0..150_000u32).map(|i| {
        let number = (i as u16).to_le_bytes().to_vec();
        record(
            4,
            &[number, 1u16.to_le_bytes().to_vec(), counted(&format!("/{i}")), counted("cdr"), vec![0; 4]]
                .concat(),
        )
    });
    let many = mcap(&[vec![imu], channels.collect()].concat());
    judge.log("an MCAP of 150,000 channels", &many, &options);
    let wanted = LogOptions { topic: Some("/150001".to_owned()), ..options.clone() };
    judge.log("a topic that is none of 150,000", &many, &wanted);
}

fn configurations(judge: &mut Judge) {
    let given = Given::default();
    let laughs = (1..12).map(|i| {
        let before = (b'a' + i - 1) as char;
        format!(
            "{}: &{} [{}]\n",
            (b'a' + i) as char,
            (b'a' + i) as char,
            vec![format!("*{before}"); 9].join(",")
        )
    });
    for (name, text) in [
        ("deep lists", "[".repeat(100_000)),
        ("deep blocks", (0..2000).map(|i| format!("{}a:\n", " ".repeat(i))).collect()),
        ("deep braces", "{a: ".repeat(100_000)),
        ("a billion laughs", format!("a: &a [1,1,1,1,1,1,1,1,1]\n{}", laughs.collect::<String>())),
        ("a long list", format!("acc_n: [{}1]\n", "1,".repeat(1 << 20))),
        ("many keys", (0..200_000).map(|i| format!("k{i}: 1\n")).collect()),
        ("many documents", "---\na: 1\n".repeat(100_000)),
        ("a long word", "a".repeat(3 << 20)),
        ("directives", "%\n".repeat(1 << 20)),
        ("too much", "a: 1\n".repeat(4 << 20)),
    ] {
        judge.file(&format!("YAML: {name}"), text.as_bytes(), |path| {
            let _ = noise_formats::read(path, None, &given);
        });
        judge.case(&format!("YAML of a camera: {name}"), text.len(), || {
            let dir = tempfile::tempdir().unwrap();
            for (file, text) in
                [("imu0/data.csv", ""), ("imu0/sensor.yaml", &text), ("cam0/sensor.yaml", &text)]
            {
                let path = dir.path().join(file);
                std::fs::create_dir_all(path.parent().unwrap()).unwrap();
                std::fs::write(path, text).unwrap();
            }
            let sequence = Sequence::open(dir.path()).unwrap();
            let _ = (sequence.camera_config(), sequence.imu_config());
        });
    }
}

fn tables(judge: &mut Judge) {
    let tracks = |n: usize| (0..n).map(|id| format!(" {id} 1 2")).collect::<String>();
    let frames: String = (0..20).map(|t| format!("{t} 20000{}\n", tracks(20_000))).collect();
    judge.file("20,000 tracks a frame", frames.as_bytes(), |path| assert!(read_tracks(path).is_err()));
    let empty: String = (0..500_000).map(|t| format!("{t} 0\n")).collect();
    judge.file("half a million frames of nothing", empty.as_bytes(), |path| {
        let _ = read_tracks(path);
    });
    judge.file("a frame of a million numbers", format!("1 9{}", " 1".repeat(1 << 20)).as_bytes(), |path| {
        let _ = read_tracks(path);
    });
    for (name, text) in [
        ("a short first row", format!("1\n{}", "22,333\n".repeat(500_000))),
        ("delimiters", ",".repeat(4 << 20)),
    ] {
        judge.file(&format!("noise: {name}"), text.as_bytes(), |path| drop(read_noise_track(path)));
        judge.file(&format!("trajectory: {name}"), text.as_bytes(), |path| drop(read_tum(path)));
    }
    let stamps: String = (0..500_000).map(|t| format!("{t}\n")).collect();
    judge.case("stamps of half a million images", stamps.len(), || {
        let dir = tempfile::tempdir().unwrap();
        for (file, text) in [("imu0/data.csv", ""), ("cam0/data.csv", &stamps)] {
            let path = dir.path().join(file);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        drop(Sequence::open(dir.path()).unwrap().camera_frames());
    });
}

fn images(judge: &mut Judge) {
    // A head that says 65535 x 65535 grey pixels of 8 bits, and nothing behind it.
    let giant = b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\xff\xff\0\0\xff\xff\x08\0\0\0\0\x0c\xe5\x3a\x51\0\0\0\x02IDAT\x78\x9c";
    for size in [[752, 480], [65535, 65535]] {
        judge.case("a head of a giant image", giant.len(), || {
            assert!(parse_png(giant, Path::new("a.png"), size).is_err());
        });
    }
}

#[test]
fn no_file_takes_more_than_64_mb_and_40_times_its_bytes() {
    let mut judge = Judge::default();
    logs(&mut judge);
    bags(&mut judge);
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
