//! `dpn allan`.

use super::{apart, log, noise};
use crate::args::AllanArgs;
use crate::ui::{out, outln, print_pictures, refuse, results};
use anyhow::Result;
use dpn_figures::{allan_plot, save};
use dpn_probe::allan::compare::{FigureCheck, compare};
use dpn_probe::allan::{AllanLog, report};
use dpn_probe::rest_noise::RestNoise;
use std::path::PathBuf;

pub(crate) fn run(args: &AllanArgs) -> Result<()> {
    let read: Vec<&PathBuf> = [&args.log.path].into_iter().chain(&args.check).collect();
    apart::folder("--out", &args.out, &["allan.json", "allan.*"], &read)?;
    let log = log::read(&args.log)?;
    if log.alone.is_some() {
        let hint = "`dpn noise LOG` says its white noise at rest; or give the folder in which the other sensor's file lies too";
        return refuse("an Allan plot is of both sensors, and the log has one alone", hint);
    }
    let recording = log.recording.held()?;
    // A configuration that cannot be read should not cost a fit.
    let config = noise::config(args.check.as_deref(), args.check_as, recording.rate())?;
    let allan = AllanLog::of(&recording, args.all)?;
    let checked = config.as_ref().map(|source| compare(source, &allan));
    let mut words = format!("{} samples, {:.0} s.", allan.samples, allan.length_s);
    for line in allan.spectrum.iter().flat_map(RestNoise::between) {
        words.push_str(&format!(" {line}."));
    }
    let files = save(&allan_plot(&allan.axes, &words)?, args.out.join("allan"))?;
    if results(args.out.join("allan.json"), &report::json(&allan, checked.as_deref())?, args.json)? {
        return Ok(());
    }
    out!("{}", report::page(&allan))?;
    if let (Some(path), Some(source), Some(checked)) = (&args.check, &config, &checked) {
        outln!("\n{} as {}, against this log at rest:", path.display(), source.format)?;
        noise::print_findings(checked.iter().map(FigureCheck::finding))?;
        noise::print_remarks(source)?;
    } else {
        out!("{}", report::lines_to_paste(&allan)?)?;
    }
    out!("\n")?;
    Ok(print_pictures(&files)?)
}
