//! Recordings that are refused: one clear line with file, line and remedy, exit code 2, nothing left behind.

use crate::recording::{HEADER, put, rows, sound, text};
use crate::training::{refuses, refuses_log};

const PERIOD_NS: i64 = 5_000_000;

#[test]
fn a_missing_folder() {
    let dir = tempfile::tempdir().unwrap();
    let gone = dir.path().join("no/such");
    refuses(
        dir.path(),
        &gone,
        "error: [DIR]/no/such does not exist\n\nhint: [DIR] is there; look at the rest of the path",
    );
}

#[test]
fn a_folder_without_a_sequence() {
    let dir = tempfile::tempdir().unwrap();
    let empty = dir.path().join("empty");
    std::fs::create_dir(&empty).unwrap();
    refuses(
        dir.path(),
        &empty,
        "error: no ASL sequence in [DIR]/empty: looked for mav0/imu0/data.csv, imu0/data.csv, \
         */mav0/imu0/data.csv, */imu0/data.csv, */*/mav0/imu0/data.csv, */*/imu0/data.csv\n\n\
         hint: give the folder of one sequence (it holds `mav0` or `imu0`) or one that holds sequences; a folder of images needs `times.txt` (id and timestamp a line) and `imu.txt` or `imu.csv`",
    );
}

#[test]
fn an_empty_file_and_one_with_a_header_alone() {
    for text in ["", HEADER] {
        refuses_log(
            text,
            "error: [DIR]/log/still/mav0/imu0/data.csv: no row of data\n\n\
             hint: the download or export may have been cut off; make the file again",
        );
    }
}

#[test]
fn a_missing_column() {
    let whole = text(&rows(300, PERIOD_NS));
    let cut: Vec<&str> =
        whole.lines().filter_map(|line| line.rsplit_once(',')).map(|(head, _)| head).collect();
    let dir = tempfile::tempdir().unwrap();
    let data = put(&dir.path().join("log"), "still", &cut.join("\n"));
    let out = dir.path().join("out");
    let done = crate::run::end(&mut crate::training::tiny(dir.path(), &data, 1, &out));
    assert_eq!(done.code, Some(2), "{done:?}");
    let file = data.join("still/mav0/imu0/data.csv");
    assert!(done.stderr.starts_with(&format!("error: {}:1: ", file.display())), "{done:?}");
    assert!(done.stderr.contains("column") && done.stderr.contains("\n\nhint: "), "{done:?}");
    assert!(!out.exists());
}

#[test]
fn values_that_are_not_finite() {
    for (word, shown) in [("NaN", "NaN"), ("inf", "inf"), ("-inf", "-inf")] {
        let whole = text(&rows(300, PERIOD_NS));
        let mut lines: Vec<String> = whole.lines().map(str::to_owned).collect();
        // Line 101, counted from 1, its third value.
        let mut fields: Vec<&str> = lines[100].split(',').collect();
        fields[3] = word;
        let line = fields.join(",");
        lines[100] = line;
        refuses_log(
            &lines.join("\n"),
            &format!(
                "error: [DIR]/log/still/mav0/imu0/data.csv:101: gyro_z is \"{shown}\"; every value must be finite\n\n\
                 hint: mend or delete the line; nothing is skipped silently"
            ),
        );
    }
}

#[test]
fn text_where_a_number_belongs() {
    let whole = text(&rows(300, PERIOD_NS)).replacen(",9.", ",nine.", 1);
    let dir = tempfile::tempdir().unwrap();
    let data = put(&dir.path().join("log"), "still", &whole);
    let out = dir.path().join("out");
    let done = crate::run::end(&mut crate::training::tiny(dir.path(), &data, 1, &out));
    assert_eq!(done.code, Some(2), "{done:?}");
    let line = 1 + whole.lines().position(|line| line.contains("nine")).unwrap();
    assert!(done.stderr.contains(&format!("data.csv:{line}: accel_z is \"nine.")), "{done:?}");
    assert!(done.stderr.contains("not a number"), "{done:?}");
    assert!(!out.exists());
}

