//! A log and its noise: for each sensor the signal of its three axes above and the deviation of a sample below (logarithmic), over tinted
//! phases, with the upper end of what a network was trained on. A band along the deviation's lower edge marks when the sensor's windows are
//! unlike those of the training.

use super::axis::Axis;
use super::error::FigureError;
use super::flight::Phase;
use super::flight_sigma::{draw_limit, draw_medians, envelope, ground, labels, tint};
use super::frame::{ABOVE, BELOW, Frame, LEFT, RIGHT, Rect};
use super::legend::{self, Entry, Key};
use super::plot::{Area, Drawn, Painted, Plot, row};
use super::sheet::Sheet;
use super::style::{self, PALETTE};
use super::summary::{Column, Thinned};
use dpn_core::{Recorded, Sensor};
use dpn_probe::log_noise::{Plan, Track, TrackSummary};
use plotters::style::{Color, RGBColor};
use plotters_backend::DrawingBackend;

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

/// The plot; see the head of its file.
#[derive(Debug, Clone)]
pub struct LogNoisePlot {
    time: Axis,
    sensors: Vec<Panel>,
    phases: Vec<Phase>,
    sheet: Sheet,
}

#[derive(Debug, Clone)]
struct Panel {
    sensor: Sensor,
    signal_axis: Axis,
    sigma_axis: Axis,
    signal: Vec<Vec<Column>>,
    sigma: Vec<Vec<Column>>,
    trained_up_to: Option<f64>,
    /// When windows are out of the training's range, from and to \[s\].
    outside: Vec<(f64, f64)>,
}

impl LogNoisePlot {
    /// A recording, what `plan` said along it, and the summary of that; `words` end the small print.
    ///
    /// # Errors
    /// [`FigureError`] for a track of fewer than two answers, and for samples or answers that cannot be read again.
    pub fn new(
        recording: &dyn Recorded,
        track: &Track,
        plan: &Plan<'_>,
        summary: &TrackSummary,
        words: &str,
    ) -> Result<Self, FigureError> {
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
        let mut sensors = Vec::new();
        for sensor in Sensor::ALL {
            let outside = summary.outside.iter().filter(|span| span.sensor == sensor);
            let outside = outside.map(|span| (span.from_s, span.to_s)).collect();
            let (signal, sigma) = (signal.by_ref().take(3).collect(), sigma.by_ref().take(3).collect());
            sensors.push(Panel { outside, ..Panel::new(sensor, signal, sigma, plan) });
        }
        let phases: Vec<Phase> = summary
            .stretches
            .iter()
            .map(|s| Phase { label: s.phase.to_string(), from: s.from_s, to: s.to_s })
            .collect();
        let mut legend = legend::entries(Key::Line, AXES);
        if sensors.iter().any(|s| s.trained_up_to.is_some()) {
            let words = "end of the training's range".to_owned();
            legend.push(Entry { key: Key::Dashed, colour: style::INK, words });
        }
        if sensors.iter().any(|s| !s.outside.is_empty()) {
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
        let body = sensors.len() as i32 * (ABOVE + SIGNAL + BETWEEN + SIGMA + BELOW);
        Ok(Self { time, sensors, phases, sheet: Sheet::new(legend, body, caption) })
    }
}

impl Panel {
    fn new(sensor: Sensor, signal: Vec<Vec<Column>>, sigma: Vec<Vec<Column>>, plan: &Plan<'_>) -> Self {
        let unit = style::unit(sensor);
        let extent = |all: &[Vec<Column>]| {
            let low = all.iter().flatten().map(|c| c.low).fold(f64::INFINITY, f64::min);
            let high = all.iter().flatten().map(|c| c.high).fold(f64::NEG_INFINITY, f64::max);
            (low, high)
        };
        let (low, high) = extent(&signal);
        let pad = 0.05 * (high - low);
        // Roughness is the deviation of white noise: the range's end is comparable with what is drawn.
        let trained_up_to = plan.noise.trained_on(sensor).map(|range| range.roughness[1]);
        let middles = || sigma.iter().flatten().map(|c| c.middle).filter(|v| *v > 0.0);
        let top = middles().fold(trained_up_to.unwrap_or(0.0), f64::max);
        let bottom = middles().fold(top, f64::min);
        let (bottom, top) = if top > 0.0 { (bottom / 1.3, top * 1.3) } else { (0.1, 1.0) };
        Self {
            sensor,
            signal_axis: Axis::linear(format!("signal [{unit}]"), low - pad, high + pad, 5),
            sigma_axis: Axis::log(format!("σ [{unit}]"), bottom, top),
            signal,
            sigma,
            trained_up_to,
            outside: Vec::new(),
        }
    }
}

impl Plot for LogNoisePlot {
    fn size(&self) -> (u32, u32) {
        self.sheet.size()
    }

    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Painted<DB> {
        self.sheet.draw(area, |mut top| {
            for panel in &self.sensors {
                top += ABOVE;
                let rect = |top, height| Rect { left: LEFT, top, right: LEFT + ROOM, bottom: top + height };
                let upper = Frame::new(area, rect(top, SIGNAL), &self.time, &panel.signal_axis);
                ground(&upper, &self.phases)?;
                for (signal, colour) in panel.signal.iter().zip(PALETTE) {
                    envelope(&upper, signal, colour.mix(0.6))?;
                }
                upper.axes(false)?;
                upper.title(style::title(panel.sensor))?;
                top += SIGNAL + BETWEEN;
                let lower = Frame::new(area, rect(top, SIGMA), &self.time, &panel.sigma_axis);
                ground(&lower, &self.phases)?;
                let bottom = lower.rect.bottom;
                for &(from, to) in &panel.outside {
                    // A span may be narrower than a pixel, and is there all the same.
                    let (left, right) = (lower.x_at(from), lower.x_at(to).max(lower.x_at(from) + 1));
                    lower.block((left, bottom - BAND), (right, bottom), OUTSIDE)?;
                }
                draw_limit(&lower, panel.trained_up_to)?;
                for (sigma, colour) in panel.sigma.iter().zip(PALETTE) {
                    draw_medians(&lower, sigma, colour)?;
                }
                lower.axes(true)?;
                top += SIGMA + BELOW;
            }
            Ok(())
        })
    }

    fn csv(&self) -> Drawn {
        let mut rows = Vec::new();
        for panel in &self.sensors {
            for (series, all) in [("signal", &panel.signal), ("sigma", &panel.sigma)] {
                for (axis, columns) in AXES.into_iter().zip(all) {
                    let (name, unit) = (panel.sensor.name(), panel.sensor.unit());
                    let row = |c: &Column| row![name, axis, series, unit, c.t, c.low, c.middle, c.high];
                    rows.extend(columns.iter().map(row));
                }
            }
        }
        Drawn { header: vec!["sensor", "axis", "series", "unit", "t_s", "low", "median", "high"], rows }
    }
}
