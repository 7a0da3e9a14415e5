//! One flight: a raw signal above, the deviation that models estimate for it below (logarithmic), on one time axis, with the
//! phases of the flight, the true deviation where it is known, and the upper end of what the models were trained on.

use super::axis::Axis;
use super::chart::{Chart, Layer, Panel, pale};
use super::error::FigureError;
use super::flight::{Flight, Phase};
use super::frame::{ABOVE, BELOW, LEFT, RIGHT, Rect};
use super::legend::{self, Entry, Key};
use super::plot::{Drawn, row};
use super::sheet::Sheet;
use super::style::{self, Anchor, PALETTE};
use super::summary::{Column, columns, extent};
use plotters::style::{Color, RGBColor};

const UPPER: i32 = 300;
const BETWEEN: i32 = 36;
const LOWER: i32 = 420;
/// Pixels of the time axis.
const ROOM: i32 = style::WIDTH as i32 - LEFT - RIGHT;
/// Pixels a column of an estimate.
const COARSE: i32 = 4;
/// Paper tints of phases, by label in order of appearance.
const TINTS: [RGBColor; 4] = [
    RGBColor(0xEA, 0xF2, 0xF9),
    RGBColor(0xFC, 0xF2, 0xE0),
    RGBColor(0xFA, 0xFA, 0xFA),
    RGBColor(0xE9, 0xF5, 0xEF),
];

/// One flight, thinned to what the paper can show.
///
/// # Errors
/// [`FigureError`] when there is nothing to draw, a column is of another length, a value is not finite, or time does not
/// ascend.
pub fn flight_sigma(flight: &Flight<'_>) -> Result<Chart, FigureError> {
    flight.check()?;
    let (start, end) = (flight.t[0], flight.t[flight.t.len() - 1]);
    let coarse = (ROOM / COARSE) as usize;
    let signal = columns(flight.t, flight.signal, ROOM as usize);
    let models: Vec<(String, Vec<Column>)> = flight
        .models
        .iter()
        .map(|(name, sigma)| ((*name).to_owned(), columns(flight.t, sigma, coarse)))
        .collect();
    let truth = flight.truth.map_or_else(Vec::new, |truth| columns(flight.t, truth, coarse));
    let phases: Vec<Phase> = flight
        .phases
        .iter()
        .map(|phase| Phase {
            label: phase.label.clone(),
            from: phase.from.clamp(start, end),
            to: phase.to.clamp(start, end),
        })
        .filter(|phase| phase.to > phase.from)
        .collect();
    let unit = style::unit(flight.sensor);
    let (low, high) = extent(signal.iter().flat_map(|c| [c.low, c.high]));
    let pad = 0.05 * (high - low);
    let (sigma_axis, at_edge) = sigma_axis(flight, &models, &truth, unit);
    let time = Axis::linear("time [s]".into(), start, end, 10);
    let pixels = f64::from(ROOM) / (end - start);
    let phases_in_legend = phases.iter().any(|phase| {
        f64::from(style::width(&phase.label, style::CAPTION) + 8) > (phase.to - phase.from) * pixels
    });
    let legend = legend_of(flight, &phases, phases_in_legend);
    let caption = format!(
        "{} samples. Signal: smallest to largest sample in each pixel column. Estimates: median (line) and range (band) \
         in columns of {COARSE} pixels ({:.2} s).{}{}{}",
        style::grouped(flight.t.len()),
        f64::from(COARSE) / pixels,
        if at_edge { " Estimates of 0 or below lie at the lower edge." } else { "" },
        if flight.words.is_empty() { "" } else { " " },
        flight.words,
    );
    let sheet = Sheet {
        title: format!("{}: {} {}", flight.name, style::title(flight.sensor).to_lowercase(), flight.axis),
        head: ABOVE,
        ..Sheet::new(legend, ABOVE + UPPER + BETWEEN + LOWER + BELOW, caption)
    };
    let signal_axis = Axis::linear(format!("signal [{unit}]"), low - pad, high + pad, 7);
    let mut upper = ground(&phases);
    upper.extend(borders(&phases, &signal_axis));
    upper.push(Layer::Envelope(signal.clone(), pale(RGBColor(0x55, 0x55, 0x55), 1.0)));
    upper.push(Layer::Axes(false));
    if !phases_in_legend {
        let x = |t| (time.fraction(t) * f64::from(ROOM)).round() as i32;
        upper.extend(phases.iter().map(|phase| {
            let at = ((x(phase.from) + x(phase.to)) / 2, -16);
            Layer::Words(phase.label.clone(), style::CAPTION, style::MUTED, Anchor::Centre, at)
        }));
    }
    let mut lower = ground(&phases);
    lower.extend(borders(&phases, &sigma_axis));
    lower.extend(limit(&time, flight.trained_up_to));
    let coloured = || models.iter().zip(PALETTE);
    lower.extend(
        coloured().map(|((_, columns), colour)| Layer::Envelope(columns.clone(), pale(colour, 0.22))),
    );
    lower.extend(coloured().flat_map(|((_, columns), colour)| Layer::medians(columns, colour)));
    lower.extend(Layer::medians(&truth, style::INK));
    lower.push(Layer::Axes(true));

    let mut rows = Vec::new();
    let mut add = |series: &str, columns: &[Column]| {
        let unit = flight.sensor.unit();
        rows.extend(columns.iter().map(|c| row![series, unit, c.t, c.low, c.middle, c.high]));
    };
    add("signal", &signal);
    for (name, columns) in &models {
        add(name, columns);
    }
    add("true", &truth);
    let header = vec!["series", "unit", "t_s", "low", "median", "high"];
    let place = |top, height| Rect { left: LEFT, top, right: LEFT + ROOM, bottom: top + height };
    let panels = vec![
        Panel { place: place(ABOVE, UPPER), x: time.clone(), y: signal_axis, layers: upper },
        Panel { place: place(ABOVE + UPPER + BETWEEN, LOWER), x: time, y: sigma_axis, layers: lower },
    ];
    Ok(Chart::new(sheet, panels, Drawn { header, rows }))
}

