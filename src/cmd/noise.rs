//! `dpn noise`.

use super::{against, apart, convert, follow, into, learned, log, many, rerun, shipped};
use crate::args::{NoiseArgs, NoiseWhat, RowFormat};
use crate::ui::{errln, out, outln, print_pictures, refuse, results, warn};
use anyhow::{Context, Result};
use dpn_core::estimate::NoiseSpec;
use dpn_core::{Recorded, SampleRate, Samples};
use dpn_figures::{log_noise_plot, save};
use dpn_io::noise_formats::{Format, Given, NoiseCalibration, read};
use dpn_io::{atomic_write, write_noise_rows};
use dpn_probe::Finding;
use dpn_probe::doctor::examine_log;
use dpn_probe::doctor::table::json;
use dpn_probe::log_noise::table::{NoiseOfLog, page};
use dpn_probe::log_noise::{Along, Plan, report};
use dpn_pronet::network::Network;
use std::path::{Path, PathBuf};

pub(crate) fn run(args: &NoiseArgs) -> Result<()> {
    if let Some(NoiseWhat::Convert(args)) = &args.what {
        return convert::run(args);
    }
    if !args.learned.is_empty() {
        return learned::together(&args.learned, &args.paste, &args.out, args.json);
    }
    let logs = many::logs(&args.logs, Some(args.out.join("summary.json").path()))?;
    let log = match &logs[..] {
        [] => None,
        [only] if args.logs.len() == 1 && *only == args.logs[0] => Some(only),
        several => return all(args, several),
    };
    if let Some(log) = log {
        apart_from(args, log)?;
        if let Some(trajectory) = &args.against {
            return against::run(args, log, trajectory);
        }
    }
    let networks = shipped::or_of(args.weights.as_deref())?;
    match log {
        Some(path) => along(args, path, &networks),
        None => follow::run(args, &plan(args, follow::rate(&args.how), &networks)?),
    }
}

/// Refuses results over what is read.
fn apart_from(args: &NoiseArgs, log: &PathBuf) -> Result<()> {
    let read: Vec<&PathBuf> = [log].into_iter().chain(&args.against).chain(&args.check).collect();
    for (flag, file) in [("--into", &args.into), ("--rerun", &args.rerun)] {
        file.as_deref().map_or(Ok(()), |file| apart::file(flag, file, &read))?;
    }
    let files: &[&str] = match (&args.against, args.format) {
        (Some(_), _) => &["against.json", "biases.csv"],
        (None, RowFormat::Csv) => &["summary.json", "plot.*", "noise.csv"],
        (None, RowFormat::Jsonl) => &["summary.json", "plot.*", "noise.jsonl"],
    };
    apart::folder("--out", &args.out, files, &read)
}

/// A table of logs.
fn all(args: &NoiseArgs, logs: &[PathBuf]) -> Result<()> {
    let of_one = [
        ("--noise", args.noise.is_some()),
        ("--weights", args.weights.is_some()),
        ("--against", args.against.is_some()),
        ("--paste", !args.paste.paste.0.is_empty()),
        ("--into", args.into.is_some()),
        ("--rerun", args.rerun.is_some()),
        ("--check", args.check.is_some()),
    ];
    if let Some((flag, _)) = of_one.into_iter().find(|(_, given)| *given) {
        let message = format!("{flag} is for one log, and {} are named", logs.len());
        return refuse(message, "leave it away for a table of all, or name one log");
    }
    apart::folder("--out", &args.out, &["summary.json"], logs)?;
    let rows = many::looked_at(logs, |path| {
        let log = log::read_quietly(path, args.span, &args.how)?;
        Ok(NoiseOfLog::of(&log.recording, &examine_log(&log)?)?)
    });
    if !results(args.out.join("summary.json"), &json(&rows)?, args.json)? {
        out!("{}", page(&rows))?;
    }
    many::read_some(&args.logs, &rows)
}

fn plan<'a>(args: &NoiseArgs, rate: SampleRate, networks: &'a [Network]) -> Result<Plan<'a>> {
    let spec: Option<NoiseSpec> = args.noise.as_deref().map(str::parse).transpose()?;
    plan_of(spec.as_ref(), rate, args.every as usize, networks)
}

