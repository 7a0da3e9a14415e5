//! `dpn check`.

use super::{apart, log, many};
use crate::args::{CheckArgs, FailOn};
use crate::ui::{Found, out, outln, print_pictures};
use anyhow::Result;
use dpn_figures::{FigureError, save, spectrum_plot};
use dpn_io::atomic_write;
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
    if gravest <= most { Err(Found(gravest.to_string()).into()) } else { Ok(()) }
}

fn examined(args: &CheckArgs, path: &Path) -> Result<Examination> {
    Ok(examine_log(&log::read_quietly(path, args.span, &args.how)?)?)
}

/// A table of logs.
fn all(args: &CheckArgs, logs: &[PathBuf]) -> Result<Weight> {
    apart::folder("--out", &args.out, &["check.json"], logs)?;
    let rows = many::looked_at(logs, |path| examined(args, path));
    let text = table::json(&rows)?.to_string() + "\n";
    atomic_write(args.out.join("check.json"), |file| file.write_all(text.as_bytes()))?;
    if args.json {
        out!("{text}")?;
    } else {
        out!("{}", table::page(&rows))?;
    }
    many::read_some(&args.logs, &rows)?;
    Ok(table::gravest(&rows))
}

/// One log, its findings and the picture of its spectra.
fn one(args: &CheckArgs, path: &Path) -> Result<Weight> {
    apart::folder("--out", &args.out, &["check.json", "spectra.svg", "spectra.png", "spectra.csv"], &[path])?;
    let examination = examined(args, path)?;
    let gravest = examination.findings.first().map_or(Weight::Note, |finding| finding.weight);
    let text = serde_json::to_string(&examination)? + "\n";
    let words = format!("{} samples, {:.0} s.", examination.samples, examination.length_s);
    // A short log has findings but no spectrum; a dead sensor has one without power.
    let plot = match &examination.spectra[..] {
        [] => None,
        spectra => match spectrum_plot(spectra, &words) {
            Ok(plot) => Some(plot),
            Err(FigureError::Empty { .. }) => None,
            Err(error) => return Err(error.into()),
        },
    };
    let files = plot.map(|plot| save(&plot, args.out.join("spectra"))).transpose()?.unwrap_or_default();
    // Last: where it lies, the rest does too.
    atomic_write(args.out.join("check.json"), |file| file.write_all(text.as_bytes()))?;
    if args.json {
        out!("{text}")?;
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