/// Where one phase follows another.
fn borders(phases: &[Phase], y: &Axis) -> impl Iterator<Item = Layer> {
    phases.windows(2).map(|pair| {
        let t = pair[1].from;
        Layer::Line(vec![(t, y.high()), (t, y.low())], style::stroke(style::MUTED.mix(0.6), style::THIN))
    })
}

/// The axis of the deviations, and whether some of them cannot be placed on it.
fn sigma_axis(
    flight: &Flight<'_>,
    models: &[(String, Vec<Column>)],
    truth: &[Column],
    unit: &str,
) -> (Axis, bool) {
    let all = || models.iter().flat_map(|(_, columns)| columns).chain(truth);
    let positive = || all().flat_map(|c| [c.low, c.middle, c.high]).filter(|v| *v > 0.0);
    let limit = flight.trained_up_to.unwrap_or(0.0);
    let high = positive().fold(limit, f64::max);
    // Five decades are enough to see; what is lower is held at the edge.
    let low = positive().fold(high, f64::min).max(high * 1e-5);
    let at_edge = all().any(|c| c.low <= 0.0);
    let (low, high) = if high > 0.0 { (low, high) } else { (0.1, 1.0) };
    (Axis::log(format!("estimated σ [{unit}]"), low / 1.3, high * 1.3), at_edge)
}

fn legend_of(flight: &Flight<'_>, phases: &[Phase], phases_in_legend: bool) -> Vec<Entry> {
    let entry = |key, colour, words: &str| Entry { key, colour, words: words.to_owned() };
    let mut legend = legend::entries(Key::Line, flight.models.iter().map(|(name, _)| *name));
    if flight.truth.is_some() {
        legend.push(entry(Key::Line, style::INK, "true σ"));
    }
    if let Some(limit) = flight.trained_up_to {
        let words = format!("trained up to {limit} {}", style::unit(flight.sensor));
        legend.push(entry(Key::Dashed, style::INK, &words));
    }
    if phases_in_legend {
        for label in labels(phases) {
            legend.push(entry(Key::Tint, tint(phases, label), label));
        }
    }
    legend
}

