//! What the tables say, in sentences: each is a number with what it is compared to.

use super::error::PaperError;
use super::input::Input;
use super::specs;
use dpn_core::estimate::NoiseSpec;
use dpn_eval::published::PublishedAte;
use dpn_eval::study::{Comparison, RowSet, Study, compare};
use dpn_figures::Cell;
use std::fmt::Write as _;

/// A noise against another that is not the study's reference, not corrected for other comparisons.
#[derive(Debug)]
pub(super) struct Pair {
    pub(super) noise: NoiseSpec,
    pub(super) against: NoiseSpec,
    pub(super) comparison: Comparison,
}

/// The paper's networks against the usual constants; then the controls of what says a noise, against itself. As far as they were run.
pub(super) fn pairs(rows: &RowSet<'_>, margin: f64) -> Result<Vec<Pair>, PaperError> {
    let controls = [specs::DUALPRONET, specs::LEARNED].map(specs::noise).into_iter().flat_map(|of| {
        let own = || Box::new(of.clone());
        [(NoiseSpec::Mean(own()), of.clone()), (NoiseSpec::Shuffled(own()), of)]
    });
    let [x1, dualpronet] = specs::noises([specs::BASELINE, specs::DUALPRONET]);
    let mut found = Vec::new();
    for (noise, against) in std::iter::once((dualpronet, x1)).chain(controls) {
        if let Some(comparison) = compare(rows, &noise, &against, margin)? {
            found.push(Pair { noise, against, comparison });
        }
    }
    Ok(found)
}

/// All of them, in the order of the page; `step` is of noise that is added in known steps.
pub(super) fn findings(input: &Input, study: &Study, pairs: &[Pair], step: Option<&Study>) -> Vec<String> {
    let [dualpronet, learned] = specs::noises([specs::DUALPRONET, specs::LEARNED]);
    let mut found: Vec<String> = against_baseline(input, study, pairs).into_iter().collect();
    found.extend(against_reference(study, &dualpronet, "Against"));
    found.extend(controls(pairs, &dualpronet));
    let against = "The noise that the odometry estimates while it runs: against";
    found.extend(against_reference(study, &learned, against));
    found.extend(controls(pairs, &learned));
    if let Some(step) = step {
        let oracle = specs::noise(specs::ORACLE);
        for (who, noise) in [("the true noise", Some(&oracle)), ("the best network", best_network(step))] {
            let against = format!("Where white noise goes up and down by a known factor, {who}: against");
            found.extend(noise.and_then(|noise| against_reference(step, noise, &against)));
        }
    }
    found.extend(input.notes_of_runs());
    found
}

/// The network with the lowest ratio to the reference.
pub(super) fn best_network(study: &Study) -> Option<&NoiseSpec> {
    let networks = study.noises.iter().filter(|line| specs::is_network(&line.noise));
    let ratios = networks.filter_map(|line| Some((line.comparison.as_ref()?.ratio, &line.noise)));
    ratios.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, noise)| noise)
}

/// DualProNet against the usual constants, with the paper's own figure where the sequences are its.
fn against_baseline(input: &Input, study: &Study, pairs: &[Pair]) -> Option<String> {
    let [x1, dualpronet] = specs::noises([specs::BASELINE, specs::DUALPRONET]);
    let mean = |noise: &NoiseSpec| study.of(noise).and_then(|line| line.means[0]);
    let (baseline, ours) = mean(&x1).zip(mean(&dualpronet))?;
    let sequences = match input.places.len() {
        1 => "one sequence".to_owned(),
        count => format!("{count} sequences"),
    };
    let mut text = format!(
        "DualProNet's mean error over {sequences} is {} m, {} that of the usual constants (x1, {} m)",
        Cell::metres(ours).shown(),
        beside(ours / baseline),
        Cell::metres(baseline).shown(),
    );
    if let Some(pair) = pairs.iter().find(|pair| pair.against == x1) {
        let _ = write!(text, "; {}{}", ratio(&pair.comparison), p(&pair.comparison));
    }
    let paper = PublishedAte::paper();
    if let (true, Some((x1, theirs))) = (input.is_papers(), paper.mean(&x1).zip(paper.mean(&dualpronet))) {
        let _ = write!(text, ". In the paper's table it is {}", beside(theirs / x1));
    }
    Some(text + ".")
}

/// A noise against the constant that every noise is compared with; the sentence begins with `against`.
fn against_reference(study: &Study, noise: &NoiseSpec, against: &str) -> Option<String> {
    let reference = study.reference.as_ref()?;
    let comparison = study.of(noise)?.comparison.as_ref()?;
    let mut text = format!("{against} {}", reference.words());
    if let Some(mean) = study.of(&reference.noise).and_then(|line| line.means[0]) {
        let _ = write!(text, " ({} m)", Cell::metres(mean).shown());
    }
    let _ = write!(text, ", {}", ratio(comparison));
    if let Some(p) = comparison.p_holm {
        let _ = write!(text, ", p {} after Holm's correction", Cell::p(p).shown());
    }
    if let Some(p) = comparison.p_equal {
        let equal = if p < 0.05 { "equal" } else { "not shown to be equal" };
        let _ = write!(text, "; {equal} within {:.0} % (p {})", 100.0 * study.margin, Cell::p(p).shown());
    }
    if reference.at_edge {
        let _ = write!(text, "; {} is the end of that sweep, and one beyond may be better", reference.noise);
    }
    Some(text + ".")
}

/// A noise's controls against itself.
fn controls(pairs: &[Pair], noise: &NoiseSpec) -> impl Iterator<Item = String> {
    // What else was estimated is not given: a control is of the samples' noise.
    let rest = if noise.is_learned() { ", pixels and walks being as configured" } else { "" };
    pairs.iter().filter(move |pair| pair.against == *noise).filter_map(move |pair| {
        let words = match pair.noise {
            NoiseSpec::Mean(_) => {
                "its own mean over each sequence, one constant, instead of its values in time"
            }
            NoiseSpec::Shuffled(_) => "its values at the wrong times",
            _ => return None,
        };
        Some(format!("Given {words}{rest}: {}{}.", ratio(&pair.comparison), p(&pair.comparison)))
    })
}

/// How one error stands beside another, of which it is this share.
fn beside(share: f64) -> String {
    let word = if share <= 1.0 { "below" } else { "above" };
    format!("{:.0} % {word}", 100.0 * (1.0 - share).abs())
}

fn ratio(comparison: &Comparison) -> String {
    let [low, high] = comparison.ratio_interval;
    let ratio = comparison.ratio;
    format!(
        "sequence by sequence its error is {ratio:.2} times as large ({low:.2} to {high:.2}), smaller in {} of {}",
        comparison.better, comparison.sequences
    )
}

/// The p of a comparison that was tested.
fn p(comparison: &Comparison) -> String {
    comparison.p.map_or(String::new(), |p| format!(", p {}", Cell::p(p).shown()))
}
