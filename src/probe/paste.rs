//! Noise figures to paste: as densities with their intervals and where they come from, and as the lines of other programs. One place for every command.

use crate::text::{aligned, three};
use dpn_core::SampleRate;
use dpn_core::noise::{Axes, Figure, ImuFigures, Interval, Meaning};
use dpn_io::noise_formats::{Format, Written, write};
use serde::Serialize;
use std::fmt::Write;

/// One figure, or why there is none.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FigureLine {
    /// Which.
    pub figure: Figure,
    /// Its density, x, y, z, in [`Figure::unit`]; none where it is not known.
    pub density: Option<[Interval; 3]>,
    /// Where it comes from, or why it is not known.
    pub words: String,
    /// Whether it goes into the lines of other programs.
    pub pasted: bool,
}

impl FigureLine {
    /// A figure that is known and pasted.
    pub fn known(figure: Figure, density: [Interval; 3], words: impl Into<String>) -> Self {
        Self { figure, density: Some(density), words: words.into(), pasted: true }
    }

    /// A figure that is not known.
    pub fn unknown(figure: Figure, why: impl Into<String>) -> Self {
        Self { figure, density: None, words: why.into(), pasted: false }
    }
}

/// The figures of one IMU, to paste.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Paste {
    /// Samples a second of the log that they are from.
    pub rate_hz: SampleRate,
    /// In the order of [`Figure::ALL`]; those nobody has asked for are left out.
    pub lines: Vec<FigureLine>,
}

impl Paste {
    /// Those that are pasted.
    pub fn figures(&self) -> ImuFigures {
        let mut figures = ImuFigures { rate: Some(self.rate_hz), ..ImuFigures::default() };
        for line in self.lines.iter().filter(|line| line.pasted) {
            let Some(axes) = line.density else { continue };
            let meaning = if line.figure.is_walk() { Meaning::WalkDensity } else { Meaning::Density };
            // A density that no sensor has is in no program's lines.
            let _left_out =
                figures.set(line.figure, meaning, Axes::Each(axes.map(|a| a.value)), self.rate_hz);
        }
        figures
    }

    /// The lines of other programs; none of a program whose lines cannot be written, as where nothing is known.
    pub fn written(&self, formats: &[Format]) -> Vec<Written> {
        let note = |figure: Figure| {
            let line = self.lines.iter().find(|line| line.figure == figure)?;
            match line.density {
                Some(_) if !line.pasted => Some("left out: it was not asked for".to_owned()),
                _ => Some(line.words.clone()),
            }
        };
        let figures = self.figures();
        formats.iter().filter_map(|format| write(&figures, *format, note).ok()).collect()
    }

    /// For people: a row a figure, then the lines of `formats`.
    pub fn page(&self, formats: &[Format]) -> String {
        let mut rows = vec![["density (95 %)", "x", "y", "z", "", ""].map(str::to_owned)];
        let (mut unknown, mut kept) = (String::new(), Vec::new());
        for line in &self.lines {
            let Some(axes) = &line.density else {
                let _ = writeln!(unknown, "  {}: not known, {}", line.figure, line.words);
                continue;
            };
            if !line.pasted {
                kept.push(line.figure.to_string());
            }
            let [x, y, z] = axes.map(|Interval { value, low, high }| {
                format!("{} ({} to {})", three(value), three(low), three(high))
            });
            rows.push([
                format!("  {}", line.figure),
                x,
                y,
                z,
                line.figure.unit().to_owned(),
                line.words.clone(),
            ]);
        }
        let mut text = if rows.len() > 1 { aligned(&rows) } else { String::new() };
        text.push_str(&unknown);
        if !kept.is_empty() {
            let _ =
                writeln!(text, "  not in the lines below unless asked for (--walks): {}", kept.join(", "));
        }
        let written = self.written(formats);
        for Written { format, text: lines, .. } in &written {
            let _ = write!(text, "\n--- {format} ---\n{lines}");
        }
        if formats.is_empty() && self.lines.iter().any(|line| line.pasted) {
            let _ = writeln!(text, "  other programs' lines: --paste {}, or all", Format::names());
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_known_or_not_asked_for_is_said_and_not_pasted() {
        let at = |value: f64| [value, 1.1 * value, 0.9 * value].map(|v| Interval::of_log(v, 0.05));
        let mut paste = Paste {
            rate_hz: SampleRate::HZ_200,
            lines: vec![
                FigureLine::known(Figure::AccelWhite, at(0.02), "learned by the odometry"),
                FigureLine {
                    pasted: false,
                    ..FigureLine::known(Figure::AccelWalk, at(1e-3), "learned by the odometry")
                },
                FigureLine::unknown(Figure::GyroWhite, "it stayed at its start"),
            ],
        };
        let page = paste.page(&[Format::Kalibr, Format::Vins]);
        assert!(page.contains("2.00e-2 (1.81e-2 to 2.21e-2)"), "{page}");
        assert!(page.contains("gyroscope noise: not known, it stayed at its start"), "{page}");
        assert!(page.contains("unless asked for (--walks): accelerometer bias walk"), "{page}");
        // Kalibr has one value for all axes: the largest.
        assert!(page.contains("accelerometer_noise_density: 0.022"), "{page}");
        assert!(page.contains("--- vins ---") && !page.contains("\naccelerometer_random_walk: "), "{page}");
        paste.lines[1].pasted = true;
        assert!(paste.page(&[Format::Kalibr]).contains("\naccelerometer_random_walk: 0.0011"));
        paste.lines.retain(|line| line.density.is_none());
        assert!(paste.written(&Format::ALL).is_empty() && !paste.page(&Format::ALL).contains("---"));
    }
}
