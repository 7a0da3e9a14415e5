//! Spectral peaks: what shakes, and what may be a higher frequency folded back.

use crate::finding::Finding;
use dpn_core::signal::spectrum::{Averaging, Peak, Spectrum, Welch};
use dpn_core::signal::stats;
use dpn_core::{Recorded, Sensor};
use serde::Serialize;
use std::io;

/// A band stands this many times above the middle densities of what lies on both sides of it. Motion, falling off with frequency, stays
/// below .9 of its lower side; of white noise over four segments none reaches 2. Set on EuRoC's training sequences and TUM-VI's rooms 1 and 2.
const BESIDE: f64 = 3.0;
/// And it has this share of its axis' power above [`LEAST_HZ`].
const SHARE: f64 = 0.1;
/// Bands an axis is given.
const MOST: usize = 2;
/// Width over which densities are averaged before bands are sought: rotors are never quite at one speed \[Hz\].
const WIDTH_HZ: f64 = 3.0;
/// Frequencies below belong to motion \[Hz\].
const LEAST_HZ: f64 = 8.0;
/// Length of a segment \[s\].
const SEGMENT_S: f64 = 2.0;
/// Segments that are read at a time.
const SEGMENTS: usize = 8;

/// The spectrum of one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisSpectrum {
    /// The sensor.
    pub sensor: Sensor,
    /// 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Its density.
    pub spectrum: Spectrum,
}

/// Spectra of the six axes; none where the log has not four segments.
///
/// # Errors
/// As [`Samples::piece`](dpn_core::Samples::piece).
pub fn spectra(recording: &dyn Recorded) -> io::Result<Vec<AxisSpectrum>> {
    let rate = recording.rate();
    let segment = ((rate.hz() * SEGMENT_S) as usize).max(16);
    if recording.len() < 4 * segment {
        return Ok(Vec::new());
    }
    let welch = Welch::new(segment).expect("16 samples or more");
    let all = Sensor::ALL.into_iter().flat_map(|sensor| (0..3).map(move |axis| (sensor, axis)));
    let mut axes: Vec<(Sensor, usize, Averaging<'_>)> =
        all.map(|(sensor, axis)| (sensor, axis, welch.averaging())).collect();
    let step = welch.step();
    let mut signal = Vec::with_capacity(segment);
    // Whole segments, and half of each again.
    for from in (0..=recording.len() - segment).step_by(step * SEGMENTS) {
        let segments = ((recording.len() - segment - from) / step + 1).min(SEGMENTS);
        let piece = recording.piece(from..from + (segments - 1) * step + segment)?;
        for (sensor, axis, averaging) in &mut axes {
            signal.clear();
            signal.extend(piece.iter().map(|s| s.of(*sensor)[*axis]));
            averaging.take(&signal);
        }
    }
    let spectrum = |(sensor, axis, averaging): (Sensor, usize, Averaging<'_>)| {
        let spectrum = averaging.spectrum(rate).expect("four segments or more");
        AxisSpectrum { sensor, axis, spectrum }
    };
    Ok(axes.into_iter().map(spectrum).collect())
}

/// An axis that shakes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Shaking {
    /// The sensor.
    pub sensor: Sensor,
    /// 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Where \[Hz\].
    pub hz: f64,
    /// Root of the mean square of the band around it, in the sensor's unit.
    pub rms: f64,
    /// Share of the axis' power above 8 Hz.
    pub share: f64,
    /// Density at its top \[unit^2 / Hz\].
    pub density: f64,
    /// Half the rate \[Hz\].
    pub nyquist: f64,
}

/// What shakes: the bands that a finding names, axis by axis.
pub fn shaking(spectra: &[AxisSpectrum]) -> Vec<Shaking> {
    let of = |AxisSpectrum { sensor, axis, spectrum }: &AxisSpectrum| {
        let (sensor, axis, nyquist) = (*sensor, *axis, nyquist(spectrum));
        let one = move |Band { peak, power, share }: Band| Shaking {
            sensor,
            axis,
            hz: peak.hz,
            rms: power.sqrt(),
            share,
            density: peak.density,
            nyquist,
        };
        bands(spectrum).into_iter().map(one)
    };
    spectra.iter().flat_map(of).collect()
}

/// All that shakes, in one.
pub(super) fn finding(spectra: &[AxisSpectrum]) -> Option<Finding> {
    let all = shaking(spectra);
    let half = all.first()?.nyquist;
    let (folded, seen): (Vec<Shaking>, Vec<Shaking>) = all.into_iter().partition(|s| s.hz > 0.8 * half);
    let words = |of: &[Shaking]| {
        let one = |Shaking { sensor, axis, hz, rms, share, .. }: &Shaking| {
            let (axis, unit) = (["x", "y", "z"][*axis], sensor.unit());
            format!("{sensor} {axis} at {hz:.1} Hz ({rms:.3} {unit} rms, {:.0} %)", 100.0 * share)
        };
        of.iter().map(one).collect::<Vec<_>>().join(", ")
    };
    let folded_words = format!(
        "so near to half the rate ({half:.0} Hz) that a higher frequency is probably folded back: {}",
        words(&folded)
    );
    let (text, remedy) = match (seen.is_empty(), folded.is_empty()) {
        (true, _) => (
            folded_words,
            "mount the IMU softer, or switch on its low-pass filter; what is folded back cannot be filtered afterwards",
        ),
        (_, true) => (
            words(&seen),
            "mount the IMU softer or balance what turns; until then tell the estimator a larger noise",
        ),
        _ => (
            format!("{}; {folded_words}", words(&seen)),
            "mount the IMU softer or balance what turns, and switch on its low-pass filter: what is folded back cannot be filtered afterwards; until then tell the estimator a larger noise",
        ),
    };
    let text = format!("bands with a share of an axis' power above {LEAST_HZ:.0} Hz: {text}");
    Some(Finding::warning("vibration", text, remedy))
}

