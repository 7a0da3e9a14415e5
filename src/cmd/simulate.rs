//! `dpn simulate`.

use super::{images, tracks};
use crate::args::{FlightArgs, SimulateWhat};
use crate::ui::outln;
use anyhow::Result;
use dpn_core::noise::{AccelNoiseDensity, GyroNoiseDensity};
use dpn_core::truth::GroundTruth;
use dpn_io::asl::{ImuConfig, SequenceParts, write_sequence};
use dpn_io::{ResultPath, write_noise_track};
use dpn_sim::{Flight, FlightConfig, SimulatedFlight, simulate, simulate_all};
use nalgebra::Isometry3;

pub(crate) fn run(what: SimulateWhat) -> Result<()> {
    match what {
        SimulateWhat::Flight(args) => flight(args),
        SimulateWhat::Tracks(args) => tracks::run(&args),
        SimulateWhat::Images(args) => images::run(&args),
    }
}

fn flight(args: FlightArgs) -> Result<()> {
    if args.list {
        for flight in Flight::ALL {
            outln!("{:24} {:?}", flight.name(), flight.split())?;
        }
        return Ok(());
    }
    let config: FlightConfig = dpn_io::config::load_over(args.config.as_deref(), &[])?;
    let name = args.name.unwrap_or_default();
    let flights = if name == "all" {
        simulate_all(args.seed, &config)?
    } else {
        vec![simulate(name.parse::<Flight>()?, args.seed, &config)?]
    };
    for flight in &flights {
        let dir = args.out.join(flight.name());
        write(flight, &config, &dir)?;
        if args.json {
            let row = serde_json::json!({
                "flight": flight.name(), "seed": args.seed, "samples": flight.recording.len(),
                "seconds": flight.recording.duration(), "dir": dir,
            });
            outln!("{row}")?;
        } else {
            outln!(
                "{}: {} samples, {:.0} s",
                dir.display(),
                flight.recording.len(),
                flight.recording.duration()
            )?;
        }
    }
    Ok(())
}

/// The flight as an ASL sequence, with the true white noise of every sample beside it.
fn write(flight: &SimulatedFlight, config: &FlightConfig, dir: &ResultPath) -> Result<()> {
    let truth = GroundTruth::new(flight.ground_truth.clone())?;
    let (rate, scale) = (flight.recording.rate(), config.white.scale);
    let imu = ImuConfig {
        rate,
        gyro_noise: GyroNoiseDensity::new(scale * config.white.gyro_sample_std.to_density(rate).get())?,
        gyro_walk: config.bias.gyro_walk,
        accel_noise: AccelNoiseDensity::new(scale * config.white.accel_sample_std.to_density(rate).get())?,
        accel_walk: config.bias.accel_walk,
        body_from_imu: Isometry3::identity(),
    };
    write_noise_track(dir.join("true_noise.csv"), &flight.truth.oracle(&flight.recording)?)?;
    let parts = SequenceParts { imu: &flight.recording, imu_config: Some(&imu), ground_truth: Some(&truth) };
    write_sequence(dir, &parts)?;
    Ok(())
}
