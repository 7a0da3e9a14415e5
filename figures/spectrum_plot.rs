//! Spectra of a log: root of the power density over frequency, both logarithmic, a panel a sensor, a line an axis.

use super::axis::Axis;
use super::chart::{Chart, Layer};
use super::error::FigureError;
use super::legend::{self, Key};
use super::plot::{Drawn, row};
use super::style::{self, PALETTE};
use super::summary::extent;
use dpn_core::Sensor;
use dpn_probe::doctor::vibration::{AxisSpectrum, Shaking, shaking};

const FIGURE: &str = "spectra";
const AXES: [&str; 3] = ["x", "y", "z"];

/// A spectrum by name.
type Named = (String, Vec<(f64, f64)>);

/// Of the sensors that have one with power, the bands that shake marked; `words` end the small print.
///
/// # Errors
/// [`FigureError::Empty`] where no sensor has.
pub fn spectrum_plot(spectra: &[AxisSpectrum], words: &str) -> Result<Chart, FigureError> {
    let lines = |sensor: Sensor| {
        let of = spectra.iter().filter(|s| s.sensor == sensor);
        of.map(|s| (s.axis, (AXES[s.axis % 3].to_owned(), bins(s)))).collect()
    };
    let shaking = shaking(spectra);
    let caption = format!(
        "Root of the power spectral density (Welch, Hann). Flat: white noise, at its density; marked peaks: vibration. {words}"
    );
    plot(lines, &shaking, legend::entries(Key::Line, AXES), caption)
}

/// Two logs, A and B by name, over one another: of each sensor the root of the mean density of its axes.
///
/// # Errors
/// [`FigureError::Empty`] where no sensor has a spectrum with power.
pub fn spectra_of_two(logs: [(&str, &[AxisSpectrum]); 2]) -> Result<Chart, FigureError> {
    let lines = |sensor: Sensor| {
        let of = |(i, (name, spectra)): (usize, &(&str, &[AxisSpectrum]))| {
            let axes: Vec<_> = spectra.iter().filter(|s| s.sensor == sensor).map(bins).collect();
            (!axes.is_empty()).then(|| (i, ((*name).to_owned(), mean(&axes))))
        };
        logs.iter().enumerate().filter_map(of).collect()
    };
    let names = ["A", "B"]
        .into_iter()
        .zip(logs)
        .map(|(letter, (name, _))| format!("{letter}: {name}"))
        .collect::<Vec<_>>();
    let caption = "Root of the mean power spectral density of the three axes (Welch, Hann).".to_owned();
    plot(lines, &[], legend::entries(Key::Line, names.iter().map(String::as_str)), caption)
}

/// Root of the mean of squares, bin by bin.
fn mean(axes: &[Vec<(f64, f64)>]) -> Vec<(f64, f64)> {
    let mut all: Vec<(f64, f64)> = axes.concat();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let bin = |bin: &[(f64, f64)]| {
        (bin[0].0, (bin.iter().map(|(_, d)| d * d).sum::<f64>() / axes.len() as f64).sqrt())
    };
    all.chunk_by(|a, b| a.0 == b.0).map(bin).collect()
}

fn plot(
    lines: impl Fn(Sensor) -> Vec<(usize, Named)>,
    shaking: &[Shaking],
    legend: Vec<legend::Entry>,
    caption: String,
) -> Result<Chart, FigureError> {
    let (mut panels, mut rows) = (Vec::new(), Vec::new());
    for sensor in Sensor::ALL {
        let lines = lines(sensor);
        let all = || lines.iter().flat_map(|(_, (_, bins))| bins.iter().copied());
        let ((from, to), (low, high)) = (extent(all().map(|b| b.0)), extent(all().map(|b| b.1)));
        if to <= 0.0 {
            continue;
        }
        for (_, (name, bins)) in &lines {
            let unit = format!("{}/sqrt(Hz)", sensor.unit());
            rows.extend(bins.iter().map(|(hz, density)| row![sensor.name(), name, unit, hz, density]));
        }
        let x = Axis::log("frequency [Hz]".into(), from, to);
        let y = Axis::log(format!("density [{}/√Hz]", style::unit(sensor)), low / 1.3, high * 1.3);
        let colour = |number: usize| PALETTE[number % PALETTE.len()];
        let line = |(number, (_, bins))| Layer::Line(bins, style::stroke(colour(number), style::THIN));
        let mark = |s: &Shaking| Layer::Mark(s.axis, (s.hz, s.density.sqrt()), colour(s.axis));
        let marks = shaking.iter().filter(|s| s.sensor == sensor).map(mark);
        let layers = lines.into_iter().map(line).chain(marks).collect();
        panels.push((style::title(sensor).to_owned(), x, y, layers));
    }
    if panels.is_empty() {
        return Err(FigureError::Empty { figure: FIGURE, what: "spectrum with power".into() });
    }
    let header = vec!["sensor", "axis", "unit", "hz", "density"];
    Ok(Chart::side_by_side(legend, caption, panels, Drawn { header, rows }))
}

/// Frequency and root density of what has a place on logarithmic axes; the bin at zero has none.
fn bins(of: &AxisSpectrum) -> Vec<(f64, f64)> {
    let bins = of.spectrum.frequencies().zip(of.spectrum.density());
    let placed = bins.filter(|(hz, d)| *hz > 0.0 && d.is_finite() && **d > 0.0);
    placed.map(|(hz, d)| (hz, d.sqrt())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::Plot;
    use dpn_core::SampleRate;
    use dpn_core::signal::Welch;

    #[test]
    fn a_sine_stands_where_it_belongs_and_a_dead_sensor_has_no_panel() {
        let rate = SampleRate::HZ_200;
        let signal: Vec<f64> =
            (0..4000).map(|i| (f64::from(i) * 0.005 * 50.0 * std::f64::consts::TAU).sin()).collect();
        let spectrum = Welch::new(400).unwrap().spectrum(&signal, rate).unwrap();
        let of = |sensor| AxisSpectrum { sensor, axis: 1, spectrum: spectrum.clone() };
        let plot = spectrum_plot(&[of(Sensor::Accel), of(Sensor::Gyro)], "").unwrap();
        let csv = plot.csv();
        let value = |row: &Vec<String>| row[4].parse::<f64>().unwrap();
        let top = csv.rows.iter().max_by(|a, b| value(a).total_cmp(&value(b))).unwrap();
        assert_eq!((top[1].as_str(), top[3].as_str()), ("y", "50"));
        let alone = spectrum_plot(&[of(Sensor::Accel)], "").unwrap().csv();
        assert!(alone.rows.iter().all(|row| row[0] == "accel"));
        assert!(matches!(spectrum_plot(&[], ""), Err(FigureError::Empty { .. })));
    }
}