/// A band that stands out.
#[derive(Debug, Clone, Copy)]
struct Band {
    peak: Peak,
    power: f64,
    share: f64,
}

fn nyquist(spectrum: &Spectrum) -> f64 {
    spectrum.bin_hz() * (spectrum.density().len() - 1) as f64
}

/// The bands that stand out of what lies on both sides of them, the strongest first; none where nothing shakes.
fn bands(spectrum: &Spectrum) -> Vec<Band> {
    let (bin, nyquist) = (spectrum.bin_hz(), nyquist(spectrum));
    let smooth = smoothed(spectrum.density(), (0.5 * WIDTH_HZ / bin).round() as usize);
    let at = |hz: f64| ((hz / bin).round() as usize).min(smooth.len());
    let within = |low: f64, high: f64| &smooth[at(low).min(at(high))..at(high)];
    let total = spectrum.band_power(LEAST_HZ, nyquist).max(f64::MIN_POSITIVE);
    let mut found: Vec<Band> = Vec::new();
    for (i, density) in smooth.iter().enumerate().skip(at(LEAST_HZ)) {
        let hz = i as f64 * bin;
        let width = WIDTH_HZ.max(0.06 * hz);
        let is_top = within(hz - width, hz + width + bin).iter().all(|near| near <= density);
        let sides = [within(LEAST_HZ.max(0.6 * hz), 0.8 * hz), within(1.25 * hz, 1.6 * hz)];
        let sides: Vec<&&[f64]> = sides.iter().filter(|side| side.len() >= 3).collect();
        if !is_top || sides.is_empty() || sides.iter().any(|side| *density <= BESIDE * stats::median(side)) {
            continue;
        }
        let (low, high) = ((hz - width).max(LEAST_HZ), (hz + width).min(nyquist));
        let power = spectrum.band_power(low, high);
        let Some(peak) = spectrum.peak(low, high).filter(|_| power >= SHARE * total) else { continue };
        found.push(Band { peak, power, share: power / total });
    }
    found.sort_by(|a, b| b.power.total_cmp(&a.power));
    found.truncate(MOST);
    found
}

/// Means over a bin and `half` on either side.
fn smoothed(density: &[f64], half: usize) -> Vec<f64> {
    (0..density.len())
        .map(|i| stats::mean(&density[i.saturating_sub(half)..(i + half + 1).min(density.len())]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::values::tests::level;
    use dpn_core::ImuRecording;

    #[test]
    fn a_shaking_axis_is_named_with_frequency_and_strength() {
        let mut samples = level(60);
        let found = |samples: Vec<_>| finding(&spectra(&ImuRecording::new(samples).unwrap()).unwrap());
        assert_eq!(found(samples.clone()), None);
        for s in &mut samples {
            let t = s.t.ns() as f64 * 1e-9;
            s.accel[0] += (2.0 * std::f64::consts::PI * 43.2 * t).sin();
            // 110.5 Hz, seen at 89.5.
            s.gyro[1] += 0.1 * (2.0 * std::f64::consts::PI * 110.5 * t).sin();
        }
        let Finding { text, remedy, .. } = found(samples).unwrap();
        assert!(text.contains("8 Hz: accel x at 43.2 Hz (0.7"), "{text}");
        assert!(text.contains("; so near to half the rate (100 Hz) that a higher frequency is probably folded back: gyro y at 89.5 Hz (0.07"), "{text}");
        assert!(
            remedy.unwrap().contains("balance what turns, and switch on its low-pass filter"),
            "{remedy:?}"
        );
    }

    /// Bands of the sequences that networks were trained on; the thresholds were set on them. The others are in docs/src/your-log.md as found.
    #[test]
    fn rotors_are_found_on_recorded_flights_and_nothing_where_nothing_turns() {
        use dpn_logs::{LogOptions, read_log};
        let Some([euroc, tumvi]) = dpn_testing::packs(["euroc", "tumvi"]) else { return };
        let of = |path: std::path::PathBuf| {
            let spectra = spectra(&read_log(&path, &LogOptions::default()).unwrap().recording).unwrap();
            let bands = |s: &AxisSpectrum| bands(&s.spectrum).into_iter().map(|b| b.peak.hz).collect();
            spectra.iter().map(|s| (s.sensor, s.axis, bands(s))).collect::<Vec<(Sensor, usize, Vec<f64>)>>()
        };
        for name in
            ["MH_01_easy", "MH_03_medium", "MH_05_difficult", "V1_02_medium", "V2_01_easy", "V2_03_difficult"]
        {
            let axes = of(euroc.join(name));
            let has = |sensor: Sensor, axis: usize, low: f64, high: f64| {
                axes.iter().any(|(s, a, all)| {
                    (*s, *a) == (sensor, axis) && all.iter().any(|hz| (low..high).contains(hz))
                })
            };
            assert!(has(Sensor::Accel, 0, 85.0, 100.0), "{name}: {axes:?}");
            assert!(has(Sensor::Accel, 2, 85.0, 100.0), "{name}: {axes:?}");
            assert!(has(Sensor::Gyro, 1, 85.0, 100.0), "{name}: {axes:?}");
            assert!(has(Sensor::Accel, 1, 26.0, 29.0), "{name}: {axes:?}");
            assert!(has(Sensor::Gyro, 0, 25.0, 29.0), "{name}: {axes:?}");
        }
        for name in ["room1", "room2"] {
            let axes = of(tumvi.join(format!("dataset-{name}_512_16")));
            assert!(axes.iter().all(|(_, _, all)| all.is_empty()), "{name}: {axes:?}");
        }
    }
}
