//! Figures: one style, a handful of plots, each saved as SVG, PNG and the CSV of exactly what is drawn.
//!
//! A plot is made from slices and labels and knows no file and no network. It checks its input and computes what will be
//! drawn when it is built ([`PredictedVsTrue::new`], [`RmseVsSigma::new`], [`FlightSigma::new`]), so that drawing cannot
//! fail on data. [`save`] writes it; the same input gives the same bytes. Text in SVG stays text, the font of the PNG is
//! DejaVu Sans from a crate: no system library and no system font is used.

mod allan_plot;
mod axis;
mod error;
mod flight;
mod flight_sigma;
mod frame;
mod legend;
mod plot;
mod predicted_vs_true;
mod raster;
mod rmse_vs_sigma;
mod sheet;
mod spectrum_plot;
mod style;
mod summary;
mod timeline;
mod top_view;
mod track_picture;

pub use allan_plot::AllanPlot;
pub use error::FigureError;
pub use flight::{Flight, Phase};
pub use flight_sigma::FlightSigma;
pub use plot::{DrawError, Drawn, Plot, save};
pub use predicted_vs_true::{Predicted, PredictedVsTrue};
pub use rmse_vs_sigma::RmseVsSigma;
pub use spectrum_plot::SpectrumPlot;
pub use timeline::{Timeline, TimelinePanel};
pub use top_view::TopView;
pub use track_picture::{TrackDot, TrackEnd, TrackPicture};
