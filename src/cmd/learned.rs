//! What runs of the odometry learned of a platform's noise: at the end of `dpn run`, and `dpn noise --learned`.

use super::apart;
use crate::args::PasteArgs;
use crate::ui::{Fault, errln, out, outln, refuse, results};
use anyhow::Result;
use dpn_core::noise::Figure;
use dpn_eval::closed_loop::{LearnedFigure, LearnedNoise};
use dpn_io::ResultPath;
use dpn_probe::paste::{FigureLine, Paste};
use std::path::{Path, PathBuf};

/// White noises of one platform's runs differ by less: what EuRoC's easiest and hardest flights learn differs by two.
const APART: f64 = 4.0;
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
        return refuse(message, "give runs of one platform, and each platform a call");
    }
    if let Some((figure, [a, b], [quiet, loud])) = apart_by(&all) {
        let (a, b) = (runs[a].display(), runs[b].display());
        errln!(
            "warning: {figure} is {quiet:.1e} in {a} and {loud:.1e} in {b}: runs of one platform differ less; what follows is neither's"
        );
    }
    let learned = LearnedNoise::together(&all).expect("a run or more is asked for");
    let paste = paste(&learned, how.walks);
    let written = paste.written(&how.paste.0);
    let all =
        serde_json::json!({ "runs": runs, "learned_noise": learned, "paste": paste, "formats": written });
    let file = out.join("learned.json");
    if results(file.clone(), &all, json)? {
        return Ok(());
    }
    outln!("noise {}", learned.words())?;
    out!("{}", paste.page(&how.paste.0))?;
    Ok(outln!("file:     {}", file.display())?)
}

/// The white noise by which two runs differ the most, where that is more than one platform's runs do: the runs' places and their geometric means.
fn apart_by(all: &[LearnedNoise]) -> Option<(Figure, [usize; 2], [f64; 2])> {
    let level = |of: &LearnedFigure| of.density.iter().map(|axis| axis.value).product::<f64>().cbrt();
    let figure = |k: usize| {
        let known = all.iter().enumerate().filter(|(_, run)| run.figures[k].not_known().is_none());
        let mut levels: Vec<(usize, f64)> = known.map(|(run, of)| (run, level(&of.figures[k]))).collect();
        levels.sort_by(|a, b| a.1.total_cmp(&b.1));
        let (quiet, loud) = (levels.first()?, levels.last()?);
        Some((all[0].figures[k].figure, [quiet.0, loud.0], [quiet.1, loud.1]))
    };
    let white = (0..all[0].figures.len()).filter(|k| !all[0].figures[*k].figure.is_walk());
    let worst = white.filter_map(figure).max_by(|a, b| (a.2[1] / a.2[0]).total_cmp(&(b.2[1] / b.2[0])))?;
    (worst.2[1] > APART * worst.2[0]).then_some(worst)
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