#[test]
fn stamps_that_go_back_or_stand_still() {
    let start = 1_400_000_000_000_000_000_i64;
    let mut back = rows(300, PERIOD_NS);
    back[150].0 = start;
    refuses_log(
        &text(&back),
        &format!(
            "error: [DIR]/log/still/mav0/imu0/data.csv:152: time goes from {} to {start} ns; stamps must increase\n\n\
             hint: sort the rows by time, or cut the log where its clock was set",
            start + 149 * PERIOD_NS
        ),
    );
    let mut still = rows(300, PERIOD_NS);
    let before = still[149].0;
    still[150].0 = before;
    refuses_log(
        &text(&still),
        &format!(
            "error: [DIR]/log/still/mav0/imu0/data.csv:152: time goes from {before} to {before} ns; stamps must increase\n\n\
             hint: two rows share a stamp: drop one, or write stamps with more digits"
        ),
    );
}

#[test]
fn a_log_shorter_than_a_window_and_one_too_short_to_validate_on() {
    refuses_log(
        &text(&rows(150, PERIOD_NS)),
        "error: still: 150 samples; at least 200 are needed\n\nhint: record for longer; or leave the sequence out",
    );
    refuses_log(
        &text(&rows(900, PERIOD_NS)),
        "error: the training sequences hold 6 windows to learn from and 0 to validate on; record longer",
    );
}

#[test]
fn a_wrong_rate() {
    refuses_log(
        &text(&rows(3000, 10_000_000)),
        "error: still: it has 100.0 Hz, and windows of 200.0 Hz are asked for; what was not sampled cannot be made\n\n\
         hint: train networks of its rate (dpn train --rate 100), or leave the sequence out",
    );
}

#[test]
fn an_axis_that_never_changes() {
    let mut dead = rows(3000, PERIOD_NS);
    dead.iter_mut().for_each(|(_, values)| values[4] = 0.25);
    refuses_log(
        &text(&dead),
        "error: still: accel y is dead: it reads 0.25 m/s^2 throughout\n\n\
         hint: look at the wiring or the column; a live sensor is never without noise; or leave the sequence out",
    );
}

#[test]
fn an_axis_that_is_clipped() {
    let mut clipped = rows(3000, PERIOD_NS);
    clipped.iter_mut().enumerate().for_each(|(i, (_, values))| {
        // A swing of 30 m/s^2 in a range of 20.
        values[3] = (values[3] + 30.0 * (i as f64 / 100.0).sin()).clamp(-20.0, 20.0);
    });
    let dir = tempfile::tempdir().unwrap();
    let data = put(&dir.path().join("log"), "still", &text(&clipped));
    let out = dir.path().join("out");
    let done = crate::run::end(&mut crate::training::tiny(dir.path(), &data, 1, &out));
    assert_eq!(done.code, Some(2), "{done:?}");
    assert!(done.stderr.starts_with("error: still: accel x is saturated: it stays at "), "{done:?}");
    assert!(!out.exists());
}

#[test]
fn a_folder_to_write_to_that_is_a_file() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("out");
    std::fs::write(&out, "in the way").unwrap();
    let done = crate::run::end(&mut crate::training::tiny(dir.path(), &sound(dir.path()), 1, &out));
    assert_eq!(done.code, Some(2), "{done:?}");
    assert!(done.stderr.starts_with(&format!("error: cannot write {}", out.display())), "{done:?}");
    assert_eq!(std::fs::read_to_string(&out).unwrap(), "in the way");
}

#[test]
fn sequences_of_which_none_is_to_train_on() {
    let dir = tempfile::tempdir().unwrap();
    let data = put(&dir.path().join("log"), "MH_02_easy", &text(&rows(3000, PERIOD_NS)));
    let out = dir.path().join("out");
    let done = crate::run::end(&mut crate::training::tiny(dir.path(), &data, 1, &out));
    assert_eq!(done.code, Some(2), "{done:?}");
    assert!(done.stderr.starts_with("error: euroc: no train sequence among [\"MH_02_easy\"]"), "{done:?}");
    assert!(!out.exists());
}
