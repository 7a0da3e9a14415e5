//! How long the log is at rest, and how the bias drifts there.

use crate::allan::rest::Rest;
use crate::finding::Finding;
use crate::phases::{Phase, Stretch, longest_rest};
use dpn_core::{Recorded, Sensor};
use std::io;

/// The shortest rest that says anything of a drift \[s\].
const LEAST_S: f64 = 60.0;

pub(super) fn findings(
    recording: &dyn Recorded,
    rest: &Rest,
    stretches: &[Stretch],
) -> io::Result<Vec<Finding>> {
    let length = recording.length_s();
    let seconds = |phase| stretches.iter().filter(|s| s.phase == phase).map(Stretch::length_s).sum::<f64>();
    let parts: Vec<String> = Phase::ALL
        .into_iter()
        .filter(|phase| stretches.iter().any(|s| s.phase == *phase))
        .map(|phase| format!("{:.0} s {phase}", seconds(phase)))
        .collect();
    let mut findings = vec![Finding::note(
        "motion",
        match longest_rest(stretches) {
            Some(_) if stretches.len() == 1 => format!("at rest throughout, {length:.0} s"),
            Some(longest) => format!(
                "{}; the longest rest is from {:.1} to {:.1} s",
                parts.join(", "),
                longest.from_s,
                longest.to_s
            ),
            None => format!("{}; never at rest", parts.join(", ")),
        },
    )];
    if stretches.first().is_some_and(|s| s.phase == Phase::Moving) {
        findings.push(Finding::note(
            "start",
            "the log moves from its first second on: an estimator that starts from rest cannot".into(),
        ));
    }
    let period = recording.rate().period();
    if rest.longest.len() as f64 * period >= LEAST_S {
        findings.push(drift(recording, rest, period)?);
    }
    Ok(findings)
}

/// The steepest slope of a gyroscope axis over the longest rest, by least squares.
fn drift(recording: &dyn Recorded, rest: &Rest, period: f64) -> io::Result<Finding> {
    let count = rest.longest.len();
    let middle = (count as f64 - 1.0) / 2.0;
    let (mut up, mut down, mut index) = ([0.0; 3], 0.0, 0.0);
    recording.each(rest.longest.clone(), &mut |s| {
        let t = (index - middle) * period;
        for (up, v) in up.iter_mut().zip(s.of(Sensor::Gyro)) {
            *up += t * v;
        }
        down += t * t;
        index += 1.0;
    })?;
    let slopes = up.map(|up| up / down);
    let axis = (0..3).max_by(|a, b| slopes[*a].abs().total_cmp(&slopes[*b].abs())).expect("three axes");
    let span = count as f64 * period;
    let moved = (slopes[axis] * span).abs();
    let text = format!(
        "over {span:.0} s at rest the bias of gyro {} drifts by {moved:.2e} rad/s ({:.2} deg/h)",
        ["x", "y", "z"][axis],
        moved.to_degrees() * 3600.0
    );
    Ok(if moved > 5e-3 {
        Finding::warning(
            "drift",
            text,
            "let the sensor warm up before use; a drift this large is mostly temperature",
        )
    } else {
        Finding::note("drift", text)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::allan::rest::rest;
    use crate::doctor::values::tests::level;
    use crate::phases::phases;
    use dpn_core::ImuRecording;

    #[test]
    fn a_warming_gyroscope_is_named_with_its_drift() {
        let mut samples = level(100);
        for s in &mut samples {
            s.gyro[2] += 1e-4 * (s.t.ns() as f64 * 1e-9);
        }
        let recording = ImuRecording::new(samples).unwrap();
        let found = findings(&recording, &rest(&recording).unwrap(), &phases(&recording).unwrap()).unwrap();
        let drift = found.iter().find(|f| f.about == "drift").unwrap();
        assert!(drift.text.contains("gyro z drifts by 1.0") && drift.remedy.is_some(), "{drift:?}");
        assert_eq!(found[0].text, "at rest throughout, 100 s");
    }
}
