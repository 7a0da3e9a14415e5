//! One flight's raw signal over the noise that models see in it.

use anyhow::Result;
use dpn_core::{NoiseTrack, Sensor};
use dpn_eval::noise::{Recorded, of_recording};
use dpn_figures::{Flight, flight_sigma, save};
use dpn_pronet::DualProNet;
use dpn_pronet::network::Network;
use dpn_train::corpus::Corpus;
use dpn_train::levels::{LevelKind, Levels};
use dpn_train::split::Side;
use std::path::{Path, PathBuf};

/// Base whose networks are shown.
const BASE: &str = "sg(11,2)";

/// Draws accelerometer x of the first test flight; nothing where there is no pair of networks.
pub(super) fn draw(corpora: &[Corpus], networks: &[Network], out: &Path) -> Result<Vec<PathBuf>> {
    let find = |sensor| {
        let mut fitting =
            networks.iter().filter(|n| n.sensor() == sensor && n.base == BASE && n.name == "pronet");
        fitting.next().map(|network| network.weights.clone())
    };
    let (Some(accel), Some(gyro)) = (find(Sensor::Accel), find(Sensor::Gyro)) else {
        return Ok(Vec::new());
    };
    let Some((name, recording)) = corpora.iter().find_map(|corpus| corpus.side(Side::Test).first().copied())
    else {
        return Ok(Vec::new());
    };
    let mut tracks = vec![(
        "pronet",
        NoiseTrack::of(&mut DualProNet::new("pronet", &accel, &gyro, DualProNet::HOP)?, recording),
    )];
    for spec in ["diff2", "sg(11,2)"] {
        let recorded = Recorded { name, imu: recording, oracle: None };
        tracks.push((spec, of_recording(&spec.parse()?, &recorded, networks)?));
    }
    let accel_x = |track: &NoiseTrack| track.noises().iter().map(|n| n.of(Sensor::Accel)[0]).collect();
    let tracks: Vec<(&str, Vec<f64>)> = tracks.iter().map(|(name, track)| (*name, accel_x(track))).collect();
    let start = recording.samples()[0].t;
    let t: Vec<f64> = recording.samples().iter().map(|sample| sample.t.seconds_since(start)).collect();
    let signal = recording.axis(Sensor::Accel, 0);
    let flight = Flight {
        name,
        sensor: Sensor::Accel,
        axis: "x",
        t: &t,
        signal: &signal,
        models: tracks.iter().map(|(name, sigma)| (*name, sigma.as_slice())).collect(),
        truth: None,
        phases: Vec::new(),
        trained_up_to: Some(Levels::paper(Sensor::Accel, LevelKind::Grid).high),
        words: "",
    };
    Ok(save(&flight_sigma(&flight)?, &out.join("flight_sigma"))?)
}
