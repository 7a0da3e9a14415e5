//! Every mix-up made on purpose, in every format, against recorded logs: named, or counted among those that a log in motion cannot show.

use super::Levels;
use super::compare::{Check, Standing, compare};
use crate::allan::compare::key_of;
use crate::finding::Finding;
use crate::phases::phases;
use dpn_core::noise::Meaning;
use dpn_core::noise::{AccelBiasWalkDensity, AccelNoiseDensity, GyroBiasWalkDensity, GyroNoiseDensity};
use dpn_core::noise::{Axes, Figure, ImuFigures};
use dpn_core::{Recorded, SampleRate};
use dpn_io::noise_formats::{Format, Given, NoiseCalibration, parse, write};
use dpn_logs::{LogOptions, read_log};
use dpn_testing::packs;
use std::path::Path;

const FORMATS: [Format; 8] = [
    Format::Kalibr,
    Format::OpenVins,
    Format::OrbSlam3,
    Format::Okvis2,
    Format::Basalt,
    Format::Vins,
    Format::Variances,
    Format::Ros,
];

/// A log with its IMU's own figures.
struct Case {
    name: &'static str,
    levels: Levels,
    rate: SampleRate,
    figures: ImuFigures,
}

/// Empty, loudly, without the recordings.
fn cases() -> Vec<Case> {
    let Some([euroc, tumvi_rooms]) = packs(["euroc", "tumvi"]) else { return Vec::new() };
    let mut cases = Vec::new();
    for (name, path, figures) in [
        ("V1_01", euroc.join("V1_01_easy"), ImuFigures::euroc()),
        ("MH_01", euroc.join("MH_01_easy"), ImuFigures::euroc()),
        ("room1", tumvi_rooms.join("dataset-room1_512_16"), tumvi()),
    ] {
        let recording = read_log(&path, &LogOptions::default()).unwrap().recording;
        let levels = Levels::of(&recording, &phases(&recording).unwrap()).unwrap().unwrap();
        cases.push(Case { name, levels, rate: recording.rate(), figures });
    }
    cases
}

/// TUM-VI's BMI160, as its authors measured it.
fn tumvi() -> ImuFigures {
    ImuFigures {
        rate: Some(SampleRate::HZ_200),
        accel_white: Some(Axes::Same(AccelNoiseDensity::new(1.4e-3).unwrap())),
        accel_walk: Some(Axes::Same(AccelBiasWalkDensity::new(8.6e-5).unwrap())),
        gyro_white: Some(Axes::Same(GyroNoiseDensity::new(8e-5).unwrap())),
        gyro_walk: Some(Axes::Same(GyroBiasWalkDensity::new(2.2e-6).unwrap())),
    }
}

/// The file a person would have, with one figure changed.
fn source(case: &Case, format: Format, change: Option<(Figure, f64)>) -> NoiseCalibration {
    let mut figures = case.figures;
    figures.rate = Some(case.rate);
    if let Some((figure, value)) = change {
        figures.set(figure, key_of(format, figure).1, Axes::Same(value), case.rate).unwrap();
    }
    let text = write(&figures, format, |_| None).unwrap().text;
    let given = Given { rate: Some(case.rate), keep_zeros: true, ..Given::default() };
    parse(text.as_bytes(), Path::new("f"), Some(format), &given).unwrap()
}

fn check(case: &Case, format: Format, change: Option<(Figure, f64)>) -> Check {
    compare(&source(case, format, change), &case.levels, case.rate).unwrap()
}

