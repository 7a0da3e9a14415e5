//! `dpn noise convert`: text on stdout, arithmetic on stderr, clear words for what cannot be.

use crate::run::{dpn, end, run};

const KALIBR: &str = "rostopic: /imu0\nupdate_rate: 200.0  #Hz\naccelerometer_noise_density: 2.0e-3\n\
    accelerometer_random_walk: 3.0e-3\ngyroscope_noise_density: 1.6968e-04\ngyroscope_random_walk: 1.9393e-05\n";

#[test]
fn kalibr_to_vins_says_every_step() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("imu.yaml");
    std::fs::write(&file, KALIBR).unwrap();
    let done =
        end(dpn().args(["noise", "convert", "--from", "kalibr", "--to", "vins", "--rate", "200"]).arg(&file))
            .well();
    assert_eq!(
        done.stdout,
        "%YAML:1.0\n# VINS-Mono, VINS-Fusion: per sample at 200.0 Hz; another rate needs other numbers\n\
         acc_n: 0.028284271  # m/s^2\nacc_w: 0.042426407  # m/s^3\ngyr_n: 0.0023996376  # rad/s\ngyr_w: 2.7425844e-4  # rad/s^2\n"
    );
    assert!(
        done.stderr.contains(
            "acc_n = 0.002 m/s^2/sqrt(Hz) * sqrt(200.0 Hz) = 0.028284271 m/s^2 (deviation of one sample)\n"
        ),
        "{done:?}"
    );
    assert!(
        done.stderr.contains(
            "counts half of this variance; to have all of it propagated write acc_n: 0.04, gyr_n: 0.0033936"
        ),
        "{done:?}"
    );
}

#[test]
fn a_data_sheet_on_the_command_line_needs_no_file() {
    let done = end(dpn().args([
        "noise",
        "convert",
        "--to",
        "openvins",
        "--accel-noise",
        "0.2 mg/sqrt(Hz)",
        "--gyro-noise",
        "0.66 deg/√hr",
        "--gyro-walk",
        "2e-5",
        "--json",
    ]))
    .well();
    let json = done.json();
    let density = json["figures"]["gyro_white"].as_f64().unwrap();
    assert!((density - 0.66 * std::f64::consts::PI / 180.0 / 60.0).abs() < 1e-15);
    assert_eq!(json["to"], "openvins");
    let text = json["text"].as_str().unwrap();
    assert!(text.contains("  # accelerometer_random_walk: not known"), "{text}");
    assert!(json["remarks"][0].as_str().unwrap().contains("--accel-walk"), "{json}");
}

#[test]
fn what_cannot_be_converted_is_one_line_with_a_remedy() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("imu.yaml");
    let case = |text: &str, line: &[&str], expected: &str| {
        std::fs::write(&file, text).unwrap();
        end(dpn().args(["noise", "convert"]).args(line).arg(&file)).refused(dir.path(), expected);
    };
    case(
        &KALIBR.replace("1.6968e-04", "0"),
        &["--to", "vins"],
        "error: [DIR]/imu.yaml:5: `gyroscope_noise_density` is 0; a noise figure is above zero\n\n\
         hint: an estimator told of no noise trusts the IMU without bound; put the sensor's figure there",
    );
    case(
        &KALIBR.replace("gyroscope_random_walk", "gyroscope_random_wlak"),
        &["--to", "vins"],
        "error: [DIR]/imu.yaml: no `gyroscope_random_walk`, which kalibr needs\n\n\
         hint: line 6 has `gyroscope_random_wlak`; did you mean `gyroscope_random_walk`?",
    );
    case(
        KALIBR,
        &["--from", "vins", "--to", "kalibr"],
        "error: [DIR]/imu.yaml: no `acc_n`, `acc_w`, `gyr_n`, `gyr_w`, which vins needs\n\n\
         hint: the file has the keys of kalibr: say --from kalibr",
    );
    case(
        "acc_n: 0.08\nacc_w: 4e-5\ngyr_n: 0.004\ngyr_w: 2e-6\n",
        &["--to", "kalibr"],
        "error: vins has its figures per sample; the rate of the samples is needed\n\nhint: add --rate HZ",
    );
    case(
        "gyroscope_noise: 5 deg/h\n",
        &["--to", "kalibr"],
        "error: [DIR]/imu.yaml:1: `gyroscope_noise`: \"5 deg/h\" is a bias instability (the flat part of an Allan plot); it is no \
         gyroscope noise, and none follows from it\n\n\
         hint: look for the random walk (deg/sqrt(h), mg/sqrt(Hz)) in the data sheet, or record a log at rest and ask `dpn allan`",
    );
    std::fs::remove_file(&file).unwrap();
    end(dpn().args(["noise", "convert", "--to", "vins"]).arg(&file)).refused(
        dir.path(),
        "error: [DIR]/imu.yaml does not exist\n\nhint: [DIR] is there; look at the rest of the path",
    );
    let done = run("noise convert --to kalbir imu.yaml");
    assert_eq!(done.code, Some(2));
    assert!(done.stderr.contains("did you mean `kalibr`?"), "{done:?}");
}
