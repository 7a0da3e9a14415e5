//! `dpn check`.

use super::log;
use crate::args::CheckArgs;
use crate::ui::{out, outln, print_pictures};
use anyhow::Result;
use dpn_figures::{FigureError, save, spectrum_plot};
use dpn_io::atomic_write;
use dpn_probe::doctor::examine_log;

pub(crate) fn run(args: &CheckArgs) -> Result<()> {
    let examination = examine_log(&log::read_quietly(&args.log)?)?;
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
    let files = plot.map(|plot| save(&plot, &args.out.join("spectra"))).transpose()?.unwrap_or_default();
    // Last: where it lies, the rest does too.
    atomic_write(&args.out.join("check.json"), |file| file.write_all(text.as_bytes()))?;
    if args.json {
        out!("{text}")?;
        return Ok(());
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
    Ok(())
}
