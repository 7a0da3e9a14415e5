//! `dpn report`.

use super::{apart, log, many, program, shipped};
use crate::args::ReportArgs;
use crate::ui::outln;
use anyhow::Result;
use dpn_core::Recorded;
use dpn_figures::{
    FigureError, Plot, allan_plot, if_any, log_noise_plot, save, spectra_by_motors, spectrogram,
    spectrum_plot,
};
use dpn_io::noise_formats::{Format, Written};
use dpn_io::{ResultPath, printable, write_file};
use dpn_papers::{FindingWords, LogReport, LogSection};
use dpn_probe::Finding;
use dpn_probe::allan::AllanLog;
use dpn_probe::doctor::{Examination, examine_log};
use dpn_probe::log_noise::{Along, LogNoiseError, Plan, report};
use dpn_pronet::network::Network;
use std::path::{Path, PathBuf};

/// Samples from one answer of the networks to the next.
const EVERY: usize = 10;
/// Shorter rests have no Allan plot on the page: they show white noise alone \[s\].
const ALLAN_S: f64 = 30.0;
/// What comes into a folder of figures.
const FIGURES: [&str; 5] = ["signal.*", "spectra.*", "spectrogram.*", "motors.*", "allan.*"];

pub(crate) fn run(args: &ReportArgs) -> Result<()> {
    let logs = many::logs(&args.logs, None)?;
    // A page inside a log's folder is no part of the log.
    let is_page = args.out.path().extension().is_some_and(|ending| ending == "html");
    let read: Vec<&Path> =
        logs.iter().map(PathBuf::as_path).filter(|log| !(is_page && log.is_dir())).collect();
    apart::file("--out", args.out.path(), &read)?;
    for path in &logs {
        if let Some(folder) = figures(args, &logs, path) {
            apart::folder("--figures", &folder, &FIGURES, &read)?;
        }
    }
    let networks = shipped::networks()?;
    let mut missing = Ok(());
    let page = LogReport {
        logs: match &logs[..] {
            // What is wrong with the only log is an error.
            [only] => vec![section(args, only, figures(args, &logs, only).as_ref(), &networks)?],
            several => {
                let rows = many::looked_at(several, |path| {
                    section(args, path, figures(args, &logs, path).as_ref(), &networks)
                });
                missing = many::read_some(&args.logs, &rows);
                if rows.iter().all(|(_, row)| row.is_err()) {
                    return missing;
                }
                let unread =
                    |name, error: String| LogSection::new(name, format!("It cannot be read: {error}"));
                rows.into_iter().map(|(name, row)| row.unwrap_or_else(|error| unread(name, error))).collect()
            }
        },
        made_by: program::program(),
    };
    let text = page.html()?;
    write_file(&args.out, &text)?;
    outln!("{}: {} kB, {} log(s)", args.out.display(), text.len() / 1000, page.logs.len())?;
    if let Some(folder) = &args.figures {
        outln!("figures:  {}", folder.display())?;
    }
    missing
}

/// Where the figures of one of the logs come, where they are asked for; of several, by its number on the page and its name.
fn figures(args: &ReportArgs, logs: &[PathBuf], log: &Path) -> Option<ResultPath> {
    let folder = args.figures.clone()?;
    let number = logs.iter().position(|path| path == log)? + 1;
    let name = log.file_stem().unwrap_or(log.as_os_str()).to_string_lossy();
    Some(if logs.len() == 1 { folder } else { folder.join(format!("{number}-{}", printable(&name))) })
}

/// All that is said of one log.
fn section(
    args: &ReportArgs,
    path: &Path,
    into: Option<&ResultPath>,
    networks: &[Network],
) -> Result<LogSection> {
    let log = log::read_quietly(path, args.span, &args.how)?;
    let Examination { samples, length_s, rate_hz, findings, spectra, .. } = examine_log(&log)?;
    let recording = &log.recording;
    let words = |Finding { weight, about, text, remedy }: Finding| FindingWords {
        weight: weight.to_string(),
        about: about.to_owned(),
        text,
        remedy: remedy.map(str::to_owned),
    };
    let taken = log.guesses.join(", ");
    let taken = if taken.is_empty() { String::new() } else { format!(" Taken for granted: {taken}.") };
    let facts = format!("{samples} samples, {length_s:.1} s, {rate_hz:.2} Hz.{taken}");
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let mut page = LogSection::new(printable(&name), facts);
    page.findings = findings.into_iter().map(words).collect();
    let (plan, _) = Plan::fitting(recording.rate(), EVERY, networks)?;
    match Along::of(&plan, recording, None) {
        Ok(along) => {
            let plot = log_noise_plot(recording, &along.track, &plan, &along.summary, "");
            draw(&mut page, into, ["signal", "The signal, and its noise along the log"], plot)?;
            draw(&mut page, into, ["spectra", "Spectra"], spectrum_plot(&spectra, ""))?;
            draw(&mut page, into, ["spectrogram", "Spectra along the log"], spectrogram(recording, ""))?;
            let motors = spectra_by_motors(recording, &log.motors, "");
            draw(&mut page, into, ["motors", "Spectra against the motors"], motors)?;
            let mut text: String =
                along.warnings.iter().map(|warning| format!("warning: {warning}\n")).collect();
            text.push_str(&report::page(&plan, &along.summary, recording.rate()));
            page.texts.push(("Noise along the log".to_owned(), text));
            if let Some(rest) = &along.rest {
                page.texts.push(("Noise at rest".to_owned(), rest.page()));
            }
            if let Some(effective) = &along.effective {
                page.texts.push(("Figures for an estimator".to_owned(), effective.page(&[])));
                let lines = |Written { format, text, .. }: Written| (format.to_string(), text);
                page.lines = effective.paste.written(&Format::ALL).into_iter().map(lines).collect();
            }
        }
        // What is too short for noise has findings all the same.
        Err(LogNoiseError::TooShort { .. }) => {}
        Err(error) => return Err(error.into()),
    }
    if let Ok(allan) = AllanLog::of(&log.recording.held()?, false)
        && allan.length_s >= ALLAN_S
    {
        let words = format!("{} samples, {:.0} s at rest.", allan.samples, allan.length_s);
        draw(&mut page, into, ["allan", "Allan deviation at rest"], allan_plot(&allan.axes, &words))?;
    }
    Ok(page)
}

/// A figure, where there is something to draw: on the page, and in the folder where one was named.
fn draw<P: Plot>(
    page: &mut LogSection,
    into: Option<&ResultPath>,
    [name, title]: [&'static str; 2],
    plot: Result<P, FigureError>,
) -> Result<()> {
    let Some(plot) = if_any(plot)? else { return Ok(()) };
    if let Some(folder) = into {
        save(&plot, folder.join(name))?;
    }
    Ok(page.draw(name, title, &plot)?)
}
