//! Figures: one style, a handful of plots, each saved as SVG, PDF, PNG and the CSV of exactly what is drawn.
//!
//! [`Table`] is the one table: Markdown, CSV, LaTeX, a console.
//!
//! A plot is made from slices and labels and knows no file and no network. It checks its input and computes what will be
//! drawn when it is built ([`rmse_vs_sigma`], [`flight_sigma`]), so that drawing cannot
//! fail on data. [`save`] writes it; the same input gives the same bytes. Text in SVG stays text, the letters of PDF and PNG are
//! those of DejaVu Sans from a crate: no system library and no system font is used.

#![cfg_attr(test, allow(clippy::unwrap_used))]

mod album;
mod allan_plot;
mod axis;
mod belief;
mod chart;
mod error;
mod error_band;
mod flight;
mod flight_sigma;
mod flight_views;
mod frame;
mod heat;
mod legend;
mod letters;
mod log_noise_plot;
mod pdf;
mod plot;
mod provenance;
mod raster;
mod rmse_vs_sigma;
mod sheet;
mod spectrogram;
mod spectrum_plot;
mod style;
mod summary;
mod sweep_curve;
mod table;
mod timeline;
mod top_view;
mod track_picture;
mod training_curve;
mod trajectories;
mod trajectory_errors;
mod turn_errors;

pub use album::Album;
pub use allan_plot::allan_plot;
pub use belief::PoseBelief;
pub use chart::Chart;
pub use error::FigureError;
pub use error_band::{ErrorColumn, error_band};
pub use flight::{Flight, Phase};
pub use flight_sigma::flight_sigma;
pub use flight_views::{timeline, top_view};
pub use log_noise_plot::log_noise_plot;
pub use plot::{Drawn, ENDINGS, Plot, if_any, save, save_if_any, svg};
pub use provenance::Provenance;
pub use rmse_vs_sigma::rmse_vs_sigma;
pub use spectrogram::{spectra_by_motors, spectrogram};
pub use spectrum_plot::{spectra_of_two, spectrum_plot};
pub use sweep_curve::{SweepPoint, sweep_curve};
pub use table::{Cell, Column, ColumnKind, Line, Table};
pub use track_picture::{TrackDot, TrackEnd, TrackPicture};
pub use training_curve::training_curve;
pub use trajectories::{TrajectoryPanel, trajectories};
pub use trajectory_errors::trajectory_errors;
pub use turn_errors::{TurnErrors, turn_errors};

/// The README's code is a test.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