/// What was asked for, or the networks where the rate is theirs and a simple estimator where not, said.
pub(super) fn plan_of<'a>(
    spec: Option<&NoiseSpec>,
    rate: SampleRate,
    every: usize,
    networks: &'a [Network],
) -> Result<Plan<'a>> {
    if let Some(spec) = spec {
        return Ok(Plan::new(spec, rate, every, networks)?);
    }
    let (plan, note) = Plan::fitting(rate, every, networks)?;
    if let Some(note) = note {
        errln!("note: {note} (--noise)");
    }
    Ok(plan)
}

fn along(args: &NoiseArgs, path: &Path, networks: &[Network]) -> Result<()> {
    rerun::check(args.rerun.as_deref())?;
    let log = log::read_part(path, args.span, &args.how)?;
    if args.into.is_some() {
        into::check(path, &log, &args.how)?;
    }
    let recording = &log.recording;
    let rate = recording.rate();
    // A configuration that cannot be read should not cost a track.
    let config = config(args.check.as_deref(), args.check_as, rate)?;
    let plan = plan(args, rate, networks)?;
    let along = Along::of(&plan, recording, config.as_ref()).with_context(|| path.display().to_string())?;
    let Along { track, summary, warnings, rest, effective, check } = &along;
    let mut words = format!("{} samples, {:.0} s.", recording.len(), recording.length_s());
    for line in report::outside(summary) {
        words.push_str(&format!(" {line}."));
    }
    let plot = log_noise_plot(recording, track, &plan, summary, &words)?;
    let files = save(&plot, args.out.join("plot"))?;
    let written = match args.format {
        RowFormat::Csv => {
            let file = args.out.join("noise.csv");
            write_noise_rows(&file, |row| track.each(|a| row(a.t, &a.noise)))?;
            file
        }
        RowFormat::Jsonl => {
            let file = args.out.join("noise.jsonl");
            atomic_write(&file, |out| track.each(|a| writeln!(out, "{}", follow::json(a))))?;
            file
        }
    };
    #[cfg(feature = "rerun")]
    if let Some(file) = &args.rerun {
        rerun::noise(file, &path.display().to_string(), recording, (track, plan.every()))?;
    }
    let mut all = along.json(&path.display().to_string(), &plan, recording)?;
    let into = args.into.as_ref().map(|file| {
        into::write(file, path, &log, &args.how, (track, plan.unknown_s())).map(|words| (file, words))
    });
    let into = into.transpose()?;
    if let Some((file, words)) = &into {
        all["into"] = serde_json::json!({ "file": file, "messages": words });
    }
    warn(warnings);
    if results(args.out.join("summary.json"), &all, args.json)? {
        return Ok(());
    }
    out!("{}", report::page(&plan, summary, rate))?;
    if let Some(rest) = rest {
        out!("{}", rest.page())?;
    }
    if let Some(effective) = effective {
        out!("{}", effective.page(&args.paste.paste.0))?;
    }
    if let (Some(path), Some(source), Some(check)) = (&args.check, &config, check) {
        let (path, format, levels) = (path.display(), source.format, &check.levels);
        outln!("\n{path} as {format}, against this log ({levels}):")?;
        print_findings(check.findings())?;
        outln!("note:    {}", check.walks_by)?;
        print_remarks(source)?;
    }
    outln!("\ntrack:    {}", written.display())?;
    if let Some((file, words)) = &into {
        outln!("log:      {} ({words})", file.display())?;
    }
    Ok(print_pictures(&files)?)
}

/// A configuration that is held against a log of `rate`.
pub(super) fn config(
    path: Option<&Path>,
    format: Option<Format>,
    rate: SampleRate,
) -> Result<Option<NoiseCalibration>> {
    let given = Given { rate: Some(rate), rate_of_log: true, keep_zeros: true, ..Given::default() };
    Ok(path.map(|path| read(path, format, &given)).transpose()?)
}

/// What is said of a configuration's figures, a line each.
pub(super) fn print_findings(findings: impl IntoIterator<Item = Finding>) -> Result<()> {
    for finding in findings {
        outln!("{} {}", if finding.warns() { "warning:" } else { "ok:     " }, finding.text)?;
    }
    Ok(())
}

/// What its reader remarked.
pub(super) fn print_remarks(source: &NoiseCalibration) -> Result<()> {
    for remark in &source.remarks {
        outln!("note:    {remark}")?;
    }
    Ok(())
}
