//! Every name a spec may begin with, and how it is written.

use super::SpecError;
use crate::config::nearest;

pub(super) const MULTIPLE: &str = "x<factor>";
pub(super) const CONST_ONE: &str = "const(value)";
pub(super) const CONST_BOTH: &str = "const(accel,gyro)";
pub(super) const EFFECTIVE: &str = "effective(span)";
pub(super) const PLUS: &str = "plus(spec,constant)";

/// Name and way of writing of every estimator.
pub(super) const ESTIMATORS: [(&str, &str); 12] = [
    ("sg", "sg(window,order)"),
    ("diff1", "diff1"),
    ("diff2", "diff2"),
    ("diff3", "diff3"),
    ("diff4", "diff4"),
    ("mad2", "mad2"),
    ("wavelet", "wavelet(haar|db2|db4)"),
    ("allan", "allan"),
    ("running", "running(first)"),
    ("sliding", "sliding(length)"),
    ("ewma", "ewma(alpha)"),
    ("kalman", "kalman(q)"),
];

/// The same of what stands for both sensors and needs more than the samples so far.
const BOTH_SENSORS: [(&str, &str); 8] = [
    ("self", "self(spec)"),
    ("dualpronet", "dualpronet(tag)"),
    ("file", "file(\"path\")"),
    ("oracle", "oracle"),
    ("shuffled", "shuffled(spec)"),
    ("mean", "mean(spec)"),
    ("mean-of-train", "mean-of-train(spec)"),
    ("plus", PLUS),
];

/// Whether `name` stands for both sensors.
pub(super) fn is_both(name: &str) -> bool {
    BOTH_SENSORS.iter().any(|(known, _)| *known == name)
}

/// The answer to a name that is none of these.
pub(super) fn unknown(name: &str) -> SpecError {
    let all = || BOTH_SENSORS.iter().chain(&ESTIMATORS);
    let names = all().map(|(name, _)| *name).chain(["const", "x1", "effective"]);
    let usages = [MULTIPLE, CONST_BOTH, EFFECTIVE].into_iter().chain(all().map(|(_, usage)| *usage));
    SpecError::Unknown {
        name: name.to_owned(),
        nearest: nearest(name, names).map(str::to_owned),
        known: usages.map(str::to_owned).collect(),
    }
}
