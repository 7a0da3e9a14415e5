//! Flights: trajectories, errors by time, what is said of the noise.

use super::super::error::PaperError;
use super::super::motors;
use super::super::specs;
use super::super::states::{PairedRun, read};
use dpn_core::estimate::NoiseSpec;
use dpn_core::random::Stream;
use dpn_core::{ImuRecording, NoiseTrack, Sensor};
use dpn_eval::closed_loop::{CellFiles, CellKey, Recording, Row, SequenceFault};
use dpn_eval::noise::{Fresh, Recorded};
use dpn_figures::{Cell, Chart, ErrorColumn, Flight, TrajectoryPanel, error_band, flight_sigma};
use dpn_io::ResultPath;
use dpn_pronet::network::Network;
use dpn_train::levels::{LevelKind, Levels};
use dpn_train::split::Side;

/// What a sweep kept of one cell, beside the truth; nothing where the run has too few poses.
fn beside(
    dir: &ResultPath,
    keep: &CellFiles,
    key: &CellKey,
    recording: &Recording,
) -> Result<Option<PairedRun>, PaperError> {
    let Some((path, truth)) = keep.states_path(dir, key).zip(recording.truth.as_ref()) else {
        return Ok(None);
    };
    PairedRun::new(&recording.name, truth, &read(&path)?)
}

/// The seed whose states were kept.
fn seed_of(keep: &CellFiles) -> u64 {
    keep.states.as_ref().expect("the study keeps states for its figures").1
}

fn key(sequence: &str, noise: &NoiseSpec, seed: u64) -> CellKey {
    CellKey { sequence: sequence.to_owned(), seed, noise: noise.to_string() }
}

/// A name that fits under a panel.
fn short(noise: &NoiseSpec) -> String {
    noise.multiple().map_or_else(|| specs::name(noise), |multiple| format!("x{multiple}"))
}

/// Every sequence from above: truth, baseline, DualProNet.
pub(crate) fn trajectories(
    recordings: &[Recording],
    rows: &[Row],
    dir: &ResultPath,
    keep: &CellFiles,
    noises: &[NoiseSpec],
) -> Result<Chart, PaperError> {
    let seed = seed_of(keep);
    let mut panels = Vec::new();
    for recording in recordings {
        let mut estimates = Vec::new();
        let mut words = Vec::new();
        for noise in noises {
            let key = key(&recording.name, noise, seed);
            let found = beside(dir, keep, &key, recording)?;
            let ate = rows.iter().find(|row| row.key() == key).and_then(|row| row.ate_se3);
            let name = short(noise);
            words.push(ate.map_or_else(
                || format!("{name}: no pose"),
                |ate| format!("{name}: {} m", Cell::metres(ate).shown()),
            ));
            let refused = |source| SequenceFault::Metrics(source).of(&recording.name);
            estimates.push(match found {
                Some(found) => found.aligned().map_err(refused)?,
                None => None,
            });
        }
        let truth = recording.truth.iter().flatten().map(|p| p.world_from_body.translation.vector.into());
        let mark = if recording.side == Side::Test { "*" } else { "" };
        panels.push(TrajectoryPanel {
            name: format!("{}{mark}", recording.name),
            truth: truth.collect(),
            estimates,
            words: words.join(", "),
        });
    }
    let caption = format!(
        "From above, equal scales; estimates after SE(3) alignment, one run each (seed {seed}); under the name the absolute error of that run. \
         Star: test sequence."
    );
    let names: Vec<String> = noises.iter().map(specs::name).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    Ok(dpn_figures::trajectories(&panels, &names, &caption)?)
}

