//! Figures as a data sheet has them, in a small YAML file of numbers with units:
//!
//! ```yaml
//! accelerometer_noise: 0.2 mg/sqrt(Hz)
//! gyroscope_noise: 0.66 deg/sqrt(h)
//! gyroscope_walk: 4.0 deg/h/sqrt(h)
//! update_rate: 200
//! ```
//!
//! Any of them may be missing; a bare number is a density in SI units.

use super::calibration::{Given, NoiseCalibration, Zero};
use super::error::{FormatError, at};
use super::format::Format;
use super::key_fault::KeyFault;
use super::keyed;
use super::number::{number, short};
use super::quantity::Quantity;
use super::step::Step;
use super::tree::{Node, Tree};
use crate::unit;
use dpn_core::config::nearest;
use dpn_core::noise::{Figure, ImuFigures};
use std::path::Path;

/// The keys and their figures, in the order of [`Figure::ALL`].
pub(super) const KEYS: [(&str, Figure); 4] = [
    ("accelerometer_noise", Figure::AccelWhite),
    ("accelerometer_walk", Figure::AccelWalk),
    ("gyroscope_noise", Figure::GyroWhite),
    ("gyroscope_walk", Figure::GyroWalk),
];
const RATE: &str = "update_rate";

pub(super) fn read(tree: &Tree, path: &Path, given: &Given) -> Result<NoiseCalibration, FormatError> {
    let mut source = NoiseCalibration::new(Format::Datasheet);
    let blocks = tree.blocks();
    let block = &blocks[0];
    source.figures.rate = keyed::rate(block, [RATE], given, path, &mut source.remarks)?;
    for entry in block.entries {
        if entry.key == RATE {
            continue;
        }
        let known = KEYS.map(|(name, _)| name);
        let Some((name, figure)) = KEYS.into_iter().find(|(name, _)| *name == entry.key) else {
            let nearest = nearest(&entry.key, known).filter(|_| !entry.key.contains("stability"));
            let (known, nearest) = (format!("{}, {RATE}", known.join(", ")), nearest.map(str::to_owned));
            return Err(FormatError::key(path, entry.line, &entry.key, KeyFault::Unknown { known, nearest }));
        };
        let text = match &entry.value.node {
            Node::Number(value) => format!("{value:e}"),
            Node::Text(text) => text.clone(),
            _ => {
                let (found, expected) = (entry.value.shown(), "a number with its unit");
                let fault = KeyFault::NotNumbers { found, expected };
                return Err(FormatError::key(path, entry.line, &entry.key, fault));
            }
        };
        let in_place = |problem| FormatError::Quantity {
            place: format!("{}: `{name}`", at(path, Some(entry.line))),
            problem,
        };
        if given.keep_zeros && Quantity::is_zero(&text) {
            source.zeros.push(Zero { figure, key: name.to_owned(), line: entry.line });
            continue;
        }
        let quantity = Quantity::parse(&text, figure).map_err(in_place)?;
        let rate = source.figures.rate;
        let steps = quantity.into_figures(name, &mut source.figures, rate).map_err(in_place)?;
        source.steps.extend(steps);
    }
    Ok(source)
}

/// The units in which each figure is written, the one that counts first.
const UNITS: [(Figure, [&str; 2]); 4] = [
    (Figure::AccelWhite, ["mg/sqrt(Hz)", "m/s/sqrt(h)"]),
    (Figure::AccelWalk, ["mg/sqrt(h)", "mg/sqrt(s)"]),
    (Figure::GyroWhite, ["deg/s/sqrt(Hz)", "deg/sqrt(h)"]),
    (Figure::GyroWalk, ["deg/h/sqrt(h)", "deg/s/sqrt(s)"]),
];

pub(super) fn write(figures: &ImuFigures) -> (String, Vec<Step>) {
    let mut text = String::from("# data-sheet units\n");
    let mut steps = Vec::new();
    if let Some(rate) = figures.rate {
        text.push_str(&format!("{RATE}: {}  # Hz\n", number(rate.hz())));
    }
    for ((name, figure), (_, units)) in KEYS.into_iter().zip(UNITS) {
        let Some(density) = figures.density(figure) else {
            text.push_str(&format!("# {name}: not known\n"));
            continue;
        };
        let density = density.largest();
        let values = units.map(|unit| (unit, unit::parse(unit).expect("UNITS are units").scale));
        for (unit, scale) in values {
            steps.push(Step {
                name: name.to_owned(),
                from: format!("{} {} / {}", number(density), figure.unit(), number(scale)),
                result: format!("{} {unit}", number(density / scale)),
                meaning: "density",
            });
        }
        let [(first, a), (second, b)] = values;
        text.push_str(&format!(
            "{name}: {} {first}  # = {} {second}\n",
            number(density / a),
            short(density / b)
        ));
    }
    (text, steps)
}
