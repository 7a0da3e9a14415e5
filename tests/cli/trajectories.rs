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
}

#[test]
fn a_picture_is_left_with_its_numbers() {
    let dir = tempfile::tempdir().unwrap();
    folders(dir.path(), 1);
    let of = |more: &[&str]| {
        let line = ["truth/s0.tum", "a/s0.tum", "b/s0.tum"];
        end(dpn().arg("rpe").current_dir(dir.path()).args(line).args(more))
    };
    let page = of(&["-d", "1", "-u", "m", "--save_plot", "out/plot.svg"]).well().stdout;
    assert!(page.starts_with("RPE over 1m, trans_part [m]; not aligned.\n"), "{page}");
    assert!(page.contains("\na/s0.tum") && page.ends_with("picture:  out/plot.png\n"), "{page}");
    let names: Vec<String> = files(&dir.path().join("out")).into_keys().collect();
    assert_eq!(names, ["plot.csv", "plot.png", "plot.svg"]);
    let refused = of(&["--save_plot", "plot.pdf"]);
    refused.refused(
        dir.path(),
        "error: plot.pdf: pictures are SVG and PNG\n\nhint: name FILE.svg; a browser prints it as PDF",
    );
}

#[test]
fn what_cannot_be_compared_is_one_line_and_a_remedy() {
    let dir = tempfile::tempdir().unwrap();
    folders(dir.path(), 1);
    let put = |name: &str, text: &str| std::fs::write(dir.path().join(name), text).unwrap();
    put("late", "90 0 0 0 0 0 0 1\n91 1 0 0 0 0 0 1\n");
    put("one", "1 0 0 0 0 0 0 1\n");
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
        "error: [DIR]/a/s0.tum against [DIR]/truth/s0.tum: no stretch of 90m among 50 pairs of poses: take a shorter one, or a wider tolerance\n\nhint: give another -d, or -t SHARE",
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
    let line = end(dpn().arg("ape").args([dir.path().join("line"), dir.path().join("a/s0.tum")]).arg("-a"));
    assert_eq!(line.code, Some(2), "{line:?}");
    assert!(line.stderr.ends_with("hint: leave -a and -s away, or give --align_origin\n"), "{line:?}");
    assert_eq!(run("ape nowhere here").code, Some(2));
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