/// Errors of one sequence by time, with what the estimator believed of them.
pub(crate) fn errors(
    recording: &Recording,
    dir: &ResultPath,
    keep: &CellFiles,
    noises: &[NoiseSpec],
) -> Result<Option<Chart>, PaperError> {
    let seed = seed_of(keep);
    let mut columns = Vec::new();
    for noise in noises {
        let Some(found) = beside(dir, keep, &key(&recording.name, noise, seed), recording)? else {
            continue;
        };
        let start = found.pairs[0].t;
        let (mut t, mut errors, mut bands) = (Vec::new(), Vec::new(), Vec::new());
        for (pair, (error, band)) in found.pairs.iter().zip(found.errors()) {
            if let Some(band) = band {
                t.push(pair.t.seconds_since(start));
                errors.push(error);
                bands.push(band);
            }
        }
        if t.len() >= 2 {
            columns.push(ErrorColumn { name: specs::name(noise), t, errors, bands });
        }
    }
    if columns.is_empty() {
        return Ok(None);
    }
    let caption = format!(
        "One run each (seed {seed}). Estimate and truth agree at the pose that the estimator took for known; grey: three deviations of the newest pose \
         about it, as the estimator believes them. A band far wider than the errors is cut at the panel's edge."
    );
    Ok(Some(error_band(&format!("{}: error of position by time", recording.name), &columns, &caption)?))
}

/// The tracks of `noises` on `imu`, by name.
fn tracks(
    recording: &Recording,
    imu: &ImuRecording,
    oracle: Option<&NoiseTrack>,
    noises: &[NoiseSpec],
    networks: &[Network],
    seed: u64,
) -> Result<Vec<(String, std::sync::Arc<NoiseTrack>)>, PaperError> {
    let sources = Fresh { recorded: Recorded { name: &recording.name, imu, oracle }, networks };
    let stream = Stream::new(seed).named("noise").named(&recording.name);
    let of = |noise: &NoiseSpec| {
        let track = dpn_eval::noise::track(noise, imu, &sources, &stream)?;
        Ok((specs::name(noise), track))
    };
    noises.iter().map(of).collect()
}

fn figure(
    recording: &Recording,
    imu: &ImuRecording,
    tracks: &[(String, std::sync::Arc<NoiseTrack>)],
    truth: Option<&NoiseTrack>,
    (sensor, axis): (Sensor, usize),
    trained_up_to: Option<f64>,
    words: &str,
) -> Result<Chart, PaperError> {
    let start = imu.samples()[0].t;
    let t: Vec<f64> = imu.samples().iter().map(|s| s.t.seconds_since(start)).collect();
    let signal = imu.axis(sensor, axis);
    let of = |track: &NoiseTrack| track.noises().iter().map(|n| n.of(sensor)[axis]).collect::<Vec<f64>>();
    let said: Vec<(&str, Vec<f64>)> = tracks.iter().map(|(name, track)| (name.as_str(), of(track))).collect();
    let truth = truth.map(of);
    Ok(flight_sigma(&Flight {
        name: &recording.name,
        sensor,
        axis: ["x", "y", "z"][axis],
        t: &t,
        signal: &signal,
        models: said.iter().map(|(name, sigma)| (*name, sigma.as_slice())).collect(),
        truth: truth.as_deref(),
        phases: motors::phases(&recording.imu),
        trained_up_to,
        words,
    })?)
}

/// What is said over a flight, with the times at which motors run.
pub(crate) fn sigma_over_flight(
    recording: &Recording,
    noises: &[NoiseSpec],
    networks: &[Network],
    sensor: Sensor,
) -> Result<Chart, PaperError> {
    let tracks = tracks(recording, &recording.imu, recording.oracle.as_ref(), noises, networks, 0)?;
    let up_to = Some(Levels::paper(sensor, LevelKind::Grid).high);
    let words = "Motors: at speed where second differences of the accelerometer over a second exceed .25 m/s² of deviation.";
    figure(recording, &recording.imu, &tracks, recording.oracle.as_ref(), (sensor, 0), up_to, words)
}

/// What is said while the noise of a recording goes up and down; `truth` is what an oracle says.
pub(crate) fn step_response(
    recording: &Recording,
    imu: &ImuRecording,
    truth: &NoiseTrack,
    noises: &[NoiseSpec],
    networks: &[Network],
    sensor: Sensor,
    seed: u64,
) -> Result<Chart, PaperError> {
    let tracks = tracks(recording, imu, Some(truth), noises, networks, seed)?;
    let words = "True σ: root of the sum of squares of what is added and of the best constant without it.";
    figure(recording, imu, &tracks, Some(truth), (sensor, 0), None, words)
}
