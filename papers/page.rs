//! The page: the story in the order in which a reader asks. What is it, how well does it say the noise, is it worth it, when. One file without
//! scripts and without anything from elsewhere.

use super::command::Provenance;
use super::error::PaperError;
use super::injected::Value;
use super::input::Input;
use super::published;
use super::run::table;
use super::study::{Against, Rows, Study};
use super::table::Table;
use dpn_eval::closed_loop::Peer;
use dpn_eval::injected::Course;
use std::fmt::Write as _;

const STYLE: &str = include_str!("page.css");

/// A figure as it is put on the page.
#[derive(Debug, Clone)]
pub(super) struct Picture {
    pub(super) name: &'static str,
    pub(super) title: String,
    pub(super) runs: Vec<String>,
    pub(super) svg: String,
}

/// What the page tells.
#[derive(Debug)]
pub(super) struct Story<'a> {
    pub(super) input: &'a Input,
    /// Why the odometry sees what it sees.
    pub(super) camera: &'a str,
    pub(super) findings: &'a [String],
    pub(super) tables: &'a [Table],
    pub(super) pictures: &'a [Picture],
}

/// What the tables say, in sentences: each is a number with what it is compared to.
pub(super) fn findings(
    input: &Input,
    rows: &Rows<'_>,
    study: &Study,
    values: &[(Course, Value)],
) -> Result<Vec<String>, PaperError> {
    let mut found = Vec::new();
    let line = |noise: &str| study.lines.iter().find(|line| line.noise == noise);
    let mean = |noise: &str| line(noise).and_then(|line| line.means[0]);
    if let Some((x1, ours)) = mean("x1").zip(mean("dualpronet")) {
        let mut text = format!(
            "DualProNet's mean error over {} is {ours:.3} m, {} that of the usual constants (x1, {x1:.3} m)",
            sequences(input.places.len()),
            beside(ours / x1),
        );
        if let Some(against) = rows.against("dualpronet", "x1", study.margin)? {
            let _ = write!(text, "; {}", ratio(&against));
            if let Some(p) = against.p {
                let _ = write!(text, ", p {p:.3}");
            }
        }
        if input.is_papers() {
            let paper = Peer::paper()?;
            let mean = |noise: &str| {
                let all = published::sequences().ok()?;
                let ates: Option<Vec<f64>> = all.iter().map(|s| paper.ate(&s.name, noise)).collect();
                ates.map(|ates| ates.iter().sum::<f64>() / ates.len() as f64)
            };
            if let Some((x1, theirs)) = mean("x1").zip(mean("dualpronet")) {
                let _ = write!(text, ". In the paper's table it is {}", beside(theirs / x1));
            }
        }
        found.push(text + ".");
    }
    if let (Some(best), Some(against)) =
        (study.best_constant.as_deref(), line("dualpronet").and_then(|l| l.against.as_ref()))
    {
        let mut text = format!("Against {best}, the best constant on the training sequences");
        if let Some(mean) = mean(best) {
            let _ = write!(text, " ({mean:.3} m)");
        }
        let _ = write!(text, ", {}", ratio(against));
        if let Some(p) = against.p_holm {
            let _ = write!(text, ", p {p:.2} after Holm's correction");
        }
        if let Some(p) = against.p_equal {
            let equal = if p < 0.05 { "equal" } else { "not shown to be equal" };
            let _ = write!(text, "; {equal} within {:.0} % (p {p:.2})", 100.0 * study.margin);
        }
        found.push(text + ".");
    }
    for (control, words) in [
        ("mean(dualpronet)", "its own mean over each sequence, one constant, instead of its values in time"),
        ("shuffled(dualpronet)", "its values at the wrong times"),
    ] {
        if let Some(against) = rows.against(control, "dualpronet", study.margin)? {
            let mut text = format!("Told {words}: {}", ratio(&against));
            if let Some(p) = against.p {
                let _ = write!(text, ", p {p:.2}");
            }
            found.push(text + ".");
        }
    }
    if let Some((_, value)) = values.iter().find(|(course, _)| *course == Course::Step)
        && let (Some(best), Some(gap)) = (&value.best_constant, value.gap[0])
    {
        let mut text = format!(
            "Where white noise goes up and down by a known factor ({}), an oracle's median error is {} that of {best}, the best constant",
            sequences(value.sequences[0]),
            beside(1.0 - gap),
        );
        if value.at_edge {
            let _ = write!(
                text,
                "; {best} is the end of that sweep, so a constant beyond it may be better, and the gap smaller"
            );
        }
        found.push(text + ".");
        let adaptive = value
            .worth
            .iter()
            .filter(|w| w.noise != "oracle" && w.noise.contains("dualpronet"))
            .filter(|w| !w.noise.starts_with("mean(") && !w.noise.starts_with("shuffled("));
        let best = adaptive.filter_map(|w| Some((w.closed[0]?, w))).max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((share, worth)) = best.filter(|_| gap >= 0.05) {
            let mut text = format!("Of that gap {} closes {:.0} %", worth.noise, 100.0 * share);
            if let Some(against) = &worth.against {
                let _ = write!(text, "; against the best constant, {}", ratio(against));
                if let Some(p) = against.p_holm {
                    let _ = write!(text, ", p {p:.2} after Holm's correction");
                }
            }
            found.push(text + ".");
        }
    }
    found.extend(input.notes_of_runs());
    Ok(found)
}

