//! `dpn train`.

use super::training_curve::draw_curve;
use super::{corpus, device, stop, sweep};
use crate::args::TrainArgs;
use crate::ui::{Bar, Interrupted, errln, outln, refuse};
use anyhow::Result;
use dpn_core::Sensor;
use dpn_core::config::Validate;
use dpn_train::config::TrainConfig;
use dpn_train::run::{Run, RunError};
use dpn_train::trainer::TrainError;
use std::path::Path;

pub(crate) fn run(args: TrainArgs) -> Result<()> {
    let sensor = match (&args.many, args.sensor) {
        (Some(plan), _) => return sweep::many(plan, &args),
        (None, sensor) => sensor.expect("clap asks for a sensor where there is no plan"),
    };
    let config = config(&args, sensor)?;
    let device = device::parse(args.device.as_deref().unwrap_or(device::CPU))?;
    let corpus = corpus::to_train(corpus::load(args.data.as_deref(), config.rate_hz)?)?;
    let out = args.out.unwrap_or_else(|| {
        let base = config.base.base();
        let rate = args.rate.map_or_else(String::new, |rate| format!("-{}hz", rate.hz()));
        format!("runs/train-{sensor}-{}-{base}{rate}-seed{}", corpus.name, config.seed).into()
    });
    let run = Run::open(&out, &config, &corpus, &device, args.resume)?;
    let (done, total) = run.epochs();
    if done > 0 {
        errln!("resume {} after {done} of {total} epochs", out.display());
    } else if args.resume {
        errln!("{}: no epoch was finished there; it is begun anew", out.display());
    }
    let stop = stop::on_ctrl_c("the epochs that were finished are kept: add --resume to go on")?;
    match run.train(&stop, &mut Bar::new()) {
        Ok((summary, weights)) => {
            draw_curve(sensor, &summary, &out)?;
            if args.json {
                outln!("{}", serde_json::to_string(&summary)?)?;
            } else {
                outln!(
                    "{}: {} on {}, {} windows, {} parameters, validation RMSE {:.5} {} (epoch {})",
                    weights.display(),
                    summary.base,
                    summary.data,
                    summary.fit_windows,
                    summary.parameters,
                    summary.validation_rmse,
                    sensor.unit(),
                    summary.best_epoch
                )?;
            }
            Ok(())
        }
        Err(RunError::Train(TrainError::Stopped { epoch: 1 })) => Err(Interrupted(
            "stopped in epoch 1, before any was finished: the same command begins anew".into(),
        )
        .into()),
        Err(RunError::Train(TrainError::Stopped { epoch })) => Err(Interrupted(format!(
            "stopped in epoch {epoch}; the epochs before it are kept: add --resume to go on"
        ))
        .into()),
        Err(error) => Err(error.into()),
    }
}

/// The file's keys, then the flags over them.
fn config(args: &TrainArgs, sensor: Sensor) -> Result<TrainConfig> {
    let mut sets = args.sets.clone();
    sets.extend(args.rate.map(|rate| ("rate_hz".to_owned(), rate.hz().to_string())));
    let mut config = dpn_train::config::load_over(args.config.as_deref(), &sets, sensor)?;
    if config.sensor() != sensor {
        let named = args.config.as_deref().unwrap_or(Path::new("--set network.sensor"));
        return refuse(
            format!("{} is for the sensor `{}`", named.display(), config.sensor()),
            format!("say --sensor {}, or give a configuration for `{sensor}`", config.sensor()),
        );
    }
    if let Some(seed) = args.seed {
        config.seed = seed;
    }
    if let Some(epochs) = args.epochs {
        config.fit.epochs = epochs;
    }
    if let Some(base) = args.base {
        config.base.set(base);
    }
    // Flags may have moved a value out of its bounds.
    config.validate()?;
    Ok(config)
}
