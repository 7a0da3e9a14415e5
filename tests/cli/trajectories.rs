//! `dpn ape` and `dpn rpe`.

use crate::run::{Done, dpn, end, files, run};
use serde::Deserialize;
use std::fmt::Write;
use std::path::Path;

#[derive(Deserialize)]
struct Said {
    options: Vec<String>,
    count: usize,
    rmse: f64,
    mean: f64,
    median: f64,
    max: f64,
}

#[derive(Deserialize)]
struct Case {
    truth: Vec<String>,
    estimate: Vec<String>,
    ape: Said,
    rpe: Said,
}

#[derive(Deserialize)]
struct Golden {
    cases: Vec<Case>,
}

/// Both programs under all their options, a pair of trajectories each (`golden/evo/commands.py`).
#[test]
fn errors_are_evos_under_every_option() {
    let golden = dpn_testing::repository().join("golden/evo/commands.json");
    let golden: Golden = serde_json::from_slice(&std::fs::read(golden).unwrap()).unwrap();
    assert_eq!(golden.cases.len(), 20);
    let dir = tempfile::tempdir().unwrap();
    let [truth, estimate] = ["truth", "estimate"].map(|name| dir.path().join(name));
    for (i, case) in golden.cases.iter().enumerate() {
        std::fs::write(&truth, case.truth.join("\n")).unwrap();
        std::fs::write(&estimate, case.estimate.join("\n")).unwrap();
        for (command, said) in [("ape", &case.ape), ("rpe", &case.rpe)] {
            let done = end(dpn().arg(command).arg(&truth).arg(&estimate).arg("--json").args(&said.options));
            let json = done.well().json();
            let got = &json["pairs"][0];
            let what = format!("case {i}, {command} {}", said.options.join(" "));
            assert_eq!(got["count"], said.count, "{what}");
            for (key, expected) in
                [("rmse", said.rmse), ("mean", said.mean), ("median", said.median), ("max", said.max)]
            {
                let got = got[key].as_f64().unwrap();
                assert!((got - expected).abs() < 1e-8, "{what}: {key} is {got}, evo's {expected}");
            }
        }
    }
}

/// A trajectory of so many poses that is off by `error` along x, more in its middle.
fn trajectory(poses: usize, error: f64) -> String {
    let mut text = String::new();
    for i in 0..poses {
        let t = 0.1 * i as f64;
        let x = t.sin() + error * (0.5 * t).sin();
        writeln!(text, "{t:.1} {x} {} 0 0 0 0 1", t.cos()).unwrap();
    }
    text
}

/// Folders `truth`, `a` and `b` of `count` sequences; b errs half as much as a.
fn folders(dir: &Path, count: usize) {
    for (name, error) in [("truth", 0.0), ("a", 0.1), ("b", 0.05)] {
        std::fs::create_dir(dir.join(name)).unwrap();
        for i in 0..count {
            let text = trajectory(50 + i, error * (1.0 + 0.1 * i as f64));
            std::fs::write(dir.join(name).join(format!("s{i}.tum")), text).unwrap();
        }
    }
}

fn ape(dir: &Path, more: &[&str]) -> Done {
    end(dpn().arg("ape").current_dir(dir).args(["truth", "a", "b"]).args(more))
}

