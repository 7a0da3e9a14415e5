//! The experiment with injected noise: how models follow, what it is worth.

use super::super::injected::Response;
use super::super::input::Input;
use super::super::specs;
use super::comparison::against;
use dpn_eval::injected::{Course, Injection, TONE_HZ};
use dpn_eval::study::{Choice, Study};
use dpn_figures::{Cell, Column, Provenance, Table};

/// What is added, in a sentence.
fn words(injection: &Injection) -> String {
    let factor = injection.factor;
    format!(
        "Added at x1: {} m/s^2 and {} rad/s, changing by x{factor} (step: x1, x{factor}, x1 by thirds of the recording; tone: nothing white, but a sine of {TONE_HZ} Hz \
         and x{factor} rms; bias-jump: nothing white, but a bias of x{factor} on every axis, half way). The oracle is given the root of the sum of squares of what \
         white noise is added and of {} m/s^2, {} rad/s, the best constant without anything added.",
        injection.accel, injection.gyro, injection.own_accel, injection.own_gyro
    )
}

/// Every noise on every course: its error, and how that stands against the best constant's.
pub(crate) fn courses(
    input: &Input,
    courses: &[(Course, Study)],
    injection: &Injection,
    made_by: Provenance,
) -> Table {
    let heads = [
        "ratio to best constant (95 %)",
        "p (Holm)",
        "ATE median [m]",
        "ATE mean [m]",
        "better in",
        "failed",
    ];
    let title = "Noise of a known course added to the IMU: what each model is worth";
    let mut table = Table::new("injected", title, Column::all(&["noise", "course"], &heads)).made_by(made_by);
    for (course, study) in courses {
        for line in &study.noises {
            let reference = study.reference.as_ref().filter(|reference| reference.noise == line.noise);
            let mark = reference.map_or("", |reference| match reference.choice {
                Choice::Training => " (best constant)",
                Choice::Baseline => " (reference)",
            });
            let [ratio, better, p] = against(line.comparison.as_ref());
            let noise = specs::cell(&line.noise).marked(mark);
            let [ate, mean] = [line.ate, line.means[0]].map(Cell::metres);
            let failed = Cell::text(line.failures);
            let cells = vec![noise, Cell::text(course.name()), ratio, p, ate, mean, better, failed];
            table.reference_row(cells, reference.is_some());
        }
        table.rule();
        if study.reference.as_ref().is_some_and(|reference| reference.at_edge) {
            table.note(format!(
                "{course}: the best constant is the end of the sweep; one beyond it may be better."
            ));
        }
    }
    table.note(words(injection));
    if input.injected.camera() != input.source.camera() {
        table.note(format!(
            "These runs are on {} made along the ground truth, those without injected noise on {}: compare within this table.",
            input.injected.camera(),
            input.camera()
        ));
    }
    table.note("Medians over seeds, then over sequences (one without any pose counts as worse than all; it is left out of ratios and tests). The best constant is the one with the lowest median on the training sequences, among those \
                listed. Ratio: geometric mean over sequences; p: two-sided signed-rank test over sequences, Holm's correction over the noises of a course.");
    table.notes(input.notes_of_runs());
    table
}

/// Levels and lags.
pub(crate) fn responses(
    input: &Input,
    responses: &[Response],
    injection: &Injection,
    made_by: Provenance,
) -> Table {
    let heads = ["during / before", "lag up [s]", "lag down [s]", "before", "during", "sequences"];
    let title = "Response of each noise model to a change of the noise, or to what is no white noise";
    let columns = Column::all(&["noise", "course", "sensor"], &heads);
    let mut table = Table::new("response", title, columns).made_by(made_by);
    let mut last = None;
    // A constant answers nothing; it is there for the sweep of the other courses.
    let answers = |response: &&Response| !response.noise.is_constant();
    for response in responses.iter().filter(answers) {
        if last.is_some_and(|course| course != response.course) {
            table.rule();
        }
        last = Some(response.course);
        let digits = if response.sensor == dpn_core::Sensor::Accel { 3 } else { 4 };
        table.row(vec![
            specs::cell(&response.noise),
            Cell::text(response.course.name()),
            Cell::text(response.sensor.name()),
            Cell::number(response.high / response.low, 2),
            Cell::number(response.rise.map(|(lag, _)| lag), 2),
            Cell::number(response.fall.map(|(lag, _)| lag), 2),
            Cell::number(response.low, digits),
            Cell::number(response.high, digits),
            Cell::text(response.sequences),
        ]);
    }
    table.note(words(injection));
    table.note("Medians over sequences of the estimate, x, y, z together (one-axis: y alone), in m/s^2 and rad/s. Lag: from the change until the \
                estimate has gone half of the way. For tone and bias-jump the right ratio is 1: nothing white was added.");
    table.notes(input.notes_of_runs());
    table
}