/// What is written by mistake for `right`, and the words that name it.
fn mistakes(figure: Figure, meaning: Meaning, right: f64, rate: SampleRate) -> Vec<(f64, &'static str)> {
    let root = rate.hz().sqrt();
    let mut all = match meaning {
        Meaning::Density => vec![
            (right * root, "a deviation per sample where a density belongs"),
            (right * right, "a variance where a deviation belongs"),
        ],
        Meaning::SampleStd => vec![
            (right / root, "a density where a deviation per sample belongs"),
            (right * right, "a variance where a deviation belongs"),
        ],
        Meaning::SampleVariance => vec![
            (right.sqrt(), "a deviation where a variance belongs"),
            (right / rate.hz(), "a power density where a variance per sample belongs"),
        ],
        _ => vec![(right * right, "a variance where a deviation belongs")],
    };
    if figure.sensor() == dpn_core::Sensor::Gyro {
        let power = if meaning == Meaning::SampleVariance { 2 } else { 1 };
        all.push((right * 57.295_78f64.powi(power), "degrees where radians belong"));
    }
    all
}

#[test]
fn sound_figures_raise_no_warning_and_every_mix_up_of_white_noise_is_named() {
    let mut missed = Vec::new();
    for case in cases() {
        for format in FORMATS {
            for finding in check(&case, format, None).findings() {
                if finding.warns() {
                    missed.push(format!("{} {format}, sound: {}", case.name, finding.text));
                }
            }
            for figure in [Figure::AccelWhite, Figure::GyroWhite] {
                let meaning = key_of(format, figure).1;
                let right = case.figures.get(figure, meaning, case.rate).unwrap().largest();
                for (wrong, words) in mistakes(figure, meaning, right, case.rate) {
                    let check = check(&case, format, Some((figure, wrong)));
                    let found = check.white.iter().find(|f| f.figure == figure).unwrap();
                    if !(found.finding().warns() && found.suspects.contains(&words)) {
                        missed.push(format!("{} {format}, {words}: {}", case.name, found.finding().text));
                    }
                }
            }
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}

/// Without an hour at rest a walk shows itself only by bounds: what is far outside is named all the same.
#[test]
fn a_walk_in_degrees_or_squared_is_named_where_a_log_allows() {
    // What neither the log nor what IMUs have can tell from a right figure.
    let hidden = [
        ("V1_01", Figure::AccelWalk, "a variance where a deviation belongs"),
        ("MH_01", Figure::AccelWalk, "a variance where a deviation belongs"),
        ("room1", Figure::GyroWalk, "degrees where radians belong"),
    ];
    for case in cases() {
        for (figure, words) in [
            (Figure::GyroWalk, "degrees where radians belong"),
            (Figure::GyroWalk, "a variance where a deviation belongs"),
            (Figure::AccelWalk, "a variance where a deviation belongs"),
        ] {
            let right = case.figures.density(figure).unwrap().largest();
            let wrong = if words.starts_with("degrees") { right * 57.3 } else { right * right };
            let check = check(&case, Format::Kalibr, Some((figure, wrong)));
            let found = check.walks.iter().find(|f| f.figure == figure).unwrap();
            let is_named = found.finding().warns() && found.suspects.contains(&words);
            let is_hidden = hidden.contains(&(case.name, figure, words));
            assert_eq!(is_named, !is_hidden, "{} {words}: {}", case.name, found.finding().text);
        }
    }
}

#[test]
fn a_zero_is_a_warning_with_its_remedy() {
    for case in cases() {
        let given = Given { rate: Some(case.rate), keep_zeros: true, ..Given::default() };
        let text = "acc_n: 0.0\nacc_w: 4e-5\ngyr_n: 0.004\ngyr_w: 0\n";
        let source = parse(text.as_bytes(), Path::new("f"), None, &given).unwrap();
        let check = compare(&source, &case.levels, case.rate).unwrap();
        assert_eq!(check.white[0].standing, Standing::Zero);
        let warned: Vec<String> =
            check.findings().into_iter().filter(Finding::warns).map(|finding| finding.text).collect();
        assert_eq!(warned.len(), 2, "{warned:?}");
        assert!(warned.iter().all(|w| w.contains("put the sensor's figure there")), "{warned:?}");
    }
}
