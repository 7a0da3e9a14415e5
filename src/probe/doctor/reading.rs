//! What the reader of a log had to leave out or guess.

use crate::finding::Finding;
use crate::text::instrument;
use dpn_core::{Recorded, Samples};
use dpn_io::LeftOut;
use dpn_logs::Log;

/// Share of samples left out from which the log is bad.
const MANY: f64 = 0.001;
/// How far the stamps' rate may be from the one that the log's text names.
const RATES_APART: f64 = 0.02;

pub(super) fn findings(log: &Log) -> Vec<Finding> {
    let mut findings = Vec::new();
    if let Some(damage) = &log.damage {
        findings.push(Finding::bad(
            "damage",
            format!("{damage}; the {} samples before it are used", log.recording.len()),
            "copy or record it again",
        ));
    }
    if let Some(sensor) = log.alone {
        findings.push(Finding::bad(
            "sensors",
            format!("the log has the {} alone", instrument(sensor)),
            "give the folder in which the other sensor's file lies too, or say which columns are its (--columns): an odometry needs both; what is found here is of this one",
        ));
    }
    if let Some(text) = log.parts_words() {
        let remedy = if log.others.iter().any(|part| part.is_among) {
            "record each on a topic, or in a file, of its own: an odometry fed with both goes wrong"
        } else {
            "cut the log there; look for a clock that was set, a counter that began anew, or several recordings in one file"
        };
        findings.push(Finding::bad("parts", text, remedy));
    }
    if let Some(text) = &log.clocks {
        findings.push(Finding::bad(
            "clock",
            text.clone(),
            "look at the driver: one clock must stamp both sensors, before any odometry is fed with them",
        ));
    }
    let all = log.recording.len() + log.sieved.count();
    let mut left = |about: &'static str, left: &LeftOut, [words, then]: [&str; 2], remedy: &'static str| {
        let Some(first) = left.first else { return };
        let text =
            format!("left out: {} sample(s) {words}, first at {} {first}{then}", left.count, log.place);
        findings.push(Finding::bad_where(left.count as f64 > MANY * all as f64, about, text, remedy));
    };
    let sieved = &log.sieved;
    left(
        "stamps",
        &sieved.repeated,
        ["with the stamp of the one before", &log.coarse_words()],
        "write stamps with more digits, count them (--rate), or look for a message that is published twice",
    );
    left(
        "stamps",
        &sieved.backward,
        ["whose stamp goes back", ""],
        "look for a clock that was set, or for two writers",
    );
    left(
        "values",
        &sieved.not_finite,
        ["with NaN or infinite values", ""],
        "look at the driver: a failed read should be no sample",
    );
    left(
        "values",
        &sieved.absurd,
        ["with values beyond 1e12 or below 1e-150, which no sensor measures", ""],
        "look at the driver: a failed read should be no sample",
    );
    findings.extend(
        log.remarks.iter().map(|remark| Finding::warning("rows", remark.clone(), "look at what wrote them")),
    );
    let hz = log.recording.rate().hz();
    if let Some(said) = log.said_hz.filter(|said| (hz / said - 1.0).abs() > RATES_APART) {
        findings.push(Finding::warning(
            "rate",
            format!("the log's text says {said} Hz, its stamps {hz:.2} Hz"),
            "look at the unit and column of the stamps (--time-unit, --columns), or for samples that were not written",
        ));
    }
    if !log.guesses.is_empty() {
        findings.push(Finding::note("taken for granted", log.guesses.join(", ")));
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::examine_log;
    use crate::doctor::values::tests::level;
    use crate::finding::Weight;
    use dpn_core::ImuRecording;
    use dpn_io::Sieved;
    use dpn_logs::Kind;

    #[test]
    fn a_rate_that_the_text_names_and_the_stamps_do_not_have_is_a_finding() {
        let mut log = Log::sound(Kind::Csv, ImuRecording::new(level(10)).unwrap());
        log.said_hz = Some(200.0);
        assert_eq!(findings(&log), []);
        log.said_hz = Some(100.0);
        assert_eq!(findings(&log)[0].text, "the log's text says 100 Hz, its stamps 200.00 Hz");
    }

    #[test]
    fn damage_and_left_out_samples_are_findings_by_weight() {
        let mut log = Log::sound(Kind::Rosbag1, ImuRecording::new(level(10)).unwrap());
        assert_eq!(findings(&log), []);
        log.place = "message";
        log.damage = Some("cut off in the chunk at byte 4117".into());
        log.sieved = Sieved {
            backward: LeftOut { count: 1, first: Some(7) },
            not_finite: LeftOut { count: 40, first: Some(9) },
            ..Sieved::default()
        };
        let found = examine_log(&log).unwrap().findings;
        let of = |about: &str| found.iter().find(|f| f.about == about).unwrap();
        assert_eq!(
            of("damage").text,
            "cut off in the chunk at byte 4117; the 2000 samples before it are used"
        );
        assert_eq!((of("stamps").weight, of("values").weight), (Weight::Warning, Weight::Bad));
        assert_eq!(of("stamps").text, "left out: 1 sample(s) whose stamp goes back, first at message 7");
        assert_eq!(found[0].weight, Weight::Bad);
    }

    #[test]
    fn stamps_coarser_than_the_samples_are_named_with_their_remedy() {
        let mut log = Log::sound(Kind::Csv, ImuRecording::new(level(10)).unwrap());
        log.sieved.repeated = LeftOut { count: 100, first: Some(3) };
        assert!(!findings(&log)[0].text.contains("--rate"));
        // As many again: 200 Hz are left of 400.
        log.sieved.repeated.count = 2000;
        let words = "unless these are copies, samples come at 400.2 Hz, not 200.0, and densities are 1.41 times too large: --rate 400.2 counts them";
        assert!(findings(&log)[0].text.ends_with(words), "{:?}", findings(&log));
        assert!(log.warnings()[0].ends_with(words));
    }
}
