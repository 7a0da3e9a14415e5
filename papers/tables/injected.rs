//! The experiment with injected noise: how models follow, what it is worth.

use super::super::injected::{CourseStudy, Response};
use super::super::input::Input;
use super::super::specs;
use dpn_eval::injected::{Course, Injection, TONE_HZ};
use dpn_eval::study::{Choice, Comparison};
use dpn_figures::{Cell, Column, Provenance, Table};

/// What is added, in a sentence.
fn words(injection: &Injection) -> String {
    let factor = injection.factor;
    format!(
        "Added at x1: {} m/s^2 and {} rad/s, changing by x{factor} (step: x1, x{factor}, x1 by thirds of the recording; tone: nothing white, but a sine of {TONE_HZ} Hz \
         and x{factor} rms; bias-jump: nothing white, but a bias of x{factor} on every axis, half way). The oracle is told the root of the sum of squares of what \
         white noise is added and of {} m/s^2, {} rad/s, the best constant without anything added.",
        injection.accel, injection.gyro, injection.own_accel, injection.own_gyro
    )
}

/// Every noise on every course: error, and share of the way from the best constant to the oracle.
pub(crate) fn value(
    input: &Input,
    values: &[(Course, CourseStudy)],
    injection: &Injection,
    made_by: Provenance,
) -> Table {
    let heads = [
        "of the gap closed",
        "ratio to best constant (95 %)",
        "p (Holm)",
        "ATE median [m]",
        "better in",
        "closed, train",
        "closed, test",
        "ATE, train [m]",
        "ATE, test [m]",
        "failed",
    ];
    let title = "Noise of a known course added to the IMU: what each model is worth";
    let mut table = Table::new("injected", title, Column::all(&["noise", "course"], &heads)).made_by(made_by);
    for (course, value) in values {
        for worth in &value.noises {
            let reference = value.reference.as_ref().filter(|reference| reference.noise == worth.noise);
            let mark = reference.map_or("", |reference| match reference.choice {
                Choice::Training => " (best constant)",
                Choice::Baseline => " (reference)",
            });
            let mut cells = vec![specs::cell(&worth.noise).marked(mark), Cell::text(course.name())];
            // A gap of less than a twentieth says nothing of who closes it.
            let told =
                [0, 1, 2].map(|i| worth.closed[i].filter(|_| value.gap[i].is_some_and(|gap| gap >= 0.05)));
            let [all, train, test] = told.map(|share| Cell::number(share, 2));
            let [ate, ate_train, ate_test] = worth.ate.map(Cell::metres);
            let against = worth.comparison.as_ref();
            let better = |a: &Comparison| format!("{} of {}", a.better, a.sequences);
            cells.extend([
                all,
                Cell::interval(against.map(|a| a.ratio), against.map(|a| a.ratio_interval), 2),
                Cell::p(against.and_then(|a| a.p_holm)),
                ate,
                Cell::text(against.map_or("-".into(), better)),
                train,
                test,
                ate_train,
                ate_test,
                Cell::text(worth.failures),
            ]);
            table.reference_row(cells, reference.is_some());
        }
        table.rule();
        if value.reference.as_ref().is_some_and(|reference| reference.at_edge) {
            table.note(format!(
                "{course}: the best constant is the end of the sweep; one beyond it may be better, and the gap smaller."
            ));
        }
        let gap = |i: usize| {
            let side = |gap: f64| if gap < 0.0 { "above" } else { "below" };
            value.gap[i].map_or("-".to_owned(), |gap| format!("{:.0} % {}", 100.0 * gap.abs(), side(gap)))
        };
        table.note(format!(
            "{course}, sequences: {} ({} training, {} test): the oracle's median lies {} that of {} (training {}, test {}).",
            value.sequences[0],
            value.sequences[1],
            value.sequences[2],
            gap(0),
            value.reference.as_ref().map_or("a constant, of which there is none".to_owned(), |reference| match reference.choice {
                Choice::Training => format!("the best, {},", specs::name(&reference.noise)),
                Choice::Baseline => reference.words(),
            }),
            gap(1),
            gap(2)
        ));
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
                listed. Share closed: (best constant - noise) / (best constant - oracle); not given where that gap is below 5 %; above 1 where a noise does better than the oracle. Ratio: geometric mean over sequences; p: two-sided signed-rank test over sequences, Holm's correction over the noises of a course.");
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
