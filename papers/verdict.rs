//! The verdict in one sentence, from the numbers of the study; and what was measured, which is said before any number.

use super::findings::best_network;
use super::input::Input;
use super::specs;
use dpn_core::estimate::NoiseSpec;
use dpn_eval::closed_loop::{Sequences, TrackSource};
use dpn_eval::study::{Choice, Comparison, Reference, Study};

/// How a noise stands against the constant it is compared with, at .05 after Holm's correction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Standing {
    Better,
    Worse,
    /// Within the study's margin.
    Equal,
    /// Neither a difference nor that there is none was shown.
    Open,
    /// Too few sequences for a test.
    Untested,
}

impl Standing {
    pub(super) fn of(comparison: &Comparison) -> Self {
        match (comparison.p_holm, comparison.p_equal) {
            (None, _) => Self::Untested,
            (Some(p), _) if p < 0.05 && comparison.ratio < 1.0 => Self::Better,
            (Some(p), _) if p < 0.05 => Self::Worse,
            (_, Some(p)) if p < 0.05 => Self::Equal,
            _ => Self::Open,
        }
    }

    /// In a table's cell.
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Better => "better",
            Self::Worse => "worse",
            Self::Equal => "equal",
            Self::Open => "open",
            Self::Untested => "too few sequences",
        }
    }
}

/// How a noise stands against `constant`, in a sentence.
fn clause(comparison: &Comparison, constant: &Reference) -> String {
    let than = match Standing::of(comparison) {
        Standing::Better => "better than",
        Standing::Worse => "worse than",
        Standing::Equal => "as good as",
        Standing::Open if comparison.ratio < 1.0 => "not shown to be better than",
        Standing::Open => "no better than",
        Standing::Untested => {
            let Comparison { better, sequences, .. } = comparison;
            return format!(
                "better in {better} of {sequences} sequences, too few to test, than {}",
                named(constant)
            );
        }
    };
    format!("{than} {}", named(constant))
}

/// What stands at the head of the page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Verdict {
    /// What was measured, in three words.
    pub(super) kind: &'static str,
    /// The same in a sentence: what is recorded, what simulated.
    pub(super) data: String,
    /// The verdict.
    pub(super) sentence: String,
}

impl Verdict {
    /// Of the study and of noise that is added in known steps; `camera` says why the odometry sees what it sees.
    pub(super) fn new(input: &Input, camera: &str, study: &Study, step: Option<&Study>) -> Self {
        let [dualpronet, learned] = specs::noises([specs::DUALPRONET, specs::LEARNED]);
        let of = |study, noise| against(study, noise);
        let clauses = [
            ("given the network's noise", of(study, &dualpronet)),
            ("with noise that it estimates while it runs", of(study, &learned)),
            (
                "where noise is added in known steps, given the best network's",
                step.and_then(|step| of(step, best_network(step)?)),
            ),
        ];
        let clauses: Vec<String> =
            clauses.into_iter().filter_map(|(who, is)| Some(format!("{who} it is {}", is?))).collect();
        let on = match input.name.as_str() {
            "euroc" => "EuRoC",
            "simulated" => "simulated flights",
            _ => "these recordings",
        };
        let sentence = if clauses.is_empty() {
            format!("On {on}, nothing was run that the network could be compared with.")
        } else {
            format!("The odometry on {on}: {}.", clauses.join("; "))
        };
        let (kind, recorded) = measured(input);
        let data = format!("{recorded} The odometry sees {}: {camera}.", input.camera());
        Self { kind, data, sentence }
    }
}

/// What is recorded and what simulated.
fn measured(input: &Input) -> (&'static str, String) {
    let count = input.places.len();
    let of_imu = format!("The IMU of {count} sequences was recorded");
    match (&input.source.of, &input.source.tracks) {
        (Sequences::Flights(_), _) => (
            "Simulated data",
            format!(
                "Nothing on this page was recorded: {count} flights, their IMU and their camera are simulated."
            ),
        ),
        (_, tracks) if tracks.is_simulated() => {
            ("Recorded IMU, simulated camera", of_imu + "; what the camera sees is simulated.")
        }
        (_, TrackSource::File(_)) => ("Recorded IMU, given tracks", of_imu + "."),
        _ => ("Recorded data", format!("IMU and camera of {count} sequences were recorded.")),
    }
}

/// A noise against the constant that every noise is compared with; nothing is judged by one at the end of its sweep.
fn against(study: &Study, noise: &NoiseSpec) -> Option<String> {
    let reference = study.reference.as_ref()?;
    let comparison = study.of(noise)?.comparison.as_ref()?;
    if reference.at_edge {
        return Some(format!(
            "not judged, for the best constant, {}, is the end of those that were run and one beyond it may be better",
            reference.noise
        ));
    }
    Some(clause(comparison, reference))
}

fn named(reference: &Reference) -> String {
    match reference.choice {
        Choice::Training => format!("with a constant of {}", reference.noise),
        Choice::Baseline => format!("with the usual constant {}", reference.noise),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_eval::closed_loop::testing::row;
    use dpn_eval::study::{MARGIN, RowSet};
    use dpn_train::split::Side;

    /// Twelve sequences, x2 the best of the constants on training; the network's error is so many times that of x2, give or take `swing`.
    fn sentence(factor: f64, swing: f64, sequences: usize) -> Option<String> {
        among(&["x1", "x2", "x4"], factor, swing, sequences)
    }

    /// The same where these constants were run, each error 1.3 times that of x2 but its own.
    fn among(constants: &[&str], factor: f64, swing: f64, sequences: usize) -> Option<String> {
        let mut rows = Vec::new();
        for i in 0..sequences {
            let of_constants = constants.iter().map(|name| (*name, if *name == "x2" { 1.0 } else { 1.3 }));
            let noises = of_constants
                .chain([("dualpronet", factor * if i % 2 == 0 { 1.0 + swing } else { 1.0 - swing })]);
            for (noise, times) in noises {
                let mut row = row(&format!("s{i:02}"), noise, 0, Some(times * (0.1 + 0.003 * i as f64)));
                row.split = if i % 3 == 0 { Side::Test } else { Side::Train };
                rows.push(row);
            }
        }
        against(&Study::new(&RowSet::new(&rows), MARGIN).unwrap(), &specs::noise(specs::DUALPRONET))
    }

    #[test]
    fn the_sentence_says_what_the_tests_show_and_no_more() {
        for (factor, swing, sequences, expected) in [
            (0.7, 0.0, 12, "better than with a constant of x2"),
            (1.5, 0.0, 12, "worse than with a constant of x2"),
            (1.0, 0.01, 12, "as good as with a constant of x2"),
            (1.05, 0.4, 12, "not shown to be better than with a constant of x2"),
            (1.12, 0.25, 12, "no better than with a constant of x2"),
            (0.7, 0.0, 4, "better in 4 of 4 sequences, too few to test, than with a constant of x2"),
        ] {
            assert_eq!(sentence(factor, swing, sequences).as_deref(), Some(expected), "{factor} {swing}");
        }
        let end = "not judged, for the best constant, x2, is the end of those that were run and one beyond it may be better";
        for constants in [["x1", "x2"], ["x2", "x4"]] {
            assert_eq!(among(&constants, 0.7, 0.0, 12).as_deref(), Some(end), "{constants:?}");
        }
        assert_eq!(
            against(&Study::new(&RowSet::new(&[]), MARGIN).unwrap(), &specs::noise(specs::LEARNED)),
            None
        );
    }
}
