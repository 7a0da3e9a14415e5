//! `dpn allan`.

use super::log;
use crate::args::AllanArgs;
use crate::ui::{out, outln};
use anyhow::Result;
use dpn_figures::{AllanPlot, save};
use dpn_io::atomic_write;
use dpn_io::noise_formats::{Given, read};
use dpn_probe::allan::compare::{Finding, compare};
use dpn_probe::allan::{AllanLog, report};

pub(crate) fn run(args: &AllanArgs) -> Result<()> {
    let recording = log::read(&args.log)?.recording.held()?;
    // A configuration that cannot be read should not cost a fit.
    let config = match &args.check {
        Some(path) => {
            let given = Given { rate: Some(recording.rate()), keep_zeros: true, ..Given::default() };
            Some((path, read(path, args.from, &given)?))
        }
        None => None,
    };
    let allan = AllanLog::of(&recording, args.all)?;
    let findings: Option<Vec<Finding>> = config.as_ref().map(|(_, source)| compare(source, &allan));
    let words = format!("{} samples, {:.0} s.", allan.samples, allan.length_s);
    let files = save(&AllanPlot::new(&allan.axes, &words)?, &args.out.join("allan"))?;
    let text = report::json(&allan, findings.as_deref())?.to_string() + "\n";
    atomic_write(&args.out.join("allan.json"), |file| file.write_all(text.as_bytes()))?;
    if args.json {
        out!("{text}")?;
        return Ok(());
    }
    out!("{}", report::page(&allan)?)?;
    if let (Some((path, source)), Some(findings)) = (&config, &findings) {
        outln!("\n{} as {}, against this log at rest:", path.display(), source.format)?;
        for finding in findings {
            outln!("{} {}", if finding.warns() { "warning:" } else { "ok:     " }, finding.text())?;
        }
        for remark in &source.remarks {
            outln!("note:    {remark}")?;
        }
    }
    for file in files.iter().filter(|f| f.extension().is_some_and(|e| e == "png")) {
        outln!("\npicture:  {}", file.display())?;
    }
    Ok(())
}
