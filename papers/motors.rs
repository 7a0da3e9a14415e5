//! When motors run at the speed of flight, seen in the samples.
//!
//! Rotor vibration in flight is tens of times a sensor's own noise, so that the deviation of second differences over a second tells flight from
//! rest. Idling motors are not told from resting ones.

use dpn_core::{ImuRecording, Sensor};
use dpn_figures::Phase;

/// Deviation \[m/s^2\] over a second above which motors count as at speed: some eight times EuRoC's sensor at rest.
const RUNNING: f64 = 0.25;
/// A phase shorter than this joins the one before it \[s\].
const SHORTEST_S: f64 = 2.0;
/// The root of the sum of squares of (1, -2, 1).
const GAIN: f64 = 2.449_489_742_783_178;

/// Phases of a recording, from its first sample on, time in seconds.
pub(super) fn phases(recording: &ImuRecording) -> Vec<Phase> {
    let samples = recording.samples();
    let start = samples[0].t;
    let mut seconds: Vec<(f64, Vec<f64>)> = Vec::new();
    for three in samples.windows(3) {
        let t = three[1].t.seconds_since(start);
        let square: f64 = (0..3)
            .map(|axis| {
                let [a, b, c] = [0, 1, 2].map(|i| three[i].of(Sensor::Accel)[axis]);
                ((a - 2.0 * b + c) / GAIN).powi(2) / 3.0
            })
            .sum();
        match seconds.last_mut() {
            Some((from, squares)) if t - *from < 1.0 => squares.push(square),
            _ => seconds.push((t, vec![square])),
        }
    }
    let mut phases: Vec<Phase> = Vec::new();
    let end = recording.duration();
    for (from, squares) in seconds {
        let running = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt() > RUNNING;
        let label = if running { "motors at speed" } else { "motors off or idle" };
        match phases.last_mut() {
            Some(last) if last.label == label => {}
            Some(last) => {
                last.to = from;
                phases.push(Phase { label: label.into(), from, to: end });
            }
            None => phases.push(Phase { label: label.into(), from: 0.0, to: end }),
        }
    }
    joined(phases)
}

/// Without phases that are too short to see.
fn joined(phases: Vec<Phase>) -> Vec<Phase> {
    let mut kept: Vec<Phase> = Vec::new();
    for phase in phases {
        match kept.last_mut() {
            Some(last) if last.label == phase.label || phase.to - phase.from < SHORTEST_S => {
                last.to = phase.to;
            }
            _ => kept.push(phase),
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_sim::{Flight, FlightConfig, simulate};

    #[test]
    fn phases_of_a_simulated_flight_are_those_of_its_motors() {
        let flight = simulate(Flight::ALL[8], 0, &FlightConfig::default()).unwrap();
        let samples = flight.recording.samples();
        let running = |t: f64| {
            let i = samples.partition_point(|s| s.t.seconds_since(samples[0].t) < t);
            !flight.phase_track[i].stands()
        };
        let found = phases(&flight.recording);
        assert!(found.len() >= 2, "{found:?}");
        for phase in &found {
            // Two seconds of spinning up or down, and the second that is looked at, are not held against it.
            let (from, to) = (phase.from + 3.0, phase.to - 3.0);
            if to > from {
                for t in [from, 0.5 * (from + to), to] {
                    assert_eq!(running(t), phase.label == "motors at speed", "{t} {phase:?}");
                }
            }
        }
        assert!(found.windows(2).all(|w| (w[0].to - w[1].from).abs() < 1e-9 && w[0].label != w[1].label));
    }
}
