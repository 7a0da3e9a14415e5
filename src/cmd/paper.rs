//! `dpn paper`.

use super::cores::cores;
use super::{cache, device, program, program_of, settings, shipped, stop};
use crate::args::PaperArgs;
use crate::ui::{Bar, Interrupted, errln, outln, refuse, warn};
use anyhow::Result;
use dpn_core::Sensor;
use dpn_eval::closed_loop::{Experiment, Settings};
use dpn_io::FolderLock;
use dpn_papers::{Done, Input, Paper, PaperError, PaperPlan, id};
use dpn_pronet::network;
use dpn_pronet::network::Network;
use dpn_train::config::TrainConfig;
use dpn_train::corpus::Corpus;
use dpn_train::run::{Run, RunError};
use dpn_train::trainer::TrainError;
use std::path::Path;
use std::sync::atomic::AtomicBool;

pub(crate) fn run(args: &PaperArgs) -> Result<()> {
    let opened = asked(args)?.open()?;
    let input = &opened.input;
    warn(input.missing.iter().map(|missing| format!("no row for {}: {}", missing.name, missing.reason)));
    let _work = FolderLock::take(&args.work)?;
    let same = std::fs::canonicalize(args.work.path()).ok() == std::fs::canonicalize(args.out.path()).ok();
    let _out = if same { None } else { Some(FolderLock::take(&args.out)?) };
    let stop = stop::on_ctrl_c("what was finished is kept, and the same command goes on from there")?;
    let networks = chosen_networks(args, input, &stop)?;
    let judged = shipped::judged(&networks, args.models.as_deref(), &args.more_models)?;
    let measured_by = args.measured_by.as_deref().map(program_of);
    let cache = cache::open(&args.cache)?;
    let paper = Paper {
        judged: &judged,
        measured_by: measured_by.as_deref(),
        command: command(),
        work: args.work.clone(),
        out: args.out.clone(),
        threads: args.threads.unwrap_or_else(cores).max(1),
        cache: cache.as_ref(),
        ..Paper::new(&opened, &networks, program())
    };
    warn(paper.warnings()?);
    let done = stop::outcome(paper.run(&stop, &mut Bar::new()), PaperError::is_stop)?;
    cache::say(cache.as_ref());
    say(&done, args.json)
}

/// The flags as a plan.
fn asked(args: &PaperArgs) -> Result<PaperPlan> {
    if args.settings.calib.is_some() {
        let remedy = "each recording has its own cam0/sensor.yaml; --calib is for `dpn run` and `dpn eval --closed-loop`";
        return refuse("`dpn paper` takes no --calib", remedy);
    }
    Ok(PaperPlan {
        plan: args.plan.clone().map(Settings::File),
        quick: args.quick,
        camera: args.camera,
        run: Experiment {
            data: args.data.clone(),
            models: args.models.clone(),
            tracks: args.tracks.clone(),
            sequences: args.sequences.clone(),
            from: args.from,
            ..settings::experiment(&args.settings)?
        },
        ..PaperPlan::default()
    })
}

fn say(done: &Done, json: bool) -> Result<()> {
    if json {
        outln!("{}", serde_json::to_string(done)?)?;
        return Ok(());
    }
    for stage in &done.stages {
        let how = if stage.cached { "as it was" } else { "made" };
        errln!("{:28} {how:10} {:7.1} s  {}", stage.name, stage.seconds, stage.run);
    }
    for finding in &done.findings {
        outln!("* {finding}")?;
    }
    outln!("\npage: {}", done.page.display())?;
    Ok(())
}

/// The command as a person would type it again: the program's name without its folder.
fn command() -> String {
    let quoted = |word: String| {
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@".contains(c);
        if word.chars().all(plain) { word } else { format!("'{word}'") }
    };
    let words: Vec<String> = std::env::args().skip(1).map(quoted).collect();
    format!("dpn {}", words.join(" "))
}

/// The networks: those that come with the program, a folder's, or trained now.
fn chosen_networks(args: &PaperArgs, input: &Input, stop: &AtomicBool) -> Result<Vec<Network>> {
    if let Some(dir) = &args.models {
        return Ok(network::load_all(dir)?);
    }
    let mut all = shipped::networks()?;
    if args.train {
        for sensor in Sensor::ALL {
            let trained = train(args, sensor, &input.corpus, stop)?;
            // It takes the place of the shipped one of that name.
            let tag = format!("{sensor}/{}", dpn_core::estimate::DEFAULT_TAG);
            all.retain(|n| !n.path.with_extension("").to_string_lossy().ends_with(&tag));
            all.push(trained);
        }
    }
    Ok(all)
}

/// Trains the default network of a sensor in a folder named for what it is made from; one that is there is taken.
fn train(args: &PaperArgs, sensor: Sensor, corpus: &Corpus, stop: &AtomicBool) -> Result<Network> {
    let mut config = TrainConfig::for_sensor(sensor);
    config.fit.epochs = args.epochs.unwrap_or(config.fit.epochs);
    let text = serde_json::to_string(&config.resolved())?;
    let folder = format!("network-{sensor}-{}", id([program(), corpus.fingerprint(), text]));
    let dir = args.work.join(folder);
    let name = Path::new("trained")
        .join(sensor.name())
        .join(format!("{}.safetensors", dpn_core::estimate::DEFAULT_TAG));
    let done = dir.join(format!("{sensor}.safetensors"));
    if !(done.is_file() && dir.join("summary.json").is_file()) {
        let device = device::parse(device::CPU)?;
        let resume = dir.join("checkpoint.safetensors").is_file();
        match Run::open(&dir, &config, corpus, &device, resume)?.train(stop, &mut Bar::new()) {
            Err(RunError::Train(TrainError::Stopped { epoch })) => {
                let message = format!(
                    "stopped in epoch {epoch} of the {sensor} network; the same command goes on from there"
                );
                return Err(Interrupted(message).into());
            }
            other => other?,
        };
    }
    let network = Network::load(done.path())?;
    Ok(Network { path: name, ..network })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Cli, Command};
    use clap::Parser;

    #[test]
    fn flags_that_are_left_out_are_keys_that_are_left_out_of_a_plan() {
        let Command::Paper(args) = Cli::parse_from(["dpn", "paper"]).command else {
            panic!("paper was typed")
        };
        assert_eq!(asked(&args).expect("defaults hold together"), PaperPlan::default());
    }
}
