//! Figures that were read, and what is known beside them.

use super::error::FormatError;
use super::format::Format;
use super::quantity::Quantity;
use super::step::{Remark, Step};
use dpn_core::noise::{Figure, ImuFigures};
use dpn_core::time::SampleRate;
use serde::Serialize;

/// What is known beside the file: it wins over the file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Given {
    /// The IMU's rate.
    pub rate: Option<SampleRate>,
    /// Whether that is a log's, and nobody typed it.
    pub rate_of_log: bool,
    /// Figures with their units.
    pub quantities: Vec<Quantity>,
    /// Whether a zero is kept as something to be said ([`NoiseCalibration::zeros`]) and not refused: for whoever judges a configuration and does
    /// not count with it.
    pub keep_zeros: bool,
}

/// A zero where a noise figure belongs.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Zero {
    /// Which figure.
    pub figure: Figure,
    /// Its key.
    pub key: String,
    /// Where it stands.
    pub line: usize,
}

impl Given {
    /// The last quantity given for `figure`.
    pub(super) fn quantity(&self, figure: Figure) -> Option<&Quantity> {
        self.quantities.iter().rev().find(|q| q.figure() == figure)
    }
}

/// Figures, where they came from, and how.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NoiseCalibration {
    /// How they were written.
    pub format: Format,
    /// What they say.
    pub figures: ImuFigures,
    /// The arithmetic from the file's numbers to densities.
    pub steps: Vec<Step>,
    /// What should be known about them.
    pub remarks: Vec<Remark>,
    /// Figures that are zero on some axis, with [`Given::keep_zeros`]; `figures` does not know them.
    pub zeros: Vec<Zero>,
}

impl NoiseCalibration {
    pub(super) fn new(format: Format) -> Self {
        Self {
            format,
            figures: ImuFigures::default(),
            steps: Vec::new(),
            remarks: Vec::new(),
            zeros: Vec::new(),
        }
    }

    /// Figures that were typed, without a file.
    ///
    /// # Errors
    /// No figure; a figure per sample without a rate.
    pub fn typed(given: &Given) -> Result<Self, FormatError> {
        let mut source = Self::new(Format::Datasheet);
        source.figures.rate = given.rate;
        if given.quantities.is_empty() {
            return Err(FormatError::Nothing);
        }
        source.take(given)?;
        Ok(source)
    }

    /// Lets what was typed win.
    pub(super) fn take(&mut self, given: &Given) -> Result<(), FormatError> {
        for quantity in Figure::ALL.into_iter().filter_map(|figure| given.quantity(figure)) {
            let place = format!("--{}", quantity.figure().flag());
            let rate = self.figures.rate;
            let steps = quantity
                .clone()
                .into_figures(&place, &mut self.figures, rate)
                .map_err(|problem| FormatError::Quantity { place: place.clone(), problem })?;
            self.steps.extend(steps);
        }
        Ok(())
    }
}
