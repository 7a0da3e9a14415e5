//! What is read and what is written are kept apart; what gives nothing is not waited for.

use crate::recording::{put, rows, text};
use crate::run::{Done, dpn, end, files};
use std::path::Path;

fn typed(dir: &Path, line: &str) -> Done {
    end(dpn().current_dir(dir).args(line.split_whitespace()))
}

#[test]
fn no_result_comes_over_what_is_read_and_no_folder_of_results_into_a_file() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    let log = text(&rows(2000, 5_000_000));
    put(dir, "still", &log);
    for name in ["x.csv", "noise.csv", "spectra.csv", "allan.csv"] {
        std::fs::write(dir.join(name), &log).unwrap();
    }
    let poses: String = (0..40).map(|i| format!("{i}.0 {i} {} 0 0 0 0 1\n", i % 7)).collect();
    std::fs::write(dir.join("e.tum"), &poses).unwrap();
    std::fs::write(dir.join("est.csv"), &poses).unwrap();
    let before = files(dir);
    for line in [
        "report x.csv --out x.csv",
        "convert x.csv --out ./x.csv",
        "convert still --to-rate 100 --out still/mav0/imu0/data.csv",
        "convert x.csv --out -",
        "convert x.csv --out still",
        "run still --mcap still/mav0/imu0/data.csv",
        "run still --tracks x.csv --mcap x.csv",
        "ape e.tum est.csv -a --save_plot est.svg",
        "noise noise.csv --out .",
        "noise x.csv --into x.csv",
        "check spectra.csv --out .",
        "compare x.csv spectra.csv --out .",
        "allan allan.csv --out .",
        "noise x.csv --out e.tum",
        "noise x.csv spectra.csv --out e.tum",
        "check x.csv --out e.tum/below",
        "compare x.csv noise.csv --out e.tum",
        "run still --out e.tum",
    ] {
        let done = typed(dir, line);
        let refusals = [
            "which is read\n\nhint: name another",
            "is no file that can be written",
            "e.tum is a file, and results",
        ];
        assert!(
            done.code == Some(2) && refusals.iter().any(|words| done.stderr.contains(words)),
            "{line}: {done:?}"
        );
        assert!(done.stdout.is_empty() && files(dir) == before, "{line}");
    }
    typed(dir, "check x.csv --out .").well();
    typed(dir, "ape e.tum est.csv --save_plot picture.svg").well();
    assert!(typed(dir, "compare still still").stderr.contains("still is compared with itself"));
    assert!(typed(dir, "page nosuch").stderr.contains("nosuch"));
}

#[test]
#[cfg(unix)]
fn a_pipe_in_a_folder_is_passed_over_and_one_for_a_trajectory_refused() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    let folder = dir.join("folder");
    std::fs::create_dir(&folder).unwrap();
    for name in ["a.csv", "b.csv"] {
        std::fs::write(folder.join(name), text(&rows(2000, 5_000_000))).unwrap();
    }
    for pipe in ["c.csv", "d.jsonl", "e.bag", "f.mcap", "g.db3"] {
        assert!(std::process::Command::new("mkfifo").arg(folder.join(pipe)).status().unwrap().success());
    }
    for line in ["check folder", "noise folder"] {
        let page = typed(dir, line).well().stdout;
        assert!(page.contains("b.csv") && !page.contains("c.csv") && !page.contains("e.bag"), "{page}");
    }
    std::fs::write(dir.join("e.tum"), "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n").unwrap();
    for line in ["ape e.tum folder/c.csv", "rpe folder/c.csv e.tum"] {
        let done = typed(dir, line);
        assert!(
            done.code == Some(2) && done.stderr.contains("folder/c.csv is a pipe or a device"),
            "{done:?}"
        );
    }
}

#[test]
fn a_log_that_is_named_and_not_there_is_an_error_after_the_others() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    let folder = dir.join("folder");
    std::fs::create_dir(&folder).unwrap();
    std::fs::write(folder.join("none.csv"), "no log\n").unwrap();
    std::fs::write(dir.join("x.csv"), text(&rows(2000, 5_000_000))).unwrap();
    for command in ["noise", "check", "report"] {
        let done = typed(dir, &format!("{command} x.csv nosuch"));
        let said = done.code == Some(2)
            && done.stderr.ends_with(
                "error: nosuch does not exist\n\nhint: the other logs were read; look at its name\n",
            );
        assert!(
            said && done.stdout.contains(if command == "report" { "2 log(s)" } else { "x.csv" }),
            "{done:?}"
        );
        let done = typed(dir, &format!("{command} folder nosuch"));
        assert!(
            done.code == Some(2) && done.stderr.contains("error: none of 2 logs can be read"),
            "{done:?}"
        );
        assert_eq!(typed(dir, &format!("{command} folder")).code, Some(2), "{command}");
        typed(dir, &format!("{command} folder x.csv")).well();
    }
}

#[test]
fn a_log_whose_stamps_jump_by_years_is_resampled_at_once() {
    let tmp = tempfile::tempdir().unwrap();
    let mut samples = rows(4000, 5_000_000);
    samples[2000..].iter_mut().for_each(|(t, _)| *t += 100_000_000_000_000_000);
    std::fs::write(tmp.path().join("x.csv"), text(&samples)).unwrap();
    let done = typed(tmp.path(), "convert x.csv --to-rate 100 --out y.csv").well();
    assert!(done.stderr.contains("note: 1 hole(s)"), "{done:?}");
}
