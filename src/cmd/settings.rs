//! The estimator's settings and those of what is simulated, from files and flags.

use crate::args::SettingsArgs;
use anyhow::Result;
use dpn_eval::closed_loop::Experiment;
use dpn_io::calibration::{self, Calibration};
use dpn_io::config::load_over;
use dpn_sim::tracks::TracksConfig;
use dpn_sim::{FlightConfig, RenderConfig};
use dpn_vio::EstimatorConfig;

/// The file's keys, then those set one by one.
pub(crate) fn estimator(args: &SettingsArgs) -> Result<EstimatorConfig> {
    Ok(load_over(args.config.as_deref(), &args.sets)?)
}

/// All of them, in an experiment that is else the default.
pub(crate) fn experiment(args: &SettingsArgs) -> Result<Experiment> {
    Ok(Experiment {
        estimator: estimator(args)?.into(),
        simulated_tracks: tracks(args)?.into(),
        images: images(args)?.into(),
        flights: flights(args)?.into(),
        ..Experiment::default()
    })
}

/// The file's keys over the defaults.
pub(crate) fn tracks(args: &SettingsArgs) -> Result<TracksConfig> {
    Ok(load_over(args.tracks_config.as_deref(), &[])?)
}

/// The file's keys over the defaults.
pub(crate) fn images(args: &SettingsArgs) -> Result<RenderConfig> {
    Ok(load_over(args.images_config.as_deref(), &[])?)
}

/// The file's keys, then the flag over them.
pub(crate) fn flights(args: &SettingsArgs) -> Result<FlightConfig> {
    let mut config: FlightConfig = load_over(args.flight_config.as_deref(), &[])?;
    if args.no_vibration {
        config.vibration.scale = 0.0;
    }
    Ok(config)
}

/// The camera's calibration, where one is given.
pub(crate) fn calibration(args: &SettingsArgs) -> Result<Option<Calibration>> {
    Ok(args.calib.as_deref().map(calibration::read).transpose()?)
}
