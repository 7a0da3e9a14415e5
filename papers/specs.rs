//! Noise specs that the paper again names: its columns, controls and drawings; and what each is called where people read.
//!
//! A spec stands in configurations, CSV files and the page's list of names; tables, legends and sentences have [`name`]. No two specs of the study share one.

use dpn_core::estimate::spec::{EstimatorSpec, SensorPair, SensorSpec};
use dpn_core::estimate::{DEFAULT_TAG, NoiseSpec};
use dpn_figures::Cell;

/// The paper's columns of the closed loop, those that are compared before the others.
pub(super) const PAPER: [&str; 4] = ["x1", "dualpronet", "x2", "x0.5"];
/// The baseline.
pub(super) const BASELINE: &str = "x1";
/// The paper's networks.
pub(super) const DUALPRONET: &str = "dualpronet";
/// What the odometry learns of its noise while it runs.
pub(super) const LEARNED: &str = "self";
/// The truth of what was added.
pub(super) const ORACLE: &str = "oracle";
/// What EuRoC's sensor, an ADIS16448, says in its data sheet: deviations a sample at 200 Hz.
pub(super) const DATA_SHEET: &str = "const(0.0283,0.0024)";
/// A network trained on raw signals and a wide range, beside a constant: what follows added noise best.
pub(super) const WIDE_PLUS: &str = "plus(dualpronet(wide-s0),x4)";

/// Noises shown against the best constant at the head of the page, as far as they were run.
pub(super) const SHOWN: [&str; 14] = [
    LEARNED,
    "mean(self)",
    "shuffled(self)",
    "dualpronet",
    "mean(dualpronet)",
    "shuffled(dualpronet)",
    "mean-of-train(dualpronet)",
    "dualpronet(wide-s0)",
    WIDE_PLUS,
    "diff2",
    DATA_SHEET,
    "x1",
    "x2",
    "x4",
];

/// A spec that stands in this program, parsed.
pub(super) fn noise(spec: &str) -> NoiseSpec {
    spec.parse().expect("a spec written in this program, held to the grammar by a test")
}

/// Several of them.
pub(super) fn noises<const N: usize>(specs: [&str; N]) -> [NoiseSpec; N] {
    specs.map(noise)
}

/// A control: a root mean square or values at other times, of another's.
pub(super) fn is_control(noise: &NoiseSpec) -> bool {
    matches!(noise, NoiseSpec::Shuffled(_) | NoiseSpec::Mean(_) | NoiseSpec::MeanOfTrain(_))
}

/// Whether networks say the noise, alone or beside a constant.
pub(super) fn is_network(noise: &NoiseSpec) -> bool {
    !is_control(noise) && !noise.is_learned() && matches!(noise.source(), NoiseSpec::DualProNet { .. })
}

/// Whether a noise is known only once the odometry has run: it has no track and no cost of its own.
pub(super) fn is_of_run(noise: &NoiseSpec) -> bool {
    noise.is_learned() || noise.learned_before().is_some()
}

/// What a noise is called.
pub(super) fn name(noise: &NoiseSpec) -> String {
    match noise {
        _ if *noise == self::noise(DATA_SHEET) => "data sheet".into(),
        NoiseSpec::Sensors(pair) => pair_name(pair),
        NoiseSpec::DualProNet { accel, gyro } if accel == gyro => match accel.as_str() {
            DEFAULT_TAG => "DualProNet".into(),
            "order-s0" => "DualProNet, norm after activation".into(),
            "total-s0" => "DualProNet, trained on total noise".into(),
            "paper-s0" => "DualProNet, the paper as it reads".into(),
            "wide-s0" => "wide DualProNet".into(),
            tag => format!("DualProNet {tag}"),
        },
        NoiseSpec::DualProNet { accel, gyro } => format!("DualProNet {accel} and {gyro}"),
        NoiseSpec::File(path) => format!("track {}", path.display()),
        NoiseSpec::Oracle => "oracle, given the truth".into(),
        NoiseSpec::Shuffled(of) => format!("{}, at wrong times", name(of)),
        NoiseSpec::Mean(of) => format!("{}, its mean", name(of)),
        NoiseSpec::MeanOfTrain(of) => format!("{}, its mean in training", name(of)),
        NoiseSpec::Learned(of) if of.multiple() == Some(1.0) => "learned while it runs".into(),
        NoiseSpec::Learned(of) => format!("learned while it runs, from {}", name(of)),
        NoiseSpec::Plus { of, constant } => format!("{} + {constant}", name(of)),
    }
}

