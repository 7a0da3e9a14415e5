//! Spectra of a log: root of the power density over frequency, both logarithmic, a panel a sensor, a line an axis.

use super::axis::Axis;
use super::error::FigureError;
use super::frame::{Frame, Rect};
use super::legend::{self, Key};
use super::plot::{Area, Drawn, Painted, Plot, row};
use super::sheet::Sheet;
use super::style::{self, PALETTE};
use super::summary::extent;
use dpn_core::Sensor;
use dpn_probe::doctor::vibration::AxisSpectrum;
use plotters_backend::DrawingBackend;

const FIGURE: &str = "spectra";
const AXES: [&str; 3] = ["x", "y", "z"];

/// The plot; see the head of its file.
#[derive(Debug, Clone)]
pub struct SpectrumPlot {
    panels: Vec<Panel>,
    sheet: Sheet,
}

#[derive(Debug, Clone)]
struct Panel {
    sensor: Sensor,
    x: Axis,
    y: Axis,
    /// Axis, then frequency and root density of its bins.
    lines: Vec<(usize, Vec<(f64, f64)>)>,
}

impl SpectrumPlot {
    /// Spectra of the sensors that have one with power; `words` end the small print.
    ///
    /// # Errors
    /// [`FigureError::Empty`] where no sensor has.
    pub fn new(spectra: &[AxisSpectrum], words: &str) -> Result<Self, FigureError> {
        let panels: Vec<Panel> =
            Sensor::ALL.into_iter().filter_map(|sensor| Panel::new(sensor, spectra)).collect();
        if panels.is_empty() {
            return Err(FigureError::Empty { figure: FIGURE, what: "spectrum with power".into() });
        }
        let legend = legend::entries(Key::Line, AXES);
        let caption = format!(
            "Root of the power spectral density (Welch, Hann). Flat: white noise, at its density; peaks: vibration. {words}"
        );
        Ok(Self { panels, sheet: Sheet::of_panels(legend, caption) })
    }
}

impl Panel {
    fn new(sensor: Sensor, spectra: &[AxisSpectrum]) -> Option<Self> {
        let lines: Vec<(usize, Vec<(f64, f64)>)> = spectra
            .iter()
            .filter(|s| s.sensor == sensor)
            .map(|s| {
                let bins = s.spectrum.frequencies().zip(s.spectrum.density());
                // The bin at zero has no place on a logarithmic axis.
                let bins = bins.filter(|(hz, d)| *hz > 0.0 && d.is_finite() && **d > 0.0);
                (s.axis, bins.map(|(hz, d)| (hz, d.sqrt())).collect())
            })
            .collect();
        let all = || lines.iter().flat_map(|(_, bins)| bins.iter().copied());
        let ((from, to), (low, high)) = (extent(all().map(|b| b.0)), extent(all().map(|b| b.1)));
        if to <= 0.0 {
            return None;
        }
        let unit = style::unit(sensor);
        Some(Self {
            sensor,
            x: Axis::log("frequency [Hz]".into(), from, to),
            y: Axis::log(format!("density [{unit}/√Hz]"), low / 1.3, high * 1.3),
            lines,
        })
    }

    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>, rect: Rect) -> Painted<DB> {
        let frame = Frame::new(area, rect, &self.x, &self.y);
        frame.grid()?;
        for (axis, bins) in &self.lines {
            let points = bins.iter().map(|&(hz, density)| frame.at(hz, density)).collect();
            frame.path(points, style::stroke(PALETTE[axis % PALETTE.len()], style::THIN))?;
        }
        frame.axes(true)?;
        frame.title(style::title(self.sensor))
    }
}

impl Plot for SpectrumPlot {
    fn size(&self) -> (u32, u32) {
        self.sheet.size()
    }

    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Painted<DB> {
        self.sheet.side_by_side(area, &self.panels, |panel, rect| panel.draw(area, rect))
    }

    fn csv(&self) -> Drawn {
        let mut rows = Vec::new();
        for panel in &self.panels {
            for (axis, bins) in &panel.lines {
                for (hz, density) in bins {
                    let unit = format!("{}/sqrt(Hz)", panel.sensor.unit());
                    rows.push(row![panel.sensor.name(), AXES[*axis % 3], unit, hz, density]);
                }
            }
        }
        Drawn { header: vec!["sensor", "axis", "unit", "hz", "density"], rows }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::SampleRate;
    use dpn_core::signal::Welch;

    #[test]
    fn a_sine_stands_where_it_belongs_and_a_dead_sensor_has_no_panel() {
        let rate = SampleRate::HZ_200;
        let signal: Vec<f64> =
            (0..4000).map(|i| (f64::from(i) * 0.005 * 50.0 * std::f64::consts::TAU).sin()).collect();
        let spectrum = Welch::new(400).unwrap().spectrum(&signal, rate).unwrap();
        let of = |sensor| AxisSpectrum { sensor, axis: 1, spectrum: spectrum.clone() };
        let plot = SpectrumPlot::new(&[of(Sensor::Accel), of(Sensor::Gyro)], "").unwrap();
        let csv = plot.csv();
        let value = |row: &Vec<String>| row[4].parse::<f64>().unwrap();
        let top = csv.rows.iter().max_by(|a, b| value(a).total_cmp(&value(b))).unwrap();
        assert_eq!((top[1].as_str(), top[3].as_str()), ("y", "50"));
        let alone = SpectrumPlot::new(&[of(Sensor::Accel)], "").unwrap().csv();
        assert!(alone.rows.iter().all(|row| row[0] == "accel"));
        assert!(matches!(SpectrumPlot::new(&[], ""), Err(FigureError::Empty { .. })));
    }
}
