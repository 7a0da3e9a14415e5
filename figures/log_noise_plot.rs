//! A log and its noise: for each sensor the signal of its three axes above and the deviation of a sample below (logarithmic), over tinted
//! phases, with the upper end of what a network was trained on. A band along the deviation's lower edge marks when the sensor's windows are
//! unlike those of the training.

use super::axis::Axis;
use super::chart::{Chart, Layer, Panel, pale};
use super::error::FigureError;
use super::flight::Phase;
use super::flight_sigma::{ground, labels, limit, tint};
use super::frame::{ABOVE, BELOW, LEFT, RIGHT, Rect};
use super::legend::{self, Entry, Key};
use super::plot::{Drawn, row};
use super::sheet::Sheet;
use super::style::{self, PALETTE};
use super::summary::{Column, Thinned, extent};
use dpn_core::{Recorded, Sensor};
use dpn_probe::log_noise::{Plan, Track, TrackSummary};
use plotters::style::RGBColor;

const FIGURE: &str = "noise of a log";
const AXES: [&str; 3] = ["x", "y", "z"];
const SIGNAL: i32 = 200;
const SIGMA: i32 = 300;
const BETWEEN: i32 = 30;
/// Pixels of the time axis.
const ROOM: i32 = style::WIDTH as i32 - LEFT - RIGHT;
/// Pixels a column of a deviation.
const COARSE: i32 = 3;
/// Height of the band that marks what is out of range, and its colour.
const BAND: i32 = 14;
const OUTSIDE: RGBColor = RGBColor(0xC0, 0x39, 0x2B);

/// A recording, what `plan` said along it, and the summary of that; `words` end the small print.
///
/// # Errors
/// [`FigureError`] for a track of fewer than two answers, and for samples or answers that cannot be read again.
pub fn log_noise_plot(
    recording: &dyn Recorded,
    track: &Track,
    plan: &Plan<'_>,
    summary: &TrackSummary,
    words: &str,
) -> Result<Chart, FigureError> {
    if track.len() < 2 {
        return Err(FigureError::Empty { figure: FIGURE, what: "pair of answers".into() });
    }
    let start = recording.span()[0];
    let six =
        |of: &dyn Fn(Sensor) -> [f64; 3]| -> Vec<f64> { Sensor::ALL.into_iter().flat_map(of).collect() };
    let mut signal = Thinned::new([0.0, recording.length_s()], ROOM as usize, 6);
    recording.each(0..recording.len(), &mut |s| {
        signal.push(s.t.seconds_since(start), &six(&|sensor| s.of(sensor)));
    })?;
    let (mut first_s, mut last_s) = (f64::NAN, f64::NAN);
    track.each(|answer| {
        last_s = answer.t.seconds_since(start);
        first_s = if first_s.is_nan() { last_s } else { first_s };
        Ok(())
    })?;
    let mut sigma = Thinned::new([first_s, last_s], (ROOM / COARSE) as usize, 6);
    track.each(|answer| {
        sigma.push(answer.t.seconds_since(start), &six(&|sensor| answer.noise.of(sensor)));
        Ok(())
    })?;
    let (mut signal, mut sigma) = (signal.done().into_iter(), sigma.done().into_iter());
    let phases: Vec<Phase> = summary
        .stretches
        .iter()
        .map(|s| Phase { label: s.phase.to_string(), from: s.from_s, to: s.to_s })
        .collect();
    let mut legend = legend::entries(Key::Line, AXES);
    // Roughness is the deviation of white noise: the range's end is comparable with what is drawn.
    let trained_up_to = |sensor| plan.noise.trained_on(sensor).map(|range| range.roughness[1]);
    if Sensor::ALL.into_iter().any(|sensor| trained_up_to(sensor).is_some()) {
        let words = "end of the training's range".to_owned();
        legend.push(Entry { key: Key::Dashed, colour: style::INK, words });
    }
    if !summary.outside.is_empty() {
        legend.push(Entry { key: Key::Tint, colour: OUTSIDE, words: "out of that range".to_owned() });
    }
    for label in labels(&phases) {
        legend.push(Entry { key: Key::Tint, colour: tint(&phases, label), words: label.to_owned() });
    }
    let caption = format!(
        "Above: the signal, smallest to largest sample in each pixel column. Below: deviation of one sample by {}, an answer every {} \
         samples, causal; median in columns of {COARSE} pixels. {words}",
        plan.noise.spec(),
        plan.every(),
    );
    let time = Axis::linear("time [s]".into(), 0.0, recording.length_s(), 10);
    let (mut panels, mut rows, mut top) = (Vec::new(), Vec::new(), 0);
    for sensor in Sensor::ALL {
        let signal: Vec<Vec<Column>> = signal.by_ref().take(3).collect();
        let sigma: Vec<Vec<Column>> = sigma.by_ref().take(3).collect();
        for (series, all) in [("signal", &signal), ("sigma", &sigma)] {
            for (axis, columns) in AXES.into_iter().zip(all) {
                let (name, unit) = (sensor.name(), sensor.unit());
                let row = |c: &Column| row![name, axis, series, unit, c.t, c.low, c.middle, c.high];
                rows.extend(columns.iter().map(row));
            }
        }
        let [signal_axis, sigma_axis] = axes(sensor, &signal, &sigma, trained_up_to(sensor));
        let mut lower = ground(&phases);
        let outside = summary.outside.iter().filter(|span| span.sensor == sensor);
        lower.extend(outside.map(|span| Layer::Foot([span.from_s, span.to_s], BAND, OUTSIDE)));
        lower.extend(limit(&time, trained_up_to(sensor)));
        lower.extend(sigma.iter().zip(PALETTE).flat_map(|(sigma, colour)| Layer::medians(sigma, colour)));
        lower.push(Layer::Axes(true));
        let mut upper = ground(&phases);
        let envelope = |(signal, colour)| Layer::Envelope(signal, pale(colour, 0.6));
        upper.extend(signal.into_iter().zip(PALETTE).map(envelope));
        upper.extend([Layer::Axes(false), Layer::title(style::title(sensor))]);
        for (above, height, y, layers) in
            [(ABOVE, SIGNAL, signal_axis, upper), (BETWEEN, SIGMA, sigma_axis, lower)]
        {
            top += above;
            let place = Rect { left: LEFT, top, right: LEFT + ROOM, bottom: top + height };
            panels.push(Panel { place, x: time.clone(), y, layers });
            top += height;
        }
        top += BELOW;
    }
    let header = vec!["sensor", "axis", "series", "unit", "t_s", "low", "median", "high"];
    Ok(Chart::new(Sheet::new(legend, top, caption), panels, Drawn { header, rows }))
}

/// Of the signal and of its deviation.
fn axes(
    sensor: Sensor,
    signal: &[Vec<Column>],
    sigma: &[Vec<Column>],
    trained_up_to: Option<f64>,
) -> [Axis; 2] {
    let unit = style::unit(sensor);
    let (low, high) = extent(signal.iter().flatten().flat_map(|c| [c.low, c.high]));
    let pad = 0.05 * (high - low);
    let middles = || sigma.iter().flatten().map(|c| c.middle).filter(|v| *v > 0.0);
    let top = middles().fold(trained_up_to.unwrap_or(0.0), f64::max);
    let bottom = middles().fold(top, f64::min);
    let (bottom, top) = if top > 0.0 { (bottom / 1.3, top * 1.3) } else { (0.1, 1.0) };
    [
        Axis::linear(format!("signal [{unit}]"), low - pad, high + pad, 5),
        Axis::log(format!("σ [{unit}]"), bottom, top),
    ]
}