/// Labels of phases in order of appearance, each once.
pub(super) fn labels(phases: &[Phase]) -> Vec<&str> {
    let mut labels: Vec<&str> = Vec::new();
    for phase in phases {
        if !labels.contains(&phase.label.as_str()) {
            labels.push(&phase.label);
        }
    }
    labels
}

pub(super) fn tint(phases: &[Phase], label: &str) -> RGBColor {
    let index = labels(phases).iter().position(|known| *known == label).expect("a label of these phases");
    TINTS[index % TINTS.len()]
}

/// The tints of phases, and the grid on them.
pub(super) fn ground(phases: &[Phase]) -> Vec<Layer> {
    let stripe = |phase: &Phase| Layer::Stripe([phase.from, phase.to], tint(phases, &phase.label));
    phases.iter().map(stripe).chain([Layer::Grid]).collect()
}

/// The upper end of what models were trained on.
pub(super) fn limit(x: &Axis, limit: Option<f64>) -> Option<Layer> {
    let line = vec![(x.low(), limit?), (x.high(), limit?)];
    Some(Layer::Dashed(line, style::stroke(style::INK, style::THIN + 1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Plot, svg};
    use dpn_core::Sensor;

    fn flight<'a>(t: &'a [f64], signal: &'a [f64], sigma: &'a [f64]) -> Flight<'a> {
        Flight {
            name: "MH_04",
            sensor: Sensor::Accel,
            axis: "z",
            t,
            signal,
            models: vec![("network", sigma)],
            truth: Some(sigma),
            phases: vec![Phase { label: "at rest".into(), from: -5.0, to: 1.0 }],
            trained_up_to: Some(0.21),
            words: "",
        }
    }

    #[test]
    fn a_short_flight_is_drawn_sample_by_sample() {
        let t = [0.0, 0.5, 1.0, 1.5, 2.0];
        let (signal, sigma) = ([9.8, 9.9, 9.7, 10.1, 9.6], [0.1, 0.2, 0.1, 0.0, 0.3]);
        let plot = flight_sigma(&flight(&t, &signal, &sigma)).unwrap();
        let csv = plot.csv();
        assert_eq!(csv.rows.len(), 15);
        for (i, row) in csv.rows.iter().enumerate() {
            let numbers: Vec<f64> = row[2..].iter().map(|v| v.parse().unwrap()).collect();
            let value = if i < 5 { signal[i] } else { sigma[i % 5] };
            assert_eq!(numbers, [t[i % 5], value, value, value], "{row:?}");
        }
        let text = String::from_utf8(svg(&plot).unwrap()).unwrap();
        for words in [
            "time [s]",
            "signal [m/s²]",
            "estimated σ [m/s²]",
            "at rest",
            "trained up to 0.21 m/s²",
            "Estimates of 0 or",
        ] {
            assert!(text.contains(words), "{words}");
        }
    }

    #[test]
    fn a_long_flight_stays_small_and_keeps_its_extremes() {
        let t: Vec<f64> = (0..36_000).map(|i| f64::from(i) * 0.005).collect();
        let signal: Vec<f64> = (0..36_000).map(|i| f64::from((i * 7919) % 1000) / 100.0).collect();
        let plot = flight_sigma(&flight(&t, &signal, &signal)).unwrap();
        let rows = plot.csv().rows;
        let highs: Vec<f64> =
            rows.iter().filter(|row| row[0] == "signal").map(|row| row[5].parse().unwrap()).collect();
        assert!(highs.len() <= ROOM as usize);
        assert_eq!(highs.into_iter().fold(0.0, f64::max), 9.99);
        assert!(svg(&plot).unwrap().len() < 150_000);
    }
}
