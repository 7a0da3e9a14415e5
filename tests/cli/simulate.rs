//! `dpn simulate flight`.

use crate::run::{Done, dpn, end, files, run};
use dpn_core::Sensor;
use dpn_core::signal::stats::{Ddof, deviation, mean};
use dpn_io::asl::Sequence;
use dpn_io::read_noise_track;
use dpn_sim::{Flight, FlightConfig, simulate};
use std::path::Path;

fn flight(name: &str, out: &Path, more: &[&str]) -> Done {
    end(dpn().args(["simulate", "flight", name, "--out"]).arg(out).args(more))
}

#[test]
fn eleven_flights_are_listed_six_of_them_to_train_on() {
    let list = run("simulate flight --list").well().stdout;
    assert_eq!(list.lines().count(), 11, "{list}");
    assert_eq!(list.lines().filter(|line| line.ends_with("Train")).count(), 6, "{list}");
    assert!(list.starts_with("f01-hall-slow ") && list.contains("\nf11-room-wild "), "{list}");
}

#[test]
fn a_flight_is_an_asl_folder_that_reads_back_with_its_true_noise() {
    let tmp = tempfile::tempdir().unwrap();
    let said = flight("hover", tmp.path(), &["--json"]).well().json();
    let dir = tmp.path().join("f09-hover");
    assert_eq!(said["flight"], "f09-hover");
    assert_eq!(said["dir"], dir.to_str().unwrap());

    let sequence = Sequence::open(&dir).unwrap();
    let imu = sequence.imu().unwrap();
    assert_eq!(said["samples"], imu.len());
    assert!((imu.rate().hz() - 200.0).abs() < 0.1, "{}", imu.rate().hz());
    assert!(sequence.imu_config().unwrap().is_some());
    sequence.ground_truth().unwrap();

    let noise = read_noise_track(&dir.join("true_noise.csv")).unwrap();
    let flown = simulate(Flight::Hover, 0, &FlightConfig::default()).unwrap();
    assert_eq!(noise, flown.truth.oracle(&imu).unwrap());
    // And what was flown has it: over a second at rest the samples scatter as the file says, to a fifth (200 samples give 5 %; four of these).
    for sensor in Sensor::ALL {
        for axis in 0..3 {
            let second: Vec<f64> = imu.samples()[..200].iter().map(|s| s.of(sensor)[axis]).collect();
            let squares: Vec<f64> =
                noise.noises()[..200].iter().map(|n| n.of(sensor)[axis].powi(2)).collect();
            let ratio = deviation(&second, Ddof::One) / mean(&squares).sqrt();
            assert!((ratio - 1.0).abs() < 0.2, "{sensor} {axis}: {ratio}");
        }
    }
}

#[test]
fn the_same_seed_writes_the_same_bytes_and_another_does_not() {
    let tmp = tempfile::tempdir().unwrap();
    let of = |place: &str, seed: &str| {
        let out = tmp.path().join(place);
        flight("f09-hover", &out, &["--seed", seed]).well();
        files(&out)
    };
    let (first, again, other) = (of("a", "5"), of("b", "5"), of("c", "6"));
    assert!(first == again, "two runs of seed 5 differ");
    let imu = "f09-hover/mav0/imu0/data.csv";
    assert!(first[imu] != other[imu], "seed 6 wrote the samples of seed 5");
    assert_eq!(first.keys().collect::<Vec<_>>(), other.keys().collect::<Vec<_>>());
}

#[test]
fn an_unknown_flight_is_refused_in_one_line_with_the_known_ones() {
    let tmp = tempfile::tempdir().unwrap();
    let out = tmp.path().join("out");
    let done = flight("hovr", &out, &[]);
    assert_eq!(done.code, Some(2), "{done:?}");
    assert_eq!(done.stderr.lines().count(), 1, "{done:?}");
    assert!(
        done.stderr.starts_with("error: no flight is called `hovr`; known are f01-hall-slow, "),
        "{done:?}"
    );
    assert!(done.stderr.trim_end().ends_with("f11-room-wild (did you mean `f09-hover`?)"), "{done:?}");
    assert!(!out.exists());
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let tmp = tempfile::tempdir().unwrap();
    let file = tmp.path().join("file");
    std::fs::write(&file, "in the way").unwrap();
    let done = flight("hover", &file, &[]);
    assert_eq!(done.code, Some(2), "{done:?}");
    assert!(done.stderr.starts_with(&format!("error: cannot write {}", file.display())), "{done:?}");
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "in the way");
}

#[test]
fn a_bad_noise_setting_names_key_value_and_bound() {
    let tmp = tempfile::tempdir().unwrap();
    let config = tmp.path().join("noise.toml");
    std::fs::write(&config, "rate_hz = 10\n[white]\nscale = -1.0\n").unwrap();
    let out = tmp.path().join("out");
    flight("hover", &out, &["--config", config.to_str().unwrap()]).refused(
        tmp.path(),
        "error: [DIR]/noise.toml: `rate_hz` is 10, but must be 50 to 2000; \
         `white.scale` is -1, but must be 0 to 1000",
    );
    assert!(!out.exists());
}