#[test]
fn several_sequences_have_a_ratio_and_from_six_on_an_interval_and_tests() {
    let dir = tempfile::tempdir().unwrap();
    folders(dir.path(), 6);
    std::fs::write(dir.path().join("truth/s0.json"), "{}").unwrap();
    let page = ape(dir.path(), &[]).well().stdout;
    assert!(
        page.contains("0.50 (0.50 to 0.50)") && page.contains("6 of 6") && page.contains("0.031"),
        "{page}"
    );
    let json = ape(dir.path(), &["--json"]).well().json();
    let comparison = &json["comparisons"][0];
    assert_eq!((json["pairs"].as_array().unwrap().len(), comparison["worse"].as_u64()), (12, Some(0)));
    assert!((comparison["p_sign"].as_f64().unwrap() - 2.0 / 64.0).abs() < 1e-12, "{comparison}");
    std::fs::remove_file(dir.path().join("b/s5.tum")).unwrap();
    let few = ape(dir.path(), &[]).well();
    assert!(few.stdout.contains("  0.50     5 of 5  -\n"), "{few:?}");
    assert_eq!(few.stderr, "note: b has nothing of s5\n");
    assert!(few.stdout.contains("mean rmse: over the 5 sequences that all have"), "{few:?}");
    std::fs::copy(dir.path().join("truth/s5.tum"), dir.path().join("b/s5.tum")).unwrap();
    ape(dir.path(), &[]).refused(
        dir.path(),
        "error: b/s5.tum has no error against truth/s5.tum: it is the truth, and nothing has a ratio to it\n\nhint: leave its folder away, or judge it alone",
    );
}

#[test]
fn a_picture_is_left_with_its_numbers() {
    let dir = tempfile::tempdir().unwrap();
    folders(dir.path(), 1);
    let of = |more: &[&str]| {
        let line = ["truth/s0.tum", "a/s0.tum", "b/s0.tum"];
        end(dpn().arg("rpe").current_dir(dir.path()).args(line).args(more))
    };
    let page = of(&["-d", "1", "-u", "m", "--save_plot", "out/plot.pdf"]).well().stdout;
    assert!(page.starts_with("RPE over 1m, trans_part [m]; not aligned.\n"), "{page}");
    assert!(page.contains("\na/s0.tum") && page.ends_with("picture:  out/plot.png\n"), "{page}");
    let names: Vec<String> = files(&dir.path().join("out")).into_keys().collect();
    assert_eq!(names, ["plot.csv", "plot.pdf", "plot.png", "plot.svg"]);
    let refused = of(&["--save_plot", "plot.eps"]);
    refused.refused(
        dir.path(),
        "error: plot.eps: pictures are SVG, PDF and PNG\n\nhint: name FILE.svg or FILE.pdf",
    );
    for folder in ["out", "new/", ".."] {
        let words = format!(
            "error: --save_plot {folder}: a folder, and a picture needs a name\n\nhint: name a file in it: FILE.svg"
        );
        of(&["--save_plot", folder]).refused(dir.path(), &words);
    }
}

