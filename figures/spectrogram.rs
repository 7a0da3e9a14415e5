//! Spectra of a log along it: time to the right, frequency upwards, the density by colour; a panel a sensor, its three axes together.

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
use dpn_core::{Recorded, Sensor};

const FIGURE: &str = "spectrogram";
/// Spectra beside each other, and bands above each other, at most.
const COLUMNS: usize = 150;
const BANDS: usize = 50;
/// Length of a segment \[s\].
const SEGMENT_S: f64 = 0.5;
/// Height of a panel.
const PANEL: i32 = 380;

/// Of a recording; `words` end the small print.
///
/// # Errors
/// [`FigureError::Empty`] where the log is too short for two spectra or has no power; samples that cannot be read again.
pub fn spectrogram(recording: &dyn Recorded, words: &str) -> Result<Chart, FigureError> {
    let rate = recording.rate();
    let segment = ((rate.hz() * SEGMENT_S) as usize).max(16);
    let piece = recording.len().div_ceil(COLUMNS).max(segment);
    if recording.len() < 2 * piece {
        return Err(FigureError::Empty { figure: FIGURE, what: "second spectrum".into() });
    }
    let welch = Welch::new(segment).expect("16 samples or more");
    let start = recording.span()[0];
    let (mut times, mut spectra) = (Vec::new(), [const { Vec::new() }; 2]);
    let mut signal = Vec::with_capacity(piece);
    let whole = recording.len() - recording.len() % piece;
    recording.pieces(0..whole, piece, &mut |samples| {
        times.push([0, samples.len() - 1].map(|i| samples[i].t.seconds_since(start)));
        for (sensor, spectra) in Sensor::ALL.into_iter().zip(&mut spectra) {
            let mut bands = vec![0.0; BANDS];
            for axis in 0..3 {
                signal.clear();
                signal.extend(samples.iter().map(|s| s.of(sensor)[axis]));
                let spectrum = welch.spectrum(&signal, rate).expect("a segment or more");
                let width = 0.5 * rate.hz() / BANDS as f64;
                for (i, band) in bands.iter_mut().enumerate() {
                    *band += spectrum.band_power(i as f64 * width, (i + 1) as f64 * width) / (3.0 * width);
                }
            }
            spectra.push(bands.into_iter().map(f64::sqrt).collect::<Vec<f64>>());
        }
        Ok(())
    })?;

    let time = Axis::linear("time [s]".into(), 0.0, recording.length_s(), 10);
    let (mut panels, mut rows, mut top) = (Vec::new(), Vec::new(), 0);
    for (sensor, spectra) in Sensor::ALL.into_iter().zip(&spectra) {
        let powers: Vec<f64> = spectra.iter().flatten().copied().filter(|d| *d > 0.0).collect();
        if powers.is_empty() {
            continue;
        }
        // The lowest band holds the motion, far above the rest.
        let (low, high) = (quantile(&powers, 0.02), quantile(&powers, 0.98));
        let density = Axis::log(format!("density [{}/√Hz]", style::unit(sensor)), low, high);
        let (mut layers, width) = (Vec::new(), 0.5 * rate.hz() / BANDS as f64);
        for band in 0..BANDS {
            let ends = [band as f64 * width, (band + 1) as f64 * width];
            let cells: Vec<(usize, usize)> =
                (0..spectra.len()).map(|i| (i, heat::step(density.fraction(spectra[i][band])))).collect();
            // Neighbours of one colour are one rectangle.
            for run in cells.chunk_by(|a, b| a.1 == b.1) {
                let [from, to] = [run[0].0, run[run.len() - 1].0 + 1];
                let end = times.get(to).map_or(times[times.len() - 1][1], |next| next[0]);
                layers.push(Layer::Block([times[from][0], end], ends, heat::colour(run[0].1)));
            }
            for (spectrum, [from, _]) in spectra.iter().zip(&times) {
                rows.push(row![sensor.name(), from, ends[0], ends[1], spectrum[band]]);
            }
        }
        layers.extend([Layer::Axes(true), Layer::title(style::title(sensor))]);
        top += ABOVE;
        let place = Rect { left: LEFT, top, right: style::WIDTH as i32 - RIGHT, bottom: top + PANEL };
        let y = Axis::linear("frequency [Hz]".into(), 0.0, 0.5 * rate.hz(), 6);
        panels.push(Panel { place, x: time.clone(), y, layers });
        top += PANEL + BELOW + 20;
        panels.push(heat::scale(top, density));
        top += heat::SCALE;
    }
    if panels.is_empty() {
        return Err(FigureError::Empty { figure: FIGURE, what: "spectrum with power".into() });
    }
    let length = times[0][1] - times[0][0];
    let caption = format!(
        "Spectra of {length:.1} s each, root of the mean density of the three axes (Welch, Hann). {words}"
    );
    let header = vec!["sensor", "t_s", "from_hz", "to_hz", "density"];
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
            let of = rows.iter().filter(|row| row[0] == "accel" && at(row, 2) > 0.0 && accepts(at(row, 1)));
            of.max_by(|a, b| at(a, 4).total_cmp(&at(b, 4))).unwrap().clone()
        };
        let (before, after) = (loudest(&|t| t < 19.0), loudest(&|t| t > 20.5));
        assert!((at(&after, 2)..=at(&after, 3)).contains(&61.0), "{after:?}");
        assert!(at(&after, 4) > 10.0 * at(&before, 4), "{before:?} {after:?}");
        let short = ImuRecording::new((0..20).map(sample).collect()).unwrap();
        assert!(matches!(spectrogram(&short, ""), Err(FigureError::Empty { .. })));
    }
}
