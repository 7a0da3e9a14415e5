//! Reading and writing formats that are four keys of numbers.

use super::calibration::{Given, NoiseCalibration, Zero};
use super::error::{FormatError, Slip, at};
use super::format::Format;
use super::key_fault::KeyFault;
use super::layout::{Key, Layout};
use super::number::{AxesText, short};
use super::step::{Remark, Step};
use super::tree::{Block, Entry, Tree};
use dpn_core::config::nearest;
use dpn_core::noise::units::BadNoise;
use dpn_core::noise::{Axes, Figure, ImuFigures};
use dpn_core::time::SampleRate;
use std::path::Path;

/// A key with its values as they will be written; `None` where they are not known.
#[derive(Debug, Clone)]
pub(super) struct Line {
    pub key: Key,
    pub values: Option<Axes<f64>>,
    /// Why the value is what it is, where that is worth a word.
    pub note: Option<String>,
}

/// Lines of YAML with their units.
pub(super) fn yaml(lines: &[Line], indent: &str) -> String {
    let mut text = String::new();
    for Line { key, values, note } in lines {
        let unit = key.meaning.unit(key.figure);
        let note = note.as_ref().map(|n| format!("; {n}")).unwrap_or_default();
        match values {
            Some(values) => {
                text.push_str(&format!("{indent}{}: {}  # {unit}{note}\n", key.name, values.text()));
            }
            None => text.push_str(&format!("{indent}# {}: not known  # {unit}{note}\n", key.name)),
        }
    }
    text
}

/// The mapping that holds most of `names`.
pub(super) fn block<'a>(tree: &'a Tree, names: &[&str]) -> Option<(Block<'a>, Vec<Block<'a>>)> {
    let count = |block: &Block<'_>| names.iter().filter(|name| block.get(name).is_some()).count();
    let mut holding: Vec<Block<'a>> = tree.blocks().into_iter().filter(|block| count(block) > 0).collect();
    let most = holding.iter().map(&count).max()?;
    let first = holding.iter().position(|block| count(block) == most)?;
    let found = holding.remove(first);
    Some((found, holding))
}

/// The rate: the flag, else the file's key.
pub(super) fn rate(
    block: &Block<'_>,
    names: impl IntoIterator<Item = &'static str>,
    given: &Given,
    path: &Path,
    remarks: &mut Vec<Remark>,
) -> Result<Option<SampleRate>, FormatError> {
    for name in names {
        let Some(entry) = block.get(name) else { continue };
        let bad =
            || FormatError::key(path, entry.line, name, KeyFault::BadRate { found: entry.value.shown() });
        let value = match entry.value.numbers().as_deref() {
            Some([value]) => *value,
            _ => return Err(bad()),
        };
        let file = SampleRate::from_hz(value).ok_or_else(bad)?;
        if let Some(counts) = given.rate
            && (counts.hz() / file.hz() - 1.0).abs() > 0.01
        {
            let (counts, of_log) = (short(counts.hz()), given.rate_of_log);
            let other = match of_log {
                true => format!(
                    "but the log has {counts} Hz: mend the key, or look at the log's rate; the log's counts here"
                ),
                false => format!("but --rate {counts} counts"),
            };
            remarks.push(Remark(format!(
                "{}: `{name}` is {} Hz, {other}",
                at(path, Some(entry.line)),
                short(file.hz())
            )));
        }
        return Ok(Some(given.rate.unwrap_or(file)));
    }
    Ok(given.rate)
}

/// One positive number, or three: x, y, z, or the diagonal of nine. None where one of them is zero and `keep_zeros`.
pub(super) fn axes(
    entry: &Entry,
    path: &Path,
    keep_zeros: bool,
    remarks: &mut Vec<Remark>,
) -> Result<Option<Axes<f64>>, FormatError> {
    let Entry { key, line, value } = entry;
    let bad = |fault| FormatError::key(path, if value.line > 0 { value.line } else { *line }, key, fault);
    let values = match value.numbers().as_deref() {
        Some([one]) => Axes::Same(*one),
        Some([x, y, z]) => Axes::Each([*x, *y, *z]),
        Some(nine @ [x, _, _, _, y, _, _, _, z]) => {
            if nine.iter().enumerate().any(|(i, v)| i % 4 != 0 && *v != 0.0) {
                remarks.push(Remark(format!(
                    "{}: `{key}` ties axes to each other; only its diagonal is used",
                    at(path, Some(*line))
                )));
            }
            Axes::Each([*x, *y, *z])
        }
        _ => {
            return Err(bad(KeyFault::NotNumbers {
                found: value.shown(),
                expected: "one number, or three (x, y, z),",
            }));
        }
    };
    for value in values.each() {
        if !(value.is_finite() && (value > 0.0 || keep_zeros && value == 0.0)) {
            return Err(bad(KeyFault::NotPositive { value }));
        }
    }
    if values.each().contains(&0.0) {
        return Ok(None);
    }
    Ok(Some(match values {
        Axes::Each([x, y, z]) if x == y && y == z => Axes::Same(x),
        values => values,
    }))
}

