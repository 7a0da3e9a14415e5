//! Spectra of a log along it, or against the output of the motors: frequency upwards, the density by colour; a panel a sensor, its three axes together.

use super::axis::Axis;
use super::chart::{Chart, Layer, Panel};
use super::error::FigureError;
use super::frame::{ABOVE, BELOW, LEFT, RIGHT, Rect};
use super::heat;
use super::plot::{Drawn, row};
use super::sheet::Sheet;
use super::style;
use dpn_core::signal::Welch;
use dpn_core::signal::stats::quantile;
use dpn_core::{Recorded, Sensor, Stamp};

const FIGURE: &str = "spectrogram";
/// Spectra beside each other, and bands above each other, at most.
const COLUMNS: usize = 150;
const BANDS: usize = 50;
/// Outputs of motors that are told apart.
const OUTPUTS: usize = 24;
/// Length of a segment \[s\].
const SEGMENT_S: f64 = 0.5;
/// Height of a panel.
const PANEL: i32 = 380;

/// Spectra of a piece of a log, and where on the axis to the right it stands.
struct Column {
    ends: [f64; 2],
    /// Mean power density of the three axes by band, a sensor each.
    power: [Vec<f64>; 2],
}

/// Of a recording; `words` end the small print.
///
/// # Errors
/// [`FigureError::Empty`] where the log is too short for two spectra or has no power; samples that cannot be read again.
pub fn spectrogram(recording: &dyn Recorded, words: &str) -> Result<Chart, FigureError> {
    let mut columns = columns(recording, recording.len().div_ceil(COLUMNS))?;
    let length = columns[0].ends[1] - columns[0].ends[0];
    // A column reaches to the next.
    for i in 1..columns.len() {
        columns[i - 1].ends[1] = columns[i].ends[0];
    }
    let time = Axis::linear("time [s]".into(), 0.0, recording.length_s(), 10);
    drawn(
        recording,
        &columns,
        &time,
        ["from_s", "to_s"],
        format!("Spectra of {length:.1} s each, {HOW} {words}"),
    )
}

/// The same against what the vehicle's motors were told, means of their outputs by time: what comes from the rotors moves with them, what comes from a frame stays
/// where it is.
///
/// # Errors
/// As [`spectrogram`]; outputs that never change are no axis.
pub fn spectra_by_motors(
    recording: &dyn Recorded,
    motors: &[(Stamp, f64)],
    words: &str,
) -> Result<Chart, FigureError> {
    let empty = |what: &str| FigureError::Empty { figure: FIGURE, what: what.into() };
    let outputs: Vec<f64> = motors.iter().map(|(_, output)| *output).collect();
    if outputs.is_empty() {
        return Err(empty("motor"));
    }
    let (low, high) = (quantile(&outputs, 0.02), quantile(&outputs, 0.98));
    if high <= low {
        return Err(empty("motor whose output changes"));
    }
    let start = recording.span()[0];
    let width = (high - low) / OUTPUTS as f64;
    let mut bins: Vec<Option<(Column, f64)>> = (0..OUTPUTS).map(|_| None).collect();
    for column in columns(recording, 0)? {
        let at = |s: f64| motors.partition_point(|(t, _)| t.seconds_since(start) < s);
        let told = &outputs[at(column.ends[0])..at(column.ends[1])];
        if told.is_empty() {
            continue;
        }
        let bin = (told.iter().sum::<f64>() / told.len() as f64 - low) / width;
        let Some(bin) = (0.0..=OUTPUTS as f64).contains(&bin).then_some((bin as usize).min(OUTPUTS - 1))
        else {
            continue;
        };
        match &mut bins[bin] {
            Some((sum, count)) => {
                *count += 1.0;
                sum.power
                    .iter_mut()
                    .zip(&column.power)
                    .for_each(|(sum, power)| sum.iter_mut().zip(power).for_each(|(a, b)| *a += b));
            }
            none => {
                let from = low + bin as f64 * width;
                *none = Some((Column { ends: [from, from + width], ..column }, 1.0));
            }
        }
    }
    let mean = |(mut column, count): (Column, f64)| {
        column.power.iter_mut().flatten().for_each(|power| *power /= count);
        column
    };
    let columns: Vec<Column> = bins.into_iter().flatten().map(mean).collect();
    let output = Axis::linear("motors' mean output, as logged".into(), low, high, 10);
    drawn(
        recording,
        &columns,
        &output,
        ["from_output", "to_output"],
        format!("Spectra at each output of the motors, {HOW} {words}"),
    )
}

