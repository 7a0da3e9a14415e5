//! All faults on four recordings: what is said of each, and what it costs.

use super::kinds::{FAULTS, SOUND};
use super::{Outcome, Sound};
use dpn_eval::closed_loop::{RunSource, SequenceSet, TrackSource};
use dpn_testing::packs;
use rayon::prelude::*;
use serde_json::{Value, json};

/// The recordings: tracks of a front-end of other people's, images in flight, images rendered, a camera held in hand.
fn sounds() -> Option<Vec<Sound>> {
    let [tracks, motion, euroc, handheld] = packs(["tracks", "motion", "euroc", "handheld"])?;
    let images = || TrackSource::Images { skip_missing: false };
    let of = |dir: &std::path::Path, source| SequenceSet::one(dir, source).unwrap();
    let bedroom = handheld.join("bedroom");
    let calibration = dpn_io::calibration::read(&bedroom.join("camchain.yaml")).unwrap();
    let held = RunSource {
        calibration: Some(calibration),
        truth: Some(bedroom.join("sfm.tum")),
        ..RunSource::default()
    };
    let (held, _) = held.one(bedroom.to_str().unwrap()).unwrap();
    Some(vec![
        Sound::of(&of(&euroc.join("V1_02_medium"), TrackSource::File(tracks)), [0.0, 30.0], false),
        Sound::of(&of(&motion.join("MH_01_easy_start"), images()), [0.0, 20.0], false),
        Sound::of(
            &of(&euroc.join("V2_02_medium"), TrackSource::Rendered(Box::default())),
            [0.0, 20.0],
            false,
        ),
        Sound::of(&held, [18.0, 45.0], true),
    ])
}

/// As in the book's chapter; `DPN_FAULTS=FILE` writes it.
#[test]
#[ignore = "a quarter of an hour"]
fn no_fault_is_silent() {
    let Some(sounds) = sounds() else { return };
    let wanted = std::env::var("DPN_FAULTS_ONLY").unwrap_or_default();
    let of = std::env::var("DPN_FAULTS_OF").unwrap_or_default();
    let rows: Vec<Value> = sounds
        .iter()
        .filter(|sound| sound.name().contains(&of))
        .flat_map(|sound| {
            let clean = sound.run(&SOUND);
            assert!(clean.found.is_some() && !clean.distrusted, "{}: {:?}", sound.name(), clean.said);
            let faults: Vec<_> =
                FAULTS.iter().filter(|f| sound.takes(f) && f.name.contains(&wanted)).collect();
            let mut rows = vec![row(sound.name(), SOUND.name, &clean, &clean)];
            rows.par_extend(
                faults.par_iter().map(|fault| row(sound.name(), fault.name, &sound.run(fault), &clean)),
            );
            rows
        })
        .collect();
    let count = |key: &str| rows.iter().filter(|row| row["is"] == key).count();
    eprintln!("silent {}, harmless {}, of {}", count("silent"), count("harmless"), rows.len());
    if let Ok(file) = std::env::var("DPN_FAULTS") {
        std::fs::write(file, serde_json::to_string_pretty(&rows).unwrap()).unwrap();
    }
    let silent = rows.iter().filter(|row| row["is"] == "silent");
    let silent: Vec<_> =
        silent.map(|row| [&row["recording"], &row["fault"]].map(|of| of.as_str().unwrap())).collect();
    assert!(silent.is_empty(), "{silent:?}");
}

fn row(recording: &str, fault: &str, outcome: &Outcome, sound: &Outcome) -> Value {
    let said: Vec<_> = outcome.said.iter().filter(|line| !sound.said.contains(line)).collect();
    let names: Vec<_> = outcome.names.difference(&sound.names).collect();
    let is = match (outcome.harmed(sound), names.is_empty() && said.is_empty()) {
        (true, true) => "silent",
        (_, false) => "said",
        (false, true) => "harmless",
    };
    let scale = outcome.found.zip(sound.found).map(|((_, scale), (_, of))| scale / of);
    let row = json!({
        "recording": recording, "fault": fault, "is": is, "error_m": outcome.found.map(|(error, _)| error),
        "scale": scale, "distrusted": outcome.distrusted, "names": names, "said": said,
    });
    eprintln!("{row}");
    row
}

/// A few of them in seconds; the table has all.
#[test]
fn a_sound_recording_is_trusted_and_faults_that_cost_much_are_said() {
    let Some([tracks, euroc]) = packs(["tracks", "euroc"]) else { return };
    let source = SequenceSet::one(&euroc.join("V1_02_medium"), TrackSource::File(tracks)).unwrap();
    let recording = Sound::of(&source, [0.0, 16.0], false);
    let sound = recording.run(&SOUND);
    assert!(sound.found.is_some() && sound.names.is_empty(), "{:?}", sound.said);
    for (fault, name) in [
        ("accelerometer x1.1", "gravity"),
        ("accelerometer y negated", "levels"),
        ("gyroscope z negated", "mirrored"),
        ("gyroscope x0.9", "scaled"),
        ("camera late by 50 ms", "camera clock"),
        ("camera late by 1 s", "late"),
        ("camera turned by 90 degrees", "turned"),
        ("focal length x1.2", "gyro scale"),
    ] {
        let fault = FAULTS.iter().find(|known| known.name == fault).unwrap();
        let outcome = recording.run(fault);
        assert!(outcome.names.contains(name), "{}: {:?}", fault.name, outcome.said);
    }
}