/// Reads the four keys.
pub(super) fn read(
    tree: &Tree,
    format: Format,
    layout: &Layout,
    path: &Path,
    given: &Given,
) -> Result<NoiseCalibration, FormatError> {
    let names = layout.keys.map(|key| key.name);
    let mut source = NoiseCalibration::new(format);
    let Some((block, others)) = block(tree, &names) else {
        return Err(missing(tree, format, layout, path, &layout.keys));
    };
    if let Some(other) = others.first() {
        source.remarks.push(Remark(format!(
            "{}: several blocks have noise figures; read {}, not {}",
            path.display(),
            named(&block.path),
            named(&other.path)
        )));
    }
    let rate_keys = layout.rate.into_iter().chain(layout.other_rates.iter().copied());
    let rate = rate(&block, rate_keys, given, path, &mut source.remarks)?;
    source.figures.rate = rate;
    let mut lacking = Vec::new();
    for key in layout.keys {
        let Some(entry) = block.get(key.name) else {
            if given.quantity(key.figure).is_none() && (layout.walks_required || !key.figure.is_walk()) {
                lacking.push(key);
            }
            continue;
        };
        let Some(values) = axes(entry, path, given.keep_zeros, &mut source.remarks)? else {
            source.zeros.push(Zero { figure: key.figure, key: key.name.to_owned(), line: entry.line });
            continue;
        };
        let rate = match rate {
            Some(rate) => rate,
            None if key.meaning.needs_rate() => return Err(FormatError::NeedsRate { format }),
            None => SampleRate::HZ_200, // densities do not ask
        };
        let bad = |bad: BadNoise| {
            FormatError::key(path, entry.line, key.name, KeyFault::NotPositive { value: bad.0 })
        };
        source.figures.set(key.figure, key.meaning, values, rate).map_err(bad)?;
        source.steps.push(Step::to_density(key.name, key.figure, key.meaning, values, &source.figures, rate));
    }
    if !lacking.is_empty() {
        return Err(missing(tree, format, layout, path, &lacking));
    }
    Ok(source)
}

fn named(path: &str) -> String {
    if path.is_empty() { "the one at the top".into() } else { format!("`{path}`") }
}

/// From a density to a key's number.
pub(super) fn written_step(key: Key, figures: &ImuFigures, written: Axes<f64>, rate: SampleRate) -> Step {
    let density = figures.density(key.figure).map(|d| match written {
        Axes::Same(_) => Axes::Same(d.largest()),
        Axes::Each(_) => d,
    });
    let number = format!("{} {}", density.map_or_else(String::new, AxesText::text), key.figure.unit());
    Step {
        name: key.name.to_owned(),
        from: key.meaning.of_density_words(&number, &format!("{} Hz", short(rate.hz()))),
        result: format!("{} {}", written.text(), key.meaning.unit(key.figure)),
        meaning: key.meaning.words(),
    }
}

fn missing(tree: &Tree, format: Format, layout: &Layout, path: &Path, lacking: &[Key]) -> FormatError {
    let names = layout.keys.map(|key| key.name);
    FormatError::Missing {
        path: path.to_path_buf(),
        from: format,
        missing: lacking.iter().map(|key| key.name.to_owned()).collect(),
        figures: lacking.iter().map(|key| key.figure).collect::<Vec<Figure>>(),
        nearest: slip(tree, lacking.iter().map(|key| key.name), &names),
        rather: None,
    }
}

/// A key of the file that is nearly one of `wanted`, and none of `known`.
// An iterator is handed over as one; it is cloned because it is gone through once an entry.
#[allow(clippy::needless_pass_by_value)]
pub(super) fn slip<'a>(
    tree: &Tree,
    wanted: impl Iterator<Item = &'a str> + Clone,
    known: &[&str],
) -> Option<Box<Slip>> {
    tree.blocks().iter().flat_map(|block| block.entries).find_map(|entry| {
        let plain = |text: &str| text.to_lowercase();
        if known.contains(&entry.key.as_str()) {
            return None;
        }
        // Half as much tolerance as for our own files: others have many keys that are nobody's slip.
        let near =
            nearest(&plain(&entry.key), wanted.clone().filter(|w| entry.key.len().abs_diff(w.len()) <= 3))
                .filter(|w| strsim::damerau_levenshtein(&plain(&entry.key), &plain(w)) <= 1 + w.len() / 8)
                .map(str::to_owned);
        let same = wanted.clone().find(|w| plain(w) == plain(&entry.key)).map(str::to_owned);
        Some(Box::new(Slip { line: entry.line, typed: entry.key.clone(), known: same.or(near)? }))
    })
}