/// How a spectrum is made.
const HOW: &str = "root of the mean density of the three axes (Welch, Hann).";

/// Spectra of a log's pieces of at least `piece` samples and one segment, over time \[s\].
fn columns(recording: &dyn Recorded, piece: usize) -> Result<Vec<Column>, FigureError> {
    let rate = recording.rate();
    let segment = ((rate.hz() * SEGMENT_S) as usize).max(16);
    let piece = piece.max(segment);
    if recording.len() < 2 * piece {
        return Err(FigureError::Empty { figure: FIGURE, what: "second spectrum".into() });
    }
    let welch = Welch::new(segment).expect("16 samples or more");
    let start = recording.span()[0];
    let width = 0.5 * rate.hz() / BANDS as f64;
    let (mut columns, mut signal) = (Vec::new(), Vec::with_capacity(piece));
    let whole = recording.len() - recording.len() % piece;
    recording.pieces(0..whole, piece, &mut |samples| {
        let ends = [0, samples.len() - 1].map(|i| samples[i].t.seconds_since(start));
        let power = Sensor::ALL.map(|sensor| {
            let mut bands = vec![0.0; BANDS];
            for axis in 0..3 {
                signal.clear();
                signal.extend(samples.iter().map(|s| s.of(sensor)[axis]));
                let spectrum = welch.spectrum(&signal, rate).expect("a segment or more");
                for (i, band) in bands.iter_mut().enumerate() {
                    *band += spectrum.band_power(i as f64 * width, (i + 1) as f64 * width) / (3.0 * width);
                }
            }
            bands
        });
        columns.push(Column { ends, power });
        Ok(())
    })?;
    Ok(columns)
}

