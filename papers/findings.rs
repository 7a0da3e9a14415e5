//! What the tables say, in sentences: each is a number with what it is compared to.

use super::error::PaperError;
use super::injected::CourseStudy;
use super::input::Input;
use super::specs;
use dpn_core::estimate::NoiseSpec;
use dpn_eval::injected::Course;
use dpn_eval::published::PublishedAte;
use dpn_eval::study::{Comparison, RowSet, Study, compare};
use std::fmt::Write as _;

/// All of them, in the order of the page.
pub(super) fn findings(
    input: &Input,
    rows: &RowSet<'_>,
    study: &Study,
    courses: &[(Course, CourseStudy)],
) -> Result<Vec<String>, PaperError> {
    let mut found = Vec::new();
    found.extend(against_baseline(input, rows, study)?);
    found.extend(against_reference(study, specs::DUALPRONET, "Against"));
    found.extend(controls(rows, study, specs::DUALPRONET)?);
    found.extend(against_reference(
        study,
        specs::LEARNED,
        "The noise that the odometry learns while it runs: against",
    ));
    found.extend(controls(rows, study, specs::LEARNED)?);
    for (_, course) in courses.iter().filter(|(course, _)| *course == Course::Step) {
        found.extend(added_noise(course));
    }
    found.extend(input.notes_of_runs());
    Ok(found)
}

/// DualProNet against the usual constants, with the paper's own figure where the sequences are its.
fn against_baseline(input: &Input, rows: &RowSet<'_>, study: &Study) -> Result<Option<String>, PaperError> {
    let [x1, dualpronet] = specs::noises([specs::BASELINE, specs::DUALPRONET]);
    let mean = |noise: &NoiseSpec| study.of(noise).and_then(|line| line.means[0]);
    let Some((baseline, ours)) = mean(&x1).zip(mean(&dualpronet)) else { return Ok(None) };
    let mut text = format!(
        "DualProNet's mean error over {} is {ours:.3} m, {} that of the usual constants (x1, {baseline:.3} m)",
        sequences(input.places.len()),
        beside(ours / baseline),
    );
    if let Some(comparison) = compare(rows, &dualpronet, &x1, study.margin)? {
        let _ = write!(text, "; {}", ratio(&comparison));
        if let Some(p) = comparison.p {
            let _ = write!(text, ", p {p:.3}");
        }
    }
    let paper = PublishedAte::paper();
    if let (true, Some((x1, theirs))) = (input.is_papers(), paper.mean(&x1).zip(paper.mean(&dualpronet))) {
        let _ = write!(text, ". In the paper's table it is {}", beside(theirs / x1));
    }
    Ok(Some(text + "."))
}

/// A noise against the constant that every noise is compared with; the sentence begins with `against`.
fn against_reference(study: &Study, noise: &str, against: &str) -> Option<String> {
    let reference = study.reference.as_ref()?;
    let comparison = study.of(&specs::noise(noise))?.comparison.as_ref()?;
    let mut text = format!("{against} {}", reference.words());
    if let Some(mean) = study.of(&reference.noise).and_then(|line| line.means[0]) {
        let _ = write!(text, " ({mean:.3} m)");
    }
    let _ = write!(text, ", {}", ratio(comparison));
    if let Some(p) = comparison.p_holm {
        let _ = write!(text, ", p {p:.2} after Holm's correction");
    }
    if let Some(p) = comparison.p_equal {
        let equal = if p < 0.05 { "equal" } else { "not shown to be equal" };
        let _ = write!(text, "; {equal} within {:.0} % (p {p:.2})", 100.0 * study.margin);
    }
    Some(text + ".")
}

/// A noise's controls against itself.
fn controls(rows: &RowSet<'_>, study: &Study, noise: &str) -> Result<Vec<String>, PaperError> {
    let noise = specs::noise(noise);
    let of = || Box::new(noise.clone());
    let mut found = Vec::new();
    for (control, words) in [
        (
            NoiseSpec::Mean(of()),
            "its own mean over each sequence, one constant, instead of its values in time",
        ),
        (NoiseSpec::Shuffled(of()), "its values at the wrong times"),
    ] {
        if let Some(comparison) = compare(rows, &control, &noise, study.margin)? {
            let p = comparison.p.map_or(String::new(), |p| format!(", p {p:.2}"));
            // What else was learned is not told: a control is of the samples' noise.
            let rest = if noise.is_learned() { ", pixels and walks being as configured" } else { "" };
            found.push(format!("Told {words}{rest}: {}{p}.", ratio(&comparison)));
        }
    }
    Ok(found)
}

/// What an oracle gains where the noise is known, and how much of that networks do.
fn added_noise(course: &CourseStudy) -> Vec<String> {
    let (Some(reference), Some(gap)) = (&course.reference, course.gap[0]) else { return Vec::new() };
    let mut text = format!(
        "Where white noise goes up and down by a known factor ({}), an oracle's median error is {} that of {}",
        sequences(course.sequences[0]),
        beside(1.0 - gap),
        reference.short(),
    );
    if reference.at_edge {
        let best = specs::name(&reference.noise);
        let _ = write!(
            text,
            "; {best} is the end of that sweep, so a constant beyond it may be better, and the gap smaller"
        );
    }
    let mut found = vec![text + "."];
    let networks = course.noises.iter().filter(|worth| specs::is_network(&worth.noise));
    let best = networks.filter_map(|w| Some((w.closed[0]?, w))).max_by(|a, b| a.0.total_cmp(&b.0));
    if let Some((share, worth)) = best.filter(|_| gap >= 0.05) {
        let mut text = format!("Of that gap {} closes {:.0} %", specs::name(&worth.noise), 100.0 * share);
        if let Some(comparison) = &worth.comparison {
            let _ = write!(text, "; against {}, {}", reference.kind(), ratio(comparison));
            if let Some(p) = comparison.p_holm {
                let _ = write!(text, ", p {p:.2} after Holm's correction");
            }
        }
        found.push(text + ".");
    }
    found
}

fn sequences(count: usize) -> String {
    if count == 1 { "one sequence".into() } else { format!("{count} sequences") }
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
