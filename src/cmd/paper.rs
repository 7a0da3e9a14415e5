//! `dpn paper`.

use super::cores::cores;
use super::{cache, program, program_of, settings, shipped, stop};
use crate::args::PaperArgs;
use crate::ui::{Bar, errln, outln, refuse, warn};
use anyhow::Result;
use dpn_eval::closed_loop::{Experiment, Settings};
use dpn_io::FolderLock;
use dpn_papers::{Done, Paper, PaperError, PaperPlan};
use dpn_pronet::network;

pub(crate) fn run(args: &PaperArgs) -> Result<()> {
    let opened = asked(args)?.open()?;
    warn(
        opened.input.missing.iter().map(|missing| format!("no row for {}: {}", missing.name, missing.reason)),
    );
    let _work = FolderLock::take(&args.work)?;
    let same = std::fs::canonicalize(args.work.path()).ok() == std::fs::canonicalize(args.out.path()).ok();
    let _out = if same { None } else { Some(FolderLock::take(&args.out)?) };
    let stop = stop::on_ctrl_c("what was finished is kept, and the same command goes on from there")?;
    let networks = match &args.models {
        Some(dir) => network::load_all(dir)?,
        None => shipped::networks()?,
    };
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