fn drawn(
    recording: &dyn Recorded,
    columns: &[Column],
    x: &Axis,
    ends: [&'static str; 2],
    caption: String,
) -> Result<Chart, FigureError> {
    let nyquist = 0.5 * recording.rate().hz();
    let width = nyquist / BANDS as f64;
    let (mut panels, mut rows, mut top) = (Vec::new(), Vec::new(), 0);
    for (at, sensor) in Sensor::ALL.into_iter().enumerate() {
        let density_of = |column: &Column, band: usize| column.power[at][band].sqrt();
        let all = columns.iter().flat_map(|column| (0..BANDS).map(move |band| density_of(column, band)));
        let powers: Vec<f64> = all.filter(|d| *d > 0.0).collect();
        if powers.is_empty() {
            continue;
        }
        // The lowest band holds the motion, far above the rest.
        let (low, high) = (quantile(&powers, 0.02), quantile(&powers, 0.98));
        let density = Axis::log(format!("density [{}/√Hz]", style::unit(sensor)), low, high);
        let mut layers = Vec::new();
        for band in 0..BANDS {
            let hertz = [band as f64 * width, (band + 1) as f64 * width];
            let cells: Vec<(&Column, usize)> =
                columns.iter().map(|c| (c, heat::step(density.fraction(density_of(c, band))))).collect();
            // Neighbours of one colour are one rectangle.
            for run in cells.chunk_by(|a, b| a.1 == b.1 && a.0.ends[1] >= b.0.ends[0]) {
                let ends = [run[0].0.ends[0], run[run.len() - 1].0.ends[1]];
                layers.push(Layer::Block(ends, hertz, heat::colour(run[0].1)));
            }
            for column in columns {
                rows.push(row![
                    sensor.name(),
                    column.ends[0],
                    column.ends[1],
                    hertz[0],
                    hertz[1],
                    density_of(column, band)
                ]);
            }
        }
        layers.extend([Layer::Axes(true), Layer::title(style::title(sensor))]);
        top += ABOVE;
        let place = Rect { left: LEFT, top, right: style::WIDTH as i32 - RIGHT, bottom: top + PANEL };
        let y = Axis::linear("frequency [Hz]".into(), 0.0, nyquist, 6);
        panels.push(Panel { place, x: x.clone(), y, layers });
        top += PANEL + BELOW + 20;
        panels.push(heat::scale(top, density));
        top += heat::SCALE;
    }
    if panels.is_empty() {
        return Err(FigureError::Empty { figure: FIGURE, what: "spectrum with power".into() });
    }
    let [from, to] = ends;
    let header = vec!["sensor", from, to, "from_hz", "to_hz", "density"];
    Ok(Chart::new(Sheet::new(Vec::new(), top + 10, caption), panels, Drawn { header, rows }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::Plot;
    use dpn_core::{ImuRecording, ImuSample, Stamp};

    #[test]
    fn a_tone_that_begins_half_way_stands_where_and_when_it_sounds() {
        let sample = |i: i64| {
            let t = i as f64 * 0.005;
            let tone = if t >= 20.0 { (std::f64::consts::TAU * 61.0 * t).sin() } else { 0.0 };
            let hiss = 1e-3 * ((i * i % 97) as f64 - 48.0);
            ImuSample {
                t: Stamp::from_ns(i * 5_000_000),
                gyro: [hiss; 3],
                accel: [hiss, 0.5 * hiss, 9.81 + tone],
            }
        };
        let recording = ImuRecording::new((0..8000).map(sample).collect()).unwrap();
        let rows = spectrogram(&recording, "").unwrap().csv().rows;
        let at = |row: &Vec<String>, k: usize| row[k].parse::<f64>().unwrap();
        let loudest = |accepts: &dyn Fn(f64) -> bool| {
            let of = rows.iter().filter(|row| row[0] == "accel" && at(row, 3) > 0.0 && accepts(at(row, 1)));
            of.max_by(|a, b| at(a, 5).total_cmp(&at(b, 5))).unwrap().clone()
        };
        let (before, after) = (loudest(&|t| t < 19.0), loudest(&|t| t > 20.5));
        assert!((at(&after, 3)..=at(&after, 4)).contains(&61.0), "{after:?}");
        assert!(at(&after, 5) > 10.0 * at(&before, 5), "{before:?} {after:?}");
        // Motors that speed up where the tone begins.
        let told = |i: i64| (Stamp::from_ns(i * 20_000_000), if i < 1000 { 1100.0 } else { 1700.0 });
        let motors: Vec<(Stamp, f64)> = (0..2000).map(told).collect();
        let rows = spectra_by_motors(&recording, &motors, "").unwrap().csv().rows;
        let sounds = |output: f64| {
            let of = |row: &&Vec<String>| {
                row[0] == "accel"
                    && (at(row, 1)..=at(row, 2)).contains(&output)
                    && (at(row, 3)..at(row, 4)).contains(&61.0)
            };
            at(rows.iter().find(of).unwrap(), 5)
        };
        assert!(sounds(1690.0) > 10.0 * sounds(1110.0));
        assert!(matches!(spectra_by_motors(&recording, &motors[..900], ""), Err(FigureError::Empty { .. })));
        let short = ImuRecording::new((0..20).map(sample).collect()).unwrap();
        assert!(matches!(spectrogram(&short, ""), Err(FigureError::Empty { .. })));
    }
}
