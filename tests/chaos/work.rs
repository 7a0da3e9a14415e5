//! Small work of every kind that goes on where it was broken off, and what is compared of its results.

use dpn_testing::{cut_asl, files};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

/// A command and what it leaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Work {
    /// A network of a few hundred parameters on a still sensor.
    Train,
    /// Six runs over two seconds of a flight.
    Sweep,
    /// Estimators on a still sensor's windows.
    OpenLoop,
    /// Every table and figure, of some seconds of a flight.
    Paper,
    /// The noise along a log: no lock, and nothing to go on from.
    Noise,
}

/// As little as gives every table and figure.
const PLAN: &str = include_str!("../data/least_plan.toml");

/// A network of a few hundred parameters, whose epochs last long enough to be disturbed.
const NETWORK: &str = include_str!("../data/tiny_network.toml");
const LONG_EPOCHS: (&str, &str) = ("[fit]\n", "[fit]\ndraws_per_window = 150\n");

impl Work {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Train => "train",
            Self::Sweep => "sweep",
            Self::OpenLoop => "open loop",
            Self::Paper => "paper",
            Self::Noise => "noise",
        }
    }

    /// What is read, in `dir`.
    pub(crate) fn prepare(self, dir: &Path) {
        match self {
            Self::Train | Self::OpenLoop | Self::Noise => {
                for (name, seed) in [("still", 1), ("still-2", 2)] {
                    let imu = dir.join("log").join(name).join("mav0/imu0");
                    std::fs::create_dir_all(&imu).unwrap();
                    std::fs::write(imu.join("data.csv"), still(seed)).unwrap();
                }
                let network = NETWORK.replace(LONG_EPOCHS.0, LONG_EPOCHS.1);
                assert_ne!(network, NETWORK);
                std::fs::write(dir.join("network.toml"), network).unwrap();
            }
            Self::Sweep => {}
            Self::Paper => {
                std::fs::write(dir.join("plan.toml"), PLAN).unwrap();
                // The regressors of an open loop take long on a whole flight.
                let mut command = Command::new(env!("CARGO_BIN_EXE_dpn"));
                command.current_dir(dir).args(["simulate", "flight", "f07-room-medium", "--out", "data"]);
                assert!(command.output().unwrap().status.success());
                cut_asl(&dir.join("data"), 70.0, 85.0);
            }
        }
    }

    /// The arguments to call in `dir`, whatever was done there before.
    pub(crate) fn arguments(self, dir: &Path) -> Vec<&'static str> {
        let line = match self {
            Self::Train => "train --sensor accel --config network.toml --data log --epochs 12 --out out",
            Self::Sweep => {
                "eval --closed-loop --sequences room-medium --from 70 --to 72 --noise x4;diff2;shuffled(diff2) --seeds 2 \
                 --threads 2 --trajectories --set covariance=true --out out"
            }
            Self::OpenLoop => "eval --open-loop --data log --sensor accel --bases sg(11,2);sg(5,2) --out out",
            Self::Paper => {
                "paper --plan plan.toml --data data --camera tracks --from 10 --threads 2 --out out --work work"
            }
            Self::Noise => "noise log/still/mav0/imu0/data.csv --out out",
        };
        let mut words: Vec<&str> = line.split_whitespace().collect();
        if self == Self::Train && dir.join("out/config.toml").exists() {
            words.push("--resume");
        }
        words
    }

    /// The command.
    pub(crate) fn command(self, dir: &Path) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_dpn"));
        command.current_dir(dir).args(self.arguments(dir));
        command
    }

    /// Files of the results, without times.
    pub(crate) fn results(self, dir: &Path) -> BTreeMap<String, Vec<u8>> {
        let of = |folder: &'static str| {
            files(&dir.join(folder)).into_iter().map(move |(name, bytes)| (format!("{folder}/{name}"), bytes))
        };
        let mut all: BTreeMap<String, Vec<u8>> = of("out").collect();
        if self == Self::Paper {
            all.extend(of("work"));
        }
        all.retain(|name, _| self.lasts(name));
        for (name, bytes) in &mut all {
            if name.ends_with("rows.jsonl") {
                *bytes = without_times(bytes);
            }
        }
        all
    }

    /// Whether a file is the same in every run.
    fn lasts(self, name: &str) -> bool {
        let timed = name.starts_with("out/tables/timing")
            || name.contains("/timing-")
            || name.starts_with("out/closed_loop.");
        // The paper's page and its receipt hold the table of times, and their checksums.
        let pages = ["out/index.html", "out/README.md", "out/made.json", "run.json"]
            .iter()
            .any(|end| name.ends_with(end));
        !timed && !pages
    }
}

/// Rows without what differs from run to run.
fn without_times(rows: &[u8]) -> Vec<u8> {
    let mut text = String::new();
    for line in std::str::from_utf8(rows).unwrap().lines() {
        let mut row: serde_json::Value = serde_json::from_str(line).unwrap();
        for timing in ["cpu_per_data_s", "p95_update_ms", "stage_s"] {
            row.as_object_mut().unwrap().remove(timing).unwrap();
        }
        writeln!(text, "{row}").unwrap();
    }
    text.into_bytes()
}

/// A still, level IMU of 15 s as an ASL file.
fn still(seed: u64) -> String {
    let mut draw = dpn_testing::forged::Draw::new(seed, "still");
    let mut text = "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],\
                    a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n"
        .to_owned();
    for i in 0..3000_i64 {
        let mut noise = |size: f64| size * (draw.share() - 0.5);
        let [gx, gy, gz] = [(); 3].map(|()| noise(0.004));
        let [ax, ay, az] = [(); 3].map(|()| noise(0.05));
        let t = 1_400_000_000_000_000_000 + 5_000_000 * i;
        writeln!(text, "{t},{gx},{gy},{gz},{ax},{ay},{}", 9.81 + az).unwrap();
    }
    text
}
