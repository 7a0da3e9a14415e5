//! The hostile set: files by what reads them.

use crate::judge::Case;
use dpn_testing::forged::{self, Forged};
use dpn_testing::{files, repository};
use std::fs;
use std::path::Path;
use std::sync::Arc;

/// The excerpt that folders are made of: four seconds of a sequence.
const EXCERPT: &str = "tests/data/euroc/V1_01_easy";
const ON_LOGS: [&str; 4] = [
    "check LOG --out out",
    "noise LOG --out out",
    "noise LOG --noise diff2 --every 1 --out out",
    "allan LOG --all --out out",
];
const ON_FOLDERS: [&str; 4] = [
    "check seq --out out",
    "run seq --noise x4 --out out",
    "eval --closed-loop --data seq --noise x4 --threads 2 --out out",
    "eval --open-loop --data seq --bases sg(11,2) --sensor accel --out out",
];

/// Every case whose file has at most so many bytes.
pub(crate) fn all(most: usize) -> Vec<Case> {
    let mut set = Set { most, cases: Vec::new() };
    set.logs();
    set.folders();
    set.settings();
    set.beside_a_run();
    set.trained();
    set.cases
}

struct Set {
    most: usize,
    cases: Vec<Case>,
}

impl Set {
    /// Commands on a file of that name, beside what `more` puts there.
    fn add(&mut self, file: Forged, name: &str, commands: &[&str], more: fn(&Path)) {
        // What is too large for the short test is not even made there twice.
        if self.most < usize::MAX && file.bytes().len() > self.most {
            return;
        }
        let (name, described) = (name.to_owned(), format!("{name}, {}", file.name));
        let prepare = move |dir: &Path| {
            more(dir);
            put(&dir.join(&name), &file.bytes());
        };
        let commands = commands.iter().map(|line| (*line).to_owned()).collect();
        self.cases.push(Case { name: described, prepare: Box::new(prepare), commands });
    }

    fn logs(&mut self) {
        let mut on = |file, name: &str| {
            let lines = ON_LOGS.map(|line| line.replace("LOG", name));
            self.add(file, name, &lines.each_ref().map(String::as_str), |_| {});
        };
        forged::logs().into_iter().chain(forged::large_logs()).for_each(|log| on(log, "log.csv"));
        forged::tables().into_iter().for_each(|table| on(table, "table.csv"));
        for (bag, ending) in forged::bags() {
            on(bag, &format!("bag.{ending}"));
        }
    }

    /// The excerpt with one file replaced.
    fn folders(&mut self) {
        for log in forged::logs() {
            // What nothing is wrong with takes as long as its windows take to fit.
            let good = log.name.ends_with("at 200 Hz");
            let commands = if good { &ON_FOLDERS[..3] } else { &ON_FOLDERS };
            self.add(log, "seq/mav0/imu0/data.csv", commands, excerpt);
        }
        for text in forged::yaml() {
            self.add(text, "seq/mav0/cam0/sensor.yaml", &ON_FOLDERS[1..3], excerpt);
        }
        for text in forged::yaml() {
            self.add(text, "seq/mav0/imu0/sensor.yaml", &ON_FOLDERS[..2], excerpt);
        }
        for table in forged::tables() {
            self.add(table, "seq/mav0/cam0/data.csv", &ON_FOLDERS[1..3], excerpt);
        }
        for table in forged::tables() {
            let truth = "seq/mav0/state_groundtruth_estimate0/data.csv";
            self.add(table, truth, &ON_FOLDERS[1..3], excerpt);
        }
        for image in forged::images() {
            self.add(
                image,
                "seq/mav0/cam0/data/1403715278262142976.png",
                &["run seq --noise x4 --out out"],
                excerpt,
            );
        }
    }

    fn settings(&mut self) {
        let convert =
            ["noise convert --to kalibr config.yaml", "noise convert --from vins --to kalibr config.yaml"];
        for text in forged::yaml() {
            self.add(text, "config.yaml", &convert, |_| {});
        }
        let reads = [
            "run hover --from 95 --noise x4 --out out --config config.toml",
            "run hover --from 95 --noise x4 --out out --tracks-config config.toml",
            "run hover --from 95 --noise x4 --out out --camera rendered --images-config config.toml",
            "simulate flight hover --out out --config config.toml",
            "train --sensor accel --data seq --epochs 1 --out out --config config.toml",
            "paper --plan config.toml --sequences hover --from 95 --out out --work work",
        ];
        for text in forged::toml() {
            self.add(text, "config.toml", &reads, excerpt);
        }
        // Values that are of the right kind and mean too much.
        for (line, text) in [(0, RUN), (1, TRACKS), (2, IMAGES), (3, FLIGHT), (4, TRAIN), (5, PLAN)]
            .into_iter()
            .flat_map(|(command, texts)| texts.iter().map(move |text| (reads[command], *text)))
        {
            let file = Forged::new(text.replace('\n', " "), move || text.as_bytes().to_vec());
            self.add(file, "config.toml", &[line], excerpt);
        }
    }

    /// Tracks and noise that a run is given.
    fn beside_a_run(&mut self) {
        for table in forged::tables() {
            self.add(table, "tracks.txt", &["run seq --noise x4 --tracks tracks.txt --out out"], excerpt);
        }
        let noises = [
            "run seq --noise file(\"noise.csv\") --out out",
            "eval --closed-loop --data seq --noise file(\"noise.csv\") --threads 2 --out out",
        ];
        for table in forged::tables() {
            self.add(table, "noise.csv", &noises, excerpt);
        }
        for log in forged::logs().into_iter().take(6) {
            self.add(log, "noise.csv", &noises[..1], excerpt);
        }
    }

