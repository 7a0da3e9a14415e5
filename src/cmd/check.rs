//! `dpn check`.

use super::{apart, log, many};
use crate::args::{CheckArgs, FailOn};
use crate::ui::{Untrusted, out, outln, print_pictures, results};
use anyhow::Result;
use dpn_figures::{save_if_any, spectrum_plot};
use dpn_probe::Weight;
use dpn_probe::doctor::{Examination, examine_log, table};
use std::path::{Path, PathBuf};

pub(crate) fn run(args: &CheckArgs) -> Result<()> {
    let logs = many::logs(&args.logs, Some(args.out.join("check.json").path()))?;
    let gravest = match &logs[..] {
        [only] if args.logs.len() == 1 && *only == args.logs[0] => one(args, only)?,
        several => all(args, several)?,
    };
    let most = match args.fail_on {
        Some(FailOn::Bad) => Weight::Bad,
        Some(FailOn::Warning) => Weight::Warning,
        None => return Ok(()),
    };
    if gravest <= most { Err(Untrusted::Found(gravest).into()) } else { Ok(()) }
}

fn examined(args: &CheckArgs, path: &Path) -> Result<Examination> {
    Ok(examine_log(&log::read_quietly(path, args.span, &args.how)?)?)
}

/// A table of logs.
fn all(args: &CheckArgs, logs: &[PathBuf]) -> Result<Weight> {
    apart::folder("--out", &args.out, &["check.json"], logs)?;
    let rows = many::looked_at(logs, |path| examined(args, path));
    if !results(args.out.join("check.json"), &table::json(&rows)?, args.json)? {
        out!("{}", table::page(&rows))?;
    }
    many::read_some(&args.logs, &rows)?;
    Ok(table::gravest(&rows))
}

/// One log, its findings and the picture of its spectra.
fn one(args: &CheckArgs, path: &Path) -> Result<Weight> {
    apart::folder("--out", &args.out, &["check.json", "spectra.*"], &[path])?;
    let examination = examined(args, path)?;
    let gravest = examination.findings.first().map_or(Weight::Note, |finding| finding.weight);
    let words = format!("{} samples, {:.0} s.", examination.samples, examination.length_s);
    // A short log has findings but no spectrum; a dead sensor has one without power.
    let files = save_if_any(spectrum_plot(&examination.spectra, &words), args.out.join("spectra"))?;
    // Last: where it lies, the rest does too.
    if results(args.out.join("check.json"), &examination, args.json)? {
        return Ok(gravest);
    }
    outln!("{} samples, {:.1} s, {:.2} Hz", examination.samples, examination.length_s, examination.rate_hz)?;
    for finding in &examination.findings {
        outln!("{:8} {}: {}", format!("{}:", finding.weight), finding.about, finding.text)?;
        if let Some(remedy) = finding.remedy {
            outln!("         -> {remedy}")?;
        }
    }
    print_pictures(&files)?;
    if files.is_empty() && !examination.spectra.is_empty() {
        outln!("no picture: both sensors never change, so there is no spectrum")?;
    }
    Ok(gravest)
}
