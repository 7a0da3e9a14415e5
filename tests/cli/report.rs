//! `dpn report`.

use crate::recording::{rows, sound, text};
use crate::run::{dpn, end, files};

#[test]
fn a_report_is_one_file_that_fetches_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let still = dir.path().join("still.csv");
    // 40 s at rest, with a gap.
    let mut samples = rows(8200, 5_000_000);
    samples.drain(8000..8100);
    std::fs::write(&still, text(&samples)).unwrap();
    let out = dir.path().join("out/report.html");
    let report = |logs: &[&std::path::Path]| end(dpn().arg("report").args(logs).arg("--out").arg(&out));
    assert!(report(&[&still]).well().stdout.contains("1 log(s)"));
    assert_eq!(files(&dir.path().join("out")).into_keys().collect::<Vec<_>>(), ["report.html"]);
    let page = std::fs::read_to_string(&out).unwrap();
    for words in [
        "bad: gaps.",
        "<h2>Spectra</h2>",
        "Spectra along the log",
        "Allan deviation at rest",
        "Noise at rest",
        "<summary>kalibr</summary>",
    ] {
        assert!(page.contains(words), "{words}");
    }
    for fetches in ["http:", "https:", "<script", "<link rel=\"stylesheet\"", "url("] {
        // Names of a picture's vocabulary are no addresses.
        assert!(!page.replace("http://www.w3.org/2000/svg", "").contains(fetches), "{fetches}");
    }
    // Several: a section each, and what cannot be read says so.
    let none = dir.path().join("none.csv");
    std::fs::write(&none, "no log\n").unwrap();
    let sequence = sound(dir.path());
    let figures = dir.path().join("figures");
    let with_figures = |logs: &[&std::path::Path]| {
        end(dpn().arg("report").args(logs).arg("--out").arg(&out).arg("--figures").arg(&figures)).well()
    };
    with_figures(&[&still, &none, &sequence.join("still")]);
    let left = files(&figures);
    assert!(
        left.contains_key("1-still/allan.pdf") && left.contains_key("3-still/spectrogram.svg"),
        "{left:?}"
    );
    let page = std::fs::read_to_string(&out).unwrap();
    assert!(page.contains("What 3 logs say") && page.contains("It cannot be read: "), "{page}");
    assert_eq!(report(&[&none]).code, Some(2));
}