#[test]
fn what_cannot_be_compared_is_one_line_and_a_remedy() {
    let dir = tempfile::tempdir().unwrap();
    folders(dir.path(), 1);
    let put = |name: &str, text: &str| std::fs::write(dir.path().join(name), text).unwrap();
    put("late", "90 0 0 0 0 0 0 1\n91 1 0 0 0 0 0 1\n");
    put("one", "1 0 0 0 0 0 0 1\n");
    put("huge", "1 0 0 0 0 0 0 1\n2 0 1e200 0 0 0 0 1\n");
    put("ns", "1403636625363555670 0 0 0 0 0 0 1\n");
    put("commas", "1403636625.3,0,0,0,0,0,0,1\n1403636625.4,0,0,0,0,0,0,1\n");
    put("seven", "1 0 0 0 0 0 0\n");
    put("kitti", &"1 0 0 0 0 1 0 0 0 0 1 0\n".repeat(3));
    put("short", &"1 0 0 0 0 1 0 0 0 0 1 0\n".repeat(2));
    put("line", &(0..50).map(|i| format!("{} {i} 0 0 0 0 0 1\n", 0.1 * f64::from(i))).collect::<String>());
    let moves = "hint: --t_offset SECONDS moves the estimate's stamps, --t_max_diff SECONDS pairs what is further apart";
    let refused = |line: &str, expected: &str| {
        let words = line.split(' ').map(|word| match dir.path().join(word) {
            path if path.exists() => path.into_os_string(),
            _ => word.into(),
        });
        end(dpn().args(words)).refused(dir.path(), expected);
    };
    refused(
        "ape truth/s0.tum truth/s0.tum",
        "error: [DIR]/truth/s0.tum is compared with itself\n\nhint: name the truth first, then what is judged",
    );
    refused(
        "ape truth/s0.tum late",
        &format!(
            "error: [DIR]/late against [DIR]/truth/s0.tum: 0 pairs of poses where an absolute error needs 1: 2 poses from 90.00 to 91.00 s, against 50 poses from 0.00 to 4.90 s\n\n{moves}"
        ),
    );
    refused(
        "rpe truth/s0.tum one",
        &format!(
            "error: [DIR]/one against [DIR]/truth/s0.tum: 1 pairs of poses where a relative error needs 2: one pose at 1.00 s, against 50 poses from 0.00 to 4.90 s\n\n{moves}"
        ),
    );
    refused(
        "rpe truth/s0.tum a/s0.tum -d 90 -u m",
        "error: [DIR]/a/s0.tum against [DIR]/truth/s0.tum: no stretch of 90m among 50 pairs of poses: take a shorter one, or a wider tolerance\n\nhint: give another -d, or --all_pairs and -t SHARE",
    );
    refused(
        "ape kitti short",
        "error: [DIR]/kitti has 3 poses without stamps and [DIR]/short has 2\n\nhint: poses without stamps belong together line by line: give as many, or stamps before each",
    );
    refused(
        "ape truth/s0.tum a",
        "error: [DIR]/a is a folder without a trajectory\n\nhint: name a file or a run's folder; folders of several belong to a folder of truths",
    );
    refused(
        "ape truth a/s0.tum",
        "error: [DIR]/a/s0.tum is a file where the truth is a folder of sequences\n\nhint: with a folder of truths, estimates are folders too",
    );
    refused(
        "ape truth/s0.tum huge",
        "error: [DIR]/huge:2: y is 1e200 m; no trajectory goes further than 1e9 m\n\nhint: an estimator that diverges leaves such poses: cut the file before them",
    );
    refused(
        "ape kitti truth/s0.tum",
        "error: [DIR]/kitti:1: twelve columns are a pose without a stamp, and no times.txt lies beside the file\n\nhint: KITTI's poses need times.txt beside them, a number of seconds a line; two files without stamps are compared line by line",
    );
    put("kitti2", &"1 0 0 0 0 1 0 0 0 0 1 0\n".repeat(3));
    for (line, flag) in [("rpe kitti kitti2 -u s", "-u s"), ("ape kitti kitti2 --t_end 2", "--t_end")] {
        refused(
            line,
            &format!(
                "error: {flag} is in seconds, and [DIR]/kitti and [DIR]/kitti2 have no stamps\n\nhint: leave it away, or put a stamp before each pose or times.txt beside each file"
            ),
        );
    }
    refused(
        "ape truth/s0.tum a/s0.tum --n_to_align 9",
        "error: --n_to_align aligns nothing without -a or -s\n\nhint: give -a, -s or both",
    );
    refused(
        "ape truth/s0.tum a/s0.tum --t_start 3 --t_end 2",
        "error: --t_start 3 is after --t_end 2\n\nhint: both are stamps; give the earlier one as --t_start",
    );
    for (line, said) in [
        ("ape truth/s0.tum ns", "between blanks, as TUM has them, stamps are seconds"),
        ("ape truth/s0.tum commas", "between commas, as EuRoC has them, nanoseconds"),
        ("ape truth/s0.tum seven", "trajectories are TUM's (t x y z qx qy qz qw between blanks"),
        ("ape truth/s0.tum a/s0.tum -a --n_to_align 2", "'--n_to_align <N>': 2 is not in 3.."),
        ("ape truth/s0.tum a/s0.tum --t_end -5", "--t_start and --t_end are stamps"),
        ("rpe truth/s0.tum a/s0.tum -d nan", "'nan' for '--delta <NUMBER>': give a length above 0"),
        ("rpe truth/s0.tum a/s0.tum --all_pairs -t 100", "give a share from 0 to below 1"),
        ("rpe truth/s0.tum a/s0.tum -t 0.5", "--all_pairs"),
    ] {
        let done = end(dpn().current_dir(dir.path()).args(line.split(' ')));
        assert!(done.code == Some(2) && done.stderr.contains(said), "{line}: {done:?}");
    }
    let line = end(dpn().arg("ape").args([dir.path().join("line"), dir.path().join("a/s0.tum")]).arg("-a"));
    assert_eq!(line.code, Some(2), "{line:?}");
    assert!(line.stderr.ends_with("hint: leave -a and -s away, or give --align_origin\n"), "{line:?}");
    assert_eq!(run("ape nowhere here").code, Some(2));
}

