//! Spectral peaks: what shakes, and what may be a higher frequency folded back.

use super::Finding;
use dpn_core::signal::spectrum::{Peak, Spectrum, Welch};
use dpn_core::signal::stats;
use dpn_core::{ImuRecording, Sensor};

/// A peak stands this many times above the middle density of its axis; of white noise over four segments none does by chance.
const ABOVE: f64 = 8.0;
/// And this many times above what lies beside it, which motion, falling off with frequency, does not.
const BESIDE: f64 = 3.0;
/// Frequencies below belong to motion \[Hz\].
const LEAST_HZ: f64 = 8.0;
/// Length of a segment \[s\].
const SEGMENT_S: f64 = 2.0;

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
pub fn spectra(recording: &ImuRecording) -> Vec<AxisSpectrum> {
    let rate = recording.rate();
    let segment = ((rate.hz() * SEGMENT_S) as usize).max(16);
    let Some(welch) = Welch::new(segment).ok().filter(|_| recording.len() >= 4 * segment) else {
        return Vec::new();
    };
    let all = Sensor::ALL.into_iter().flat_map(|sensor| (0..3).map(move |axis| (sensor, axis)));
    all.filter_map(|(sensor, axis)| {
        let spectrum = welch.spectrum(&recording.axis(sensor, axis), rate).ok()?;
        Some(AxisSpectrum { sensor, axis, spectrum })
    })
    .collect()
}

pub(super) fn findings(spectra: &[AxisSpectrum]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for AxisSpectrum { sensor, axis, spectrum } in spectra {
        let nyquist = spectrum.bin_hz() * (spectrum.density().len() - 1) as f64;
        let Some(peak) = peak(spectrum, nyquist) else { continue };
        let width = (4.0 * spectrum.bin_hz()).max(0.06 * peak.hz);
        let band = spectrum.band_power((peak.hz - width).max(LEAST_HZ), (peak.hz + width).min(nyquist));
        let share = band / spectrum.band_power(LEAST_HZ, nyquist).max(f64::MIN_POSITIVE);
        let name = ["x", "y", "z"][*axis];
        let text = format!(
            "{sensor} {name} shakes at {:.1} Hz: {:.3} {} rms, {:.0} % of its power above {LEAST_HZ:.0} Hz",
            peak.hz,
            band.sqrt(),
            sensor.unit(),
            100.0 * share
        );
        findings.push(if peak.hz > 0.8 * nyquist {
            Finding::warning(
                "vibration",
                format!("{text}; this near to half the rate ({nyquist:.0} Hz) it is probably a higher frequency folded back"),
                "mount the IMU softer, or switch on its low-pass filter; what is folded back cannot be filtered afterwards",
            )
        } else {
            Finding::warning(
                "vibration",
                text,
                "mount the IMU softer or balance what turns; until then tell the estimator a larger noise",
            )
        });
    }
    findings
}

/// The highest peak that stands out of its axis and of what lies on both sides of it; none where nothing shakes.
fn peak(spectrum: &Spectrum, nyquist: f64) -> Option<Peak> {
    let within = |low: f64, high: f64| -> Vec<f64> {
        let bins = spectrum.frequencies().zip(spectrum.density());
        bins.filter(|(hz, _)| (low..=high).contains(hz)).map(|(_, density)| *density).collect()
    };
    let floor = ABOVE * stats::median(&within(LEAST_HZ, nyquist));
    let stands = |hz: f64, density: f64| {
        let sides = [within(0.6 * hz, 0.8 * hz), within(1.25 * hz, 1.6 * hz)];
        density > floor && sides.iter().all(|side| side.len() < 3 || density > BESIDE * stats::median(side))
    };
    let bins = spectrum.frequencies().zip(spectrum.density());
    let mut high: Vec<(f64, f64)> =
        bins.map(|(hz, density)| (hz, *density)).filter(|(hz, _)| *hz >= LEAST_HZ).collect();
    high.sort_by(|a, b| b.1.total_cmp(&a.1));
    let (hz, _) = high.into_iter().find(|(hz, density)| stands(*hz, *density))?;
    // Between the bins.
    spectrum.peak(hz - 1.5 * spectrum.bin_hz(), hz + 1.5 * spectrum.bin_hz())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::values::tests::level;

    #[test]
    fn a_shaking_axis_is_named_with_frequency_and_strength() {
        let mut samples = level(60);
        assert!(findings(&spectra(&ImuRecording::new(samples.clone()).unwrap())).is_empty());
        for s in &mut samples {
            let t = s.t.ns() as f64 * 1e-9;
            s.accel[0] += (2.0 * std::f64::consts::PI * 43.2 * t).sin();
            // 110.5 Hz, seen at 89.5.
            s.gyro[1] += 0.1 * (2.0 * std::f64::consts::PI * 110.5 * t).sin();
        }
        let found = findings(&spectra(&ImuRecording::new(samples).unwrap()));
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].text.starts_with("accel x shakes at 43.2 Hz: 0.7"), "{found:?}");
        assert!(
            found[1].text.starts_with("gyro y shakes at 89.5 Hz: 0.07")
                && found[1].text.contains("folded back"),
            "{found:?}"
        );
    }
}