fn pair_name(SensorPair { accel, gyro }: &SensorPair) -> String {
    let one = |sensor: &SensorSpec| match sensor {
        SensorSpec::Multiple(1.0) => "usual constant x1".into(),
        SensorSpec::Multiple(factor) => format!("constant x{factor}"),
        SensorSpec::Fixed(sigma) => format!("constant {sigma}"),
        SensorSpec::Estimator(estimator) => simple_name(estimator),
        SensorSpec::Effective(span_s) => format!("as white noise over {span_s} s"),
    };
    if accel == gyro { one(accel) } else { format!("{} and {}", one(accel), one(gyro)) }
}

fn simple_name(estimator: &EstimatorSpec) -> String {
    use EstimatorSpec as E;
    match estimator {
        E::Sg { window, order } => format!("Savitzky-Golay residual ({window}, {order})"),
        E::Diff { order } => {
            let which = ["first", "second", "third", "fourth"].get(order - 1).copied();
            which.map_or_else(|| estimator.to_string(), |which| format!("{which} differences"))
        }
        E::Mad2 => "median second difference".into(),
        E::Wavelet(_) => estimator.to_string(),
        E::Allan => "Allan deviation".into(),
        E::Running { first: None } => "running deviation".into(),
        E::Running { first: Some(first) } => format!("running deviation of {first}"),
        E::Sliding { length: None } => "sliding deviation".into(),
        E::Sliding { length: Some(length) } => format!("sliding deviation of {length}"),
        E::Ewma { alpha } => format!("fading deviation ({alpha})"),
        E::Kalman { ratio } => format!("Kalman residual ({ratio})"),
    }
}

/// What an estimator of the open loop is called: a row's name is a network's, a regressor's or a spec.
pub(super) fn estimator_name(row: &str) -> String {
    match row {
        "pronet" => "network".into(),
        "pronet-paper" => "network, the paper as it reads".into(),
        "pronet-order" => "network, norm after activation".into(),
        "pronet-total" => "network, trained on total noise".into(),
        "pronet-wide" => "wide network".into(),
        "kernel-svr" => "support vectors on features".into(),
        "elastic-net" => "elastic net on features".into(),
        other => other.parse().map_or_else(|_| other.to_owned(), |spec| name(&spec)),
    }
}

/// A noise in a table: its name for people, its spec in CSV.
pub(super) fn cell(noise: &NoiseSpec) -> Cell {
    Cell::named(name(noise), noise)
}

#[cfg(test)]
mod tests {
    use super::super::plan::Plan;
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn no_two_noises_of_the_study_share_a_name() {
        let plan = Plan::whole();
        let injected = &plan.injected;
        let lists = [&plan.noises, &plan.others, &injected.noises, &injected.followed];
        let mut named: BTreeMap<String, &str> = BTreeMap::new();
        for spec in lists.into_iter().flatten() {
            let name = name(&noise(spec));
            assert!(!name.contains(['(', ')']) || !name.contains("dualpronet"), "{name}");
            let before = named.insert(name.clone(), spec).unwrap_or(spec);
            assert_eq!(before, spec, "{name}");
        }
        for (spec, expected) in [
            (WIDE_PLUS, "wide DualProNet + x4"),
            ("mean(plus(dualpronet(wide-s0),x4))", "wide DualProNet + x4, its mean"),
            ("shuffled(dualpronet)", "DualProNet, at wrong times"),
            ("x4,x1", "constant x4 and usual constant x1"),
            ("const(0.1,0.01)", "constant 0.1 and constant 0.01"),
            (DATA_SHEET, "data sheet"),
            ("mean(self)", "learned while it runs, its mean"),
        ] {
            assert_eq!(name(&noise(spec)), expected);
        }
        assert_eq!(estimator_name("diff2"), "second differences");
        assert_eq!(estimator_name("gradient-boost@sg(11,2)"), "gradient-boost@sg(11,2)");
    }

    #[test]
    fn specs_of_the_program_are_written_canonically() {
        for spec in PAPER
            .into_iter()
            .chain([BASELINE, DUALPRONET, LEARNED, ORACLE, DATA_SHEET, WIDE_PLUS])
            .chain(SHOWN)
        {
            assert_eq!(noise(spec).to_string(), spec);
        }
    }

    #[test]
    fn controls_of_a_network_are_no_network() {
        let of = |spec: &str| (is_network(&noise(spec)), is_control(&noise(spec)));
        assert_eq!(of(WIDE_PLUS), (true, false));
        assert_eq!(of("mean-of-train(dualpronet)"), (false, true));
        assert_eq!(of("plus(diff2,x4)"), (false, false));
        assert_eq!(of("self(dualpronet)"), (false, false));
    }
}