#[test]
fn what_looks_like_a_slip_is_said() {
    let dir = tempfile::tempdir().unwrap();
    folders(dir.path(), 1);
    let put = |name: &str, poses: &dyn Fn(f64) -> String| {
        let text: String = (0..40).map(|i| poses(0.1 * f64::from(i))).collect();
        std::fs::write(dir.path().join(name), text).unwrap();
    };
    let row = |t: f64, start: f64, size: f64| {
        format!("{:.1} {} {} 0 0 0 0 1\n", start + t, size * t.sin(), size * t.cos())
    };
    put("late", &|t| row(t, 1_403_636_000.0, 1.0));
    put("estimate", &|t| row(t, 1_403_636_000.0, 1.0 + 1e-3 * t));
    put("mm", &|t| row(t, 1_403_636_000.0, 1000.0));
    std::fs::write(
        dir.path().join("marked"),
        "\u{feff}# t x y z\n".to_owned() + &row(0.0, 1_403_636_000.0, 1.0),
    )
    .unwrap();
    let of =
        |line: &str| end(dpn().current_dir(dir.path()).arg("ape").arg("late").args(line.split(' '))).well();
    assert_eq!(of("estimate").stderr, "");
    assert_eq!(of("marked").stderr, "");
    assert_eq!(
        of("mm -a").stderr,
        "note: mm is 1000 times as large as the truth: in millimetres? -s takes the scale out\n"
    );
    assert_eq!(of("mm -a -s").stderr, "");
    assert_eq!(
        of("estimate --t_start 5").stderr,
        "warning: --t_start 5 leaves out nothing: it is a stamp, not seconds from the start, and late begins at 1403636000.00\n"
    );
    let all = of("estimate -a --n_to_align 10000000").stdout;
    assert!(all.starts_with("APE, trans_part [m]; aligned in SE(3).\n"), "{all}");
}

/// Poses of four types of messages in two kinds of bags (`golden/bags/poses.py`): the estimate is a quarter of a metre higher.
#[test]
fn poses_of_a_bag_are_those_of_a_topic() {
    let bags = dpn_testing::repository().join("golden/bags");
    let topic = |bag: &str, topic: &str| format!("{}:{topic}", bags.join(bag).display());
    let judged = |truth: &str, estimate: &str| end(dpn().args(["ape", truth, estimate, "--json"]));
    for (truth, estimate) in [("poses.bag", "poses.bag"), ("poses.bag", "poses"), ("poses", "poses.bag")] {
        let json = judged(&topic(truth, "/truth"), &topic(estimate, "/odometry")).well().json();
        let one = &json["pairs"][0];
        assert_eq!(
            (one["count"].as_u64(), one["rmse"].as_f64(), one["max"].as_f64()),
            (Some(20), Some(0.25), Some(0.25)),
            "{json}"
        );
    }
    let bag = bags.join("poses.bag").display().to_string();
    judged(&bag, &topic("poses", "/odometry")).refused(
        &bags,
        "error: [DIR]/poses.bag: several topics of poses: /truth, /odometry\n\nhint: name one behind the bag: [DIR]/poses.bag:/truth",
    );
    judged(&topic("poses", "/truth"), &topic("poses", "/odometri")).refused(
        &bags,
        "error: [DIR]/poses: no topic `/odometri`; it has /truth, /odometry\n\nhint: did you mean `/odometry`?",
    );
    let none = judged(&bags.join("plain.bag").display().to_string(), &topic("poses", "/odometry"));
    assert!(none.code == Some(2) && none.stderr.contains("no poses on any topic"), "{none:?}");
}