fn sequences(count: usize) -> String {
    if count == 1 { "one sequence".into() } else { format!("{count} sequences") }
}

/// How one error stands beside another, of which it is this share.
fn beside(share: f64) -> String {
    let word = if share <= 1.0 { "below" } else { "above" };
    format!("{:.0} % {word}", 100.0 * (1.0 - share).abs())
}

fn ratio(against: &Against) -> String {
    let [low, high] = against.ratio_interval;
    let ratio = against.ratio;
    format!(
        "sequence by sequence its error is {ratio:.2} times as large ({low:.2} to {high:.2}), smaller in {} of {}",
        against.better, against.sequences
    )
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// An SVG as the address of an image.
fn address(svg: &str) -> String {
    let mut out = String::with_capacity(svg.len() + svg.len() / 8);
    out.push_str("data:image/svg+xml;charset=utf-8,");
    for c in svg.chars() {
        match c {
            '\n' => out.push(' '),
            '"' => out.push('\''),
            '%' | '#' | '<' | '>' | '&' | '\'' => {
                let _ = write!(out, "%{:02X}", c as u32);
            }
            other => out.push(other),
        }
    }
    out
}

impl Story<'_> {
    /// The whole page.
    pub(super) fn html(&self, made_by: &Provenance) -> String {
        let mut out = String::from("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n");
        out.push_str("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n");
        out.push_str(
            "<meta name=\"color-scheme\" content=\"light dark\">\n<link rel=\"icon\" href=\"data:,\">\n",
        );
        let _ = writeln!(
            out,
            "<title>dpn: VIO-DualProNet again, and the study it lacks</title>\n<style>\n{STYLE}</style>\n</head>\n<body>"
        );
        out.push_str("<header>\n<h1>How noisy is this IMU right now, and does it help to be told?</h1>\n");
        out.push_str("<p class=\"lead\">VIO-DualProNet (Solodar and Klein) lets two small networks read the noise of an inertial sensor off its signal and hands it to a \
                      visual-inertial odometry. Here is the paper again, from data, and what decides its question: controls, a sweep of constants, tests, and noise whose \
                      truth is known.</p>\n");
        out.push_str("<nav><a href=\"#what\">What it is</a> <a href=\"#well\">How well it says the noise</a> <a href=\"#worth\">Is it worth it?</a> <a href=\"#when\">When?</a> \
                      <a href=\"#made\">How this was made</a></nav>\n</header>\n<main>\n<ul class=\"findings\">\n");
        for finding in self.findings {
            let _ = writeln!(out, "<li>{}</li>", escaped(finding));
        }
        out.push_str("</ul>\n");
        self.section(
            &mut out,
            "what",
            "What it is",
            &format!(
                "The data: {} sequences ({}). The odometry sees {}: {}.",
                self.input.places.len(),
                escaped(&self.input.name),
                self.input.camera(),
                escaped(self.camera)
            ),
        );
        for name in ["architecture_odometry", "architecture_window", "architecture_networks"] {
            self.picture(&mut out, name, "");
        }
        self.table(&mut out, "split", true);
        self.section(
            &mut out,
            "well",
            "How well it says the noise",
            "White noise of known deviation is added to cleaned windows of one second, and every \
            estimator is asked for it. No unbiased estimator gets below the bound.",
        );
        self.picture(
            &mut out,
            "open_loop_rmse_vs_sigma",
            "Markers tell the estimators apart without colour.",
        );
        self.table(&mut out, "open_loop", true);
        self.picture(&mut out, "flight_sigma", "A whole flight: the raw signal above, what is said of its noise below. Rotor vibration lies far above what the \
            networks were trained on (dashed).");
        self.picture(&mut out, "flight_sigma_gyro", "");
        self.section(
            &mut out,
            "worth",
            "Is it worth it?",
            "The odometry is told its noise by constants, networks, simple estimators and controls; \
            everything else stays the same.",
        );
        self.table(&mut out, "closed_loop", false);
        self.picture(&mut out, "sweep", "If DualProNet's mark lies on the curve, a constant of its level does the same; if mean and shuffled lie beside it, \
            what helps is the level, not the time.");
        self.table(&mut out, "study", true);
        self.picture(&mut out, "trajectories", "");
        self.picture(&mut out, "error_by_time", "");
        self.section(&mut out, "when", "When is it worth it?", "Here noise of known strength is added to the IMU, so that the truth is known and an oracle can be \
            told it: an adaptive covariance has its fair chance.");
        self.picture(&mut out, "step_response", "");
        self.picture(&mut out, "step_response_gyro", "");
        self.picture(&mut out, "injected_sweep", "");
        self.table(&mut out, "injected", false);
        self.table(&mut out, "response", true);
        self.section(
            &mut out,
            "made",
            "How this was made",
            "Every table and figure names its runs and the command. Times differ from run to run; \
            nothing else does.",
        );
        self.table(&mut out, "timing", true);
        let _ = writeln!(
            out,
            "<p class=\"made\">{}</p>\n</main>\n<footer><p>Figures as SVG, PNG and CSV and tables as Markdown, CSV and LaTeX lie beside this page.</p></footer>\n</body>\n</html>",
            escaped(&made_by.line())
        );
        out
    }

    fn section(&self, out: &mut String, anchor: &str, title: &str, words: &str) {
        let _ = writeln!(out, "<h2 id=\"{anchor}\">{title}</h2>\n<p>{words}</p>");
    }

    fn picture(&self, out: &mut String, name: &str, words: &str) {
        let Some(picture) = self.pictures.iter().find(|picture| picture.name == name) else { return };
        let title = escaped(&picture.title);
        let _ = writeln!(
            out,
            "<figure id=\"{name}\"><div class=\"wide\"><img alt=\"{title}\" src=\"{}\"></div><figcaption>{title}. {words}</figcaption></figure>",
            address(&picture.svg)
        );
    }

    /// A table; `folded` ones open by a touch.
    fn table(&self, out: &mut String, name: &str, folded: bool) {
        let Some(table) = table(self.tables, name) else { return };
        let title = escaped(&table.title);
        if folded {
            let _ = writeln!(out, "<details><summary>Table: {title}</summary>");
        } else {
            let _ = writeln!(out, "<h3>{title}</h3>");
        }
        let _ = writeln!(out, "<div class=\"wide\" tabindex=\"0\"><table id=\"table-{name}\"><thead><tr>");
        let class = |number: bool| if number { " class=\"n\"" } else { "" };
        for column in &table.columns {
            let _ = write!(out, "<th{}>{}</th>", class(column.number), escaped(&column.name));
        }
        out.push_str("</tr></thead><tbody>\n");
        let mut rule = false;
        for row in &table.rows {
            if row.is_empty() {
                rule = true;
                continue;
            }
            let reference =
                row.iter().any(|c| c.shown() == "reference" || c.shown().ends_with("(best constant)"));
            let classes = match (rule, reference) {
                (true, true) => " class=\"after-rule reference\"",
                (true, false) => " class=\"after-rule\"",
                (false, true) => " class=\"reference\"",
                (false, false) => "",
            };
            let _ = write!(out, "<tr{classes}>");
            for (cell, column) in row.iter().zip(&table.columns) {
                let _ = write!(out, "<td{}>{}</td>", class(column.number), escaped(cell.shown()));
            }
            out.push_str("</tr>\n");
            rule = false;
        }
        out.push_str("</tbody></table></div>\n");
        for note in &table.notes {
            let _ = writeln!(out, "<p class=\"note\">{}</p>", escaped(note));
        }
        let _ = writeln!(out, "<p class=\"made\">{}</p>", escaped(&table.made_by.line()));
        if folded {
            out.push_str("</details>\n");
        }
    }

    /// The folder's README: figure, what it shows, run; the command once.
    pub(super) fn readme(&self, made_by: &Provenance) -> String {
        let mut out = format!(
            "# Figures and tables\n\nMade by one command, never by hand; the same input and program give the same bytes (but for `timing` and the page, which shows it):\n\n\
             ```sh\n{}\n```\n\n{}. `index.html` tells the story with all of them; the repository's `figures/check_page.py` looks at it in headless Chromium.\n\n\
             | figure (SVG, PNG, CSV) | shows | runs |\n|---|---|---|\n",
            made_by.command, made_by.program
        );
        for picture in self.pictures {
            let _ = writeln!(out, "| `{}` | {} | {} |", picture.name, picture.title, code(&picture.runs));
        }
        out.push_str("\n| table (Markdown, CSV, LaTeX, in `tables/`) | shows | runs |\n|---|---|---|\n");
        for table in self.tables {
            let title = table.title.replace('[', "\\[").replace(']', "\\]");
            let _ = writeln!(out, "| `{}` | {title} | {} |", table.name, code(&table.made_by.runs));
        }
        if self.input.not_run().next().is_some() {
            out.push_str("\nMissing:\n\n");
            for missing in self.input.not_run() {
                let _ = writeln!(out, "* {}: {}", missing.name, missing.reason);
            }
        }
        out
    }
}

fn code(runs: &[String]) -> String {
    runs.iter().map(|run| format!("`{run}`")).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_svg_becomes_an_address_without_marks_that_end_it() {
        let address = address("<svg fill=\"#fff\">\n50 % & more</svg>");
        assert!(address.starts_with("data:image/svg+xml"));
        let body = &address["data:image/svg+xml;charset=utf-8,".len()..];
        assert!(!body.contains(['<', '>', '"', '#', '\n', '&']), "{body}");
        assert!(body.contains("fill='%23fff'") && body.contains("50 %25 %26"), "{body}");
    }

    #[test]
    fn words_are_escaped() {
        assert_eq!(escaped("a<b & \"c\""), "a&lt;b &amp; &quot;c&quot;");
    }
}
