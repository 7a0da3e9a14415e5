//! Spectra of a log: root of the power density over frequency, both logarithmic, a panel a sensor, a line an axis.

use super::axis::Axis;
use super::chart::{Chart, Layer};
use super::error::FigureError;
use super::legend::{self, Key};
use super::plot::{Drawn, row};
use super::style::{self, PALETTE};
use super::summary::extent;
use dpn_core::Sensor;
use dpn_probe::doctor::vibration::AxisSpectrum;

const FIGURE: &str = "spectra";
const AXES: [&str; 3] = ["x", "y", "z"];

/// Of the sensors that have one with power; `words` end the small print.
///
/// # Errors
/// [`FigureError::Empty`] where no sensor has.
pub fn spectrum_plot(spectra: &[AxisSpectrum], words: &str) -> Result<Chart, FigureError> {
    let (mut panels, mut rows) = (Vec::new(), Vec::new());
    for sensor in Sensor::ALL {
        let of = spectra.iter().filter(|s| s.sensor == sensor);
        let lines: Vec<(usize, Vec<(f64, f64)>)> = of.map(|s| (s.axis, bins(s))).collect();
        let all = || lines.iter().flat_map(|(_, bins)| bins.iter().copied());
        let ((from, to), (low, high)) = (extent(all().map(|b| b.0)), extent(all().map(|b| b.1)));
        if to <= 0.0 {
            continue;
        }
        for (axis, bins) in &lines {
            let unit = format!("{}/sqrt(Hz)", sensor.unit());
            rows.extend(
                bins.iter().map(|(hz, density)| row![sensor.name(), AXES[*axis % 3], unit, hz, density]),
            );
        }
        let x = Axis::log("frequency [Hz]".into(), from, to);
        let y = Axis::log(format!("density [{}/√Hz]", style::unit(sensor)), low / 1.3, high * 1.3);
        let line =
            |(axis, bins)| Layer::Line(bins, style::stroke(PALETTE[axis % PALETTE.len()], style::THIN));
        panels.push((style::title(sensor).to_owned(), x, y, lines.into_iter().map(line).collect()));
    }
    if panels.is_empty() {
        return Err(FigureError::Empty { figure: FIGURE, what: "spectrum with power".into() });
    }
    let caption = format!(
        "Root of the power spectral density (Welch, Hann). Flat: white noise, at its density; peaks: vibration. {words}"
    );
    let header = vec!["sensor", "axis", "unit", "hz", "density"];
    Ok(Chart::side_by_side(legend::entries(Key::Line, AXES), caption, panels, Drawn { header, rows }))
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
