//! The table of one IMU in all formats, in `docs/src/noise-units.md`: made here, so that it cannot go wrong.
//! `DPN_BLESS=1 cargo test -p dpn-io noise_units` writes it anew.

use super::*;
use dpn_core::noise::{Axes, Figure, ImuFigures};
use dpn_core::time::SampleRate;
use std::path::Path;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/src/noise-units.md");
const BEGIN: &str = "<!-- made by a test: begin -->\n";
const END: &str = "<!-- made by a test: end -->\n";

/// A row a format: key, value and meaning of each figure.
fn table() -> String {
    let figures = ImuFigures::euroc();
    let mut text = String::from(
        "| format | accelerometer noise | accelerometer walk | gyroscope noise | gyroscope walk | the numbers are |\n|---|---|---|---|---|---|\n",
    );
    for format in Format::ALL {
        let Some(layout) = format.layout() else { continue };
        let cells = Figure::ALL.map(|figure| {
            let key = layout.key(figure);
            let value = figures.get(figure, key.meaning, SampleRate::HZ_200).map(Axes::largest).unwrap();
            format!("`{}: {}`<br>{}", key.name, number::short(value), key.meaning.unit(figure))
        });
        let key = layout.key(Figure::AccelWhite);
        let walk = layout.key(Figure::AccelWalk);
        text.push_str(&format!(
            "| {format} | {} | {}; walk: {} |\n",
            cells.join(" | "),
            key.meaning.words(),
            walk.meaning.words()
        ));
    }
    text
}

#[test]
fn noise_units_are_as_the_documentation_has_them() {
    let text = std::fs::read_to_string(FILE).unwrap();
    let (head, rest) = text.split_once(BEGIN).unwrap();
    let (stands, tail) = rest.split_once(END).unwrap();
    let made = table();
    if std::env::var_os("DPN_BLESS").is_some() {
        std::fs::write(Path::new(FILE), format!("{head}{BEGIN}{made}{END}{tail}")).unwrap();
        return;
    }
    assert!(stands == made, "docs/src/noise-units.md is not what the code says; DPN_BLESS=1 writes it anew");
}