    /// Weights and checkpoints.
    fn trained(&mut self) {
        let weights = Arc::new(fs::read(weights()).unwrap());
        let train = "train --sensor accel --data seq --epochs 2 --out out --resume";
        for (name, make) in forged::safetensors() {
            let whole = Arc::clone(&weights);
            let file = Forged::new(name, move || make(&whole));
            let lines = [
                "noise seq --weights models --out out",
                "run seq --noise dualpronet --models models --out out",
            ];
            self.add(file, "models/accel.safetensors", &lines, excerpt);
            let whole = Arc::clone(&weights);
            let file = Forged::new(name, move || make(&whole));
            self.add(file, "out/checkpoint.safetensors", &[train], |dir| {
                excerpt(dir);
                put(&dir.join("out/config.toml"), b"");
            });
        }
    }
}

/// Weights that come with the program.
fn weights() -> std::path::PathBuf {
    let mut all: Vec<_> =
        fs::read_dir(repository().join("models/accel")).unwrap().map(|e| e.unwrap().path()).collect();
    all.retain(|path| path.extension().is_some_and(|ending| ending == "safetensors"));
    all.sort();
    all.swap_remove(0)
}

pub(crate) fn put(path: &Path, bytes: &[u8]) {
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, bytes).unwrap();
}

/// The excerpt as `seq`.
pub(crate) fn excerpt(dir: &Path) {
    for (name, bytes) in files(&repository().join(EXCERPT)) {
        put(&dir.join("seq").join(name), &bytes);
    }
}

const RUN: &[&str] = &[
    "[window]\nkey_frames = 30\n[init]\nmax_frames = 60\n[front_end.corners]\nmost = 1000000",
    "[window]\nkey_frames = 18446744073709551615",
    "[window]\nmax_iterations = 4294967295",
    "[init]\nmax_frames = 60\nmax_span_s = 1e300",
    "[health]\nmax_imu_gap = 1e300\nmax_speed = 1e300",
    "[front_end.klt]\nwindow = 1000001\nlevels = 64",
    "[front_end]\nrate_hz = 1e-300",
    "[imu]\naccel_bias_walk = 1e300\ngyro_bias_walk = 1e300",
    "[window]\npixel_std = 1e-300",
];
const TRACKS: &[&str] = &[
    "max_tracks = 1000000000\nspacing_px = 0.0",
    "max_tracks = 1000000000\nspacing_px = 1e-9",
    "rate_hz = 1e12",
    "rate_hz = 1e-300",
    "pixel_noise_px = 1e300",
    "life_time_s = 1e-300",
    "largest_motion_px = 1e300\nlongest_blind_s = 1e300",
    "[path]\nsmoothing_s = 1e300\nlongest_gap_s = 1e300",
    "[camera]\nresolution = [65535, 65535]\nintrinsics = [1.0, 1.0, 1.0, 1.0]\ndistortion = [0.0, 0.0, 0.0, 0.0, 0.0]\nbody_from_cam = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]",
];
const IMAGES: &[&str] = &[
    "[camera]\nresolution = [65535, 65535]\nintrinsics = [1.0, 1.0, 1.0, 1.0]\ndistortion = [0.0, 0.0, 0.0, 0.0, 0.0]\nbody_from_cam = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]",
    "[camera]\nresolution = [1, 1]\nintrinsics = [1.0, 1.0, 1.0, 1.0]\ndistortion = [0.0, 0.0, 0.0, 0.0, 0.0]\nbody_from_cam = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]",
    "[lens]\nblur_px = 1e9",
    "[motion_blur]\nexposure_s = 1e9\nmost_instants = 1000000000",
    "[sensor]\nread_grey = 1e300\nshot_grey = 1e300",
    "contrast = 1e300",
    "[exposure]\nchange_every_s = 1e-300",
    "[low_light]\nshare = 1.0\nlength_s = 1e-300",
];
const FLIGHT: &[&str] = &[
    "rate_hz = 1e12",
    "epoch_ns = 9223372036854775807",
    "epoch_ns = -9223372036854775808",
    "[vibration]\nscale = 1e300",
];
const TRAIN: &[&str] = &[
    "[fit]\nbatch = 18446744073709551615",
    "[fit]\ndraws_per_window = 4294967295",
    "[network]\nchannels = [1000000, 1000000]\nkernels = [199, 199]\nstrides = [1, 1]\npaddings = [0, 0]",
    "[network]\nhidden = [1000000000]",
    "[network]\nhidden = [100000, 100000]",
    "[network]\nwindow = 1000000000",
    "[network]\nkernels = [4294967295, 5, 3]",
    "[network]\npaddings = [1000000000, 2, 1]",
    "[network]\nstrides = [0, 4, 2]",
    "[noise]\nsteps = 4294967295\nlow = 1e-300\nhigh = 1e300",
];
const PLAN: &[&str] = &[
    "seeds = 18446744073709551615",
    "seeds = 1000000",
    "seed = 18446744073709551615",
    "other_seeds = 100000000\nothers = [\"x1\"]",
    "bases = [\"sg(999999999,2)\"]",
    "noises = [\"sliding(18446744073709551615)\"]\nbases = [\"sg(11,2)\"]",
    "margin = 1e300\nnoises = []\nothers = []\nbases = []",
];
