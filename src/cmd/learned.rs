//! What runs of the odometry learned of a platform's noise: at the end of `dpn run`, and `dpn noise --learned`.

use super::apart;
use crate::args::PasteArgs;
use crate::ui::{Fault, out, outln};
use anyhow::Result;
use dpn_eval::closed_loop::{LearnedFigure, LearnedNoise};
use dpn_io::{ResultPath, atomic_write};
use dpn_probe::paste::{FigureLine, Paste};
use std::path::{Path, PathBuf};

/// Rates that differ by less are one platform's.
const SAME_RATE: f64 = 0.05;

/// The figures to paste; walks where they are asked for.
pub(super) fn paste(learned: &LearnedNoise, walks: bool) -> Paste {
    let line = |of: &LearnedFigure| match of.not_known() {
        Some(why) => FigureLine::unknown(of.figure, why),
        None => FigureLine {
            pasted: walks || !of.figure.is_walk(),
            ..FigureLine::known(of.figure, of.density, learned.words())
        },
    };
    Paste { rate_hz: learned.rate_hz, lines: learned.figures.iter().map(line).collect() }
}

/// Several runs of one platform together.
pub(super) fn together(runs: &[PathBuf], how: &PasteArgs, out: &ResultPath, json: bool) -> Result<()> {
    apart::folder("--out", out, &["learned.json"], runs)?;
    let all = runs.iter().map(|run| read(run)).collect::<Result<Vec<_>>>()?;
    let (first, hz) = (&runs[0], all[0].rate_hz.hz());
    if let Some((run, other)) =
        runs.iter().zip(&all).find(|(_, other)| (other.rate_hz.hz() / hz - 1.0).abs() > SAME_RATE)
    {
        let message = format!(
            "{} has {:.0} Hz and {} {hz:.0}: that is not one platform",
            run.display(),
            other.rate_hz.hz(),
            first.display()
        );
        return Err(Fault::new(message).hint("give runs of one platform, and each platform a call").into());
    }
    let learned = LearnedNoise::together(&all).expect("a run or more is asked for");
    let paste = paste(&learned, how.walks);
    let written = paste.written(&how.paste.0);
    let all =
        serde_json::json!({ "runs": runs, "learned_noise": learned, "paste": paste, "formats": written });
    let text = all.to_string() + "\n";
    let file = out.join("learned.json");
    atomic_write(&file, |out| out.write_all(text.as_bytes()))?;
    if json {
        return Ok(out!("{text}")?);
    }
    outln!("noise {}", learned.words())?;
    out!("{}", paste.page(&how.paste.0))?;
    Ok(outln!("file:     {}", file.display())?)
}

/// What `dpn run` left.
fn read(run: &Path) -> Result<LearnedNoise> {
    let file = run.join("report.json");
    let hint = "give the folders that `dpn run --noise self --out RUN` wrote";
    let fault = |words: String| Fault::new(format!("{}: {words}", file.display())).hint(hint);
    let text = std::fs::read_to_string(&file).map_err(|error| fault(error.to_string()))?;
    let mut report: serde_json::Value =
        serde_json::from_str(&text).map_err(|error| fault(error.to_string()))?;
    match report["report"]["learned_noise"].take() {
        serde_json::Value::Null => Err(fault("nothing was learned in this run".to_owned()).into()),
        learned => Ok(serde_json::from_value(learned).map_err(|error| fault(error.to_string()))?),
    }
}
