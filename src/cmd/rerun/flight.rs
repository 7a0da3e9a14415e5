//! `dpn simulate flight --rerun`: the way, the samples, and the noise that is in them.

use super::log::{RerunLog, TRUE};
use anyhow::Result;
use dpn_core::Sensor;
use dpn_sim::SimulatedFlight;
use std::path::Path;

/// One sample in so many is shown.
const EVERY: usize = 10;

/// Writes the flights into one recording, an entity each.
pub(in crate::cmd) fn flights(path: &Path, flights: &[SimulatedFlight]) -> Result<()> {
    let first = flights.first().expect("at least one flight is flown");
    let log = RerunLog::new("simulated flights", first.recording.samples()[0].t)?;
    for flight in flights {
        let name = flight.flight.name();
        for sensor in Sensor::ALL {
            log.axes(&format!("{name}/sample/{sensor}"))?;
            log.axes(&format!("{name}/noise/{sensor}"))?;
        }
        let noise = flight.truth.oracle(&flight.recording)?;
        let states = flight.recording.samples().iter().zip(&flight.ground_truth).zip(noise.noises());
        let mut places = Vec::new();
        for ((sample, state), noise) in states.step_by(EVERY) {
            log.at(sample.t);
            log.pose(&format!("{name}/truth/body"), &state.world_from_body)?;
            places.push(state.world_from_body.translation.vector);
            for sensor in Sensor::ALL {
                log.numbers(&format!("{name}/sample/{sensor}"), &sample.of(sensor))?;
                log.numbers(&format!("{name}/noise/{sensor}"), &noise.of(sensor))?;
            }
        }
        log.path(&format!("{name}/truth/path"), &places, TRUE)?;
    }
    log.finish(path)
}
