//! From figures to the text of a configuration.

use super::error::FormatError;
use super::format::Format;
use super::keyed::{self, Line};
use super::number::{number, short};
use super::step::{Remark, Step};
use super::{datasheet, layouts, ros, vins};
use dpn_core::noise::{Axes, Figure, ImuFigures};
use dpn_core::time::SampleRate;
use serde::Serialize;

/// A text to paste, and how its numbers came to be.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Written {
    /// The format.
    pub format: Format,
    /// The keys with their values and units.
    pub text: String,
    /// The arithmetic from densities to the text's numbers.
    pub steps: Vec<Step>,
    /// What should be known about them.
    pub remarks: Vec<Remark>,
}

/// Writes `figures` as `format`; `note` may say a word on each figure, which stands beside it where the format has comments.
///
/// # Errors
/// A format that counts per sample, and figures without a rate; no figure at all.
pub fn write(
    figures: &ImuFigures,
    format: Format,
    note: impl Fn(Figure) -> Option<String>,
) -> Result<Written, FormatError> {
    if Figure::ALL.iter().all(|figure| figures.density(*figure).is_none()) {
        return Err(FormatError::Nothing);
    }
    let rate = match figures.rate {
        Some(rate) => rate,
        None if format.needs_rate() => return Err(FormatError::NeedsRate { format }),
        None => SampleRate::HZ_200, // densities do not ask
    };
    let rate_text = figures.rate.map(|rate| number(rate.hz()));
    let rate_text = rate_text.as_deref();
    let mut remarks = remarks(figures, format);
    if format == Format::Datasheet {
        let (text, steps) = datasheet::write(figures);
        return Ok(Written { format, text, steps, remarks });
    }
    let lines = match format.layout() {
        Some(layout) => layout
            .keys
            .into_iter()
            .map(|key| Line {
                key,
                values: figures.get(key.figure, key.meaning, rate).map(|values| match values {
                    Axes::Each(_) if !layout.per_axis => Axes::Same(values.largest()),
                    Axes::Same(value) if format == Format::Basalt => Axes::Each([value; 3]),
                    values => values,
                }),
                note: note(key.figure),
            })
            .collect(),
        None => ros::lines(figures, rate),
    };
    let steps = lines
        .iter()
        .filter_map(|line| Some(keyed::written_step(line.key, figures, line.values?, rate)))
        .collect();
    let text = match format.layout() {
        Some(layout) => layouts::write(layout, &lines, rate_text),
        None => ros::write(&lines, &short(rate.hz())),
    };
    if format == Format::Vins {
        remarks.extend(vins::written(figures, rate));
    }
    Ok(Written { format, text, steps, remarks })
}

/// What the format cannot say.
fn remarks(figures: &ImuFigures, format: Format) -> Vec<Remark> {
    let mut remarks = Vec::new();
    let per_axis = format == Format::Ros || format.layout().is_some_and(|layout| layout.per_axis);
    for figure in Figure::ALL {
        match figures.density(figure) {
            Some(Axes::Each(values)) if !per_axis => {
                let largest = Axes::Each(values).largest();
                let least = values.into_iter().fold(largest, f64::min);
                remarks.push(Remark(format!(
                    "{format} has one {figure} for all axes: the largest is written ({} against {} {})",
                    short(largest),
                    short(least),
                    figure.unit()
                )));
            }
            Some(_) if figure.is_walk() && format == Format::Ros => {
                remarks.push(Remark(format!("{format} has no place for the {figure}; it is lost")));
            }
            None if !(figure.is_walk() && format == Format::Ros) => remarks.push(Remark(format!(
                "the {figure} is not known; give --{} NUMBER, or {format} lacks it",
                figure.flag()
            ))),
            _ => {}
        }
    }
    remarks
}
