//! Windows of one axis, cut from recordings and cleaned.
//!
//! A window is a number of consecutive samples of one axis, [`WINDOW`] at the paper's rate. Evaluation and validation use disjoint windows; training may
//! shift each by a random offset. The base is filtered after cutting: a Savitzky-Golay filter's polynomial
//! edges are the window's, a Gaussian's width changes from window to window.

use crate::base::Base;
use crate::clean::Cleaner;
use crate::flight::FlightNoise;
use crate::own::OwnNoise;
pub use crate::window::WINDOW;
use dpn_core::check::{CheckOptions, gaps};
use dpn_core::signal::FilterError;
use dpn_core::{ImuRecording, Sensor};

/// Share of every training sequence, at its end, kept for validation (decision 13).
pub const VALIDATION_SHARE: f64 = 0.15;

/// One axis of one sequence.
#[derive(Debug, Clone)]
struct Axis {
    sequence: usize,
    axis: usize,
    samples: Vec<f64>,
}

/// Where a window lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WindowPlace {
    signal: usize,
    start: usize,
    /// Samples that may be skipped at the front without leaving the stretch this window may use.
    slack: usize,
}

/// Which stretch of the training sequences a set is cut from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stretch {
    /// The whole sequence.
    Whole,
    /// The first part, less a window's gap before the validation part.
    Fit,
    /// The last [`VALIDATION_SHARE`].
    Validation,
}

/// Disjoint windows of all three axes of one sensor over several sequences, and the base they are taken on.
#[derive(Debug, Clone)]
pub struct WindowSet {
    names: Vec<String>,
    signals: Vec<Axis>,
    places: Vec<WindowPlace>,
    cleaner: Cleaner,
    own: OwnNoise,
    flight: Option<FlightNoise>,
    window: usize,
    /// Windows left out because a gap in the stamps crosses them.
    pub skipped_for_gaps: usize,
}

impl WindowSet {
    /// Cuts `recordings` (name, recording) into disjoint windows of `window` samples.
    ///
    /// A stretch between two samples that are more than 1.5 periods apart is a gap; no window crosses one.
    ///
    /// # Errors
    /// A filter that cannot be.
    pub fn cut(
        recordings: &[(&str, &ImuRecording)],
        sensor: Sensor,
        base: Base,
        stretch: Stretch,
        window: usize,
    ) -> Result<Self, FilterError> {
        let mut set = Self {
            names: Vec::new(),
            signals: Vec::new(),
            places: Vec::new(),
            cleaner: base.cleaner(window)?,
            own: OwnNoise::new(window)?,
            flight: None,
            window,
            skipped_for_gaps: 0,
        };
        for (index, (name, recording)) in recordings.iter().enumerate() {
            set.names.push((*name).to_owned());
            let (first, end) = bounds(recording.len(), stretch, window);
            let runs = unbroken_runs(recording, first, end);
            set.skipped_for_gaps += 3
                * (end.saturating_sub(first) / window)
                    .saturating_sub(runs.iter().map(|(a, b)| (b - a) / window).sum());
            for axis in 0..3 {
                let signal = set.signals.len();
                for &(run_start, run_end) in &runs {
                    let mut start = run_start;
                    while start + window <= run_end {
                        let slack = (run_end - window - start).min(window - 1);
                        set.places.push(WindowPlace { signal, start, slack });
                        start += window;
                    }
                }
                set.signals.push(Axis { sequence: index, axis, samples: recording.axis(sensor, axis) });
            }
        }
        Ok(set)
    }

    /// Samples in a window.
    pub fn window(&self) -> usize {
        self.window
    }

    /// Number of windows, all axes counted.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether there is no window at all.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Name of the sequence window `index` comes from.
    pub fn sequence(&self, index: usize) -> &str {
        &self.names[self.signals[self.places[index].signal].sequence]
    }

    /// Names of all sequences.
    pub(crate) fn sequences(&self) -> &[String] {
        &self.names
    }

    /// Place of the sequence that window `index` comes from among these.
    pub(crate) fn sequence_number(&self, index: usize) -> usize {
        self.signals[self.places[index].signal].sequence
    }

    /// Axis (0, 1, 2) window `index` comes from.
    pub fn axis(&self, index: usize) -> usize {
        self.signals[self.places[index].signal].axis
    }

    /// How far window `index` may be shifted to later samples.
    pub fn slack(&self, index: usize) -> usize {
        self.places[index].slack
    }

    /// Writes the base of window `index`, shifted by `offset` samples, into `out`.
    ///
    /// # Shapes
    /// `out`: a window's samples.
    ///
    /// # Panics
    /// When `offset` is beyond [`slack`](Self::slack) or `out` has another length.
    pub(crate) fn base_into(&self, index: usize, offset: usize, out: &mut [f64]) {
        self.cleaner.clean(index, self.raw(index, offset), out);
    }

    /// The recorded samples of window `index`, shifted by `offset` samples.
    ///
    /// # Panics
    /// When `offset` is beyond [`slack`](Self::slack).
    pub fn raw(&self, index: usize, offset: usize) -> &[f64] {
        let place = self.places[index];
        assert!(
            offset <= place.slack,
            "window {index} may be shifted by {} samples, not {offset}",
            place.slack
        );
        let start = place.start + offset;
        &self.signals[place.signal].samples[start..start + self.window]
    }

    /// All axes, one behind the other, and every window's first sample among these with its slack.
    #[cfg(feature = "wgpu")]
    pub(crate) fn recorded(&self) -> (Vec<f32>, Vec<[u32; 2]>) {
        let mut first = vec![0];
        for signal in &self.signals {
            first.push(first[first.len() - 1] + signal.samples.len());
        }
        let samples =
            self.signals.iter().flat_map(|signal| signal.samples.iter().map(|v| *v as f32)).collect();
        let places =
            self.places.iter().map(|place| [(first[place.signal] + place.start) as u32, place.slack as u32]);
        (samples, places.collect())
    }

    /// What cleans windows, which take these in turn: matrices of `[window, window]`, row by row.
    #[cfg(feature = "wgpu")]
    pub(crate) fn filters(&self) -> Vec<Vec<f64>> {
        self.cleaner.matrices(self.window)
    }

    /// The white noise that a window of this length holds before anything is injected.
    pub(crate) fn own_sigma(&self, window: &[f64]) -> f64 {
        self.own.sigma(window)
    }

    /// The same windows, whose own noise is known.
    pub(crate) fn with_flight_noise(self, flight: Option<FlightNoise>) -> Self {
        Self { flight, ..self }
    }

    /// What `window`, window `index` as it was recorded or louder, holds of the noise that sums feel; 0 where nobody knows.
    pub(crate) fn flight_sigma(&self, index: usize, window: &[f64]) -> f64 {
        self.flight.as_ref().map_or(0.0, |flight| flight.sigma(self.sequence_number(index), window))
    }
}

/// First sample and end of a stretch of a sequence of `len` samples.
fn bounds(len: usize, stretch: Stretch, window: usize) -> (usize, usize) {
    let cut = (len as f64 * (1.0 - VALIDATION_SHARE)).round() as usize;
    match stretch {
        Stretch::Whole => (0, len),
        Stretch::Fit => (0, cut.saturating_sub(window)),
        Stretch::Validation => (cut, len),
    }
}

/// Maximal runs of samples in `[first, end)` without a gap in their stamps.
fn unbroken_runs(recording: &ImuRecording, first: usize, end: usize) -> Vec<(usize, usize)> {
    let limit = CheckOptions::default().gap_periods * recording.rate().period();
    let breaks = gaps(recording, limit).into_iter().map(|gap| gap.index + 1);
    let mut start = first;
    let mut runs = Vec::new();
    for end in breaks.filter(|at| (first + 1..end).contains(at)).chain([end]) {
        if end > start {
            runs.push((start, end));
        }
        start = end;
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::{ImuSample, Stamp};

    fn ramp(len: usize, gap_before: Option<usize>) -> ImuRecording {
        let mut t = 0;
        let samples = (0..len)
            .map(|i| {
                t += if Some(i) == gap_before { 50_000_000 } else { 5_000_000 };
                ImuSample {
                    t: Stamp::from_ns(t),
                    gyro: [0.0; 3],
                    accel: [i as f64, 2.0 * i as f64, -(i as f64)],
                }
            })
            .collect();
        ImuRecording::new(samples).unwrap()
    }

    fn cut(recording: &ImuRecording, base: Base, stretch: Stretch) -> WindowSet {
        WindowSet::cut(&[("a", recording)], Sensor::Accel, base, stretch, WINDOW).unwrap()
    }

    #[test]
    fn windows_are_disjoint_and_cover_all_axes() {
        let set = cut(&ramp(1050, None), Base::Raw, Stretch::Whole);
        assert_eq!(set.len(), 15);
        assert_eq!(set.raw(1, 0)[0], 200.0);
        assert_eq!(set.raw(5, 0)[1], 2.0);
        assert_eq!((set.axis(5), set.sequence(5)), (1, "a"));
        assert_eq!(set.slack(0), 199);
        assert_eq!(set.slack(4), 50);
    }

    #[test]
    fn no_window_crosses_a_gap() {
        let set = cut(&ramp(1000, Some(450)), Base::Raw, Stretch::Whole);
        // 450 and 550 samples: two windows each instead of five in a row.
        assert_eq!(set.len(), 12);
        assert_eq!(set.skipped_for_gaps, 3);
        for i in 0..set.len() {
            let window = set.raw(i, set.slack(i));
            let (a, b) = (window[0].abs(), window[WINDOW - 1].abs());
            let scale = if set.axis(i) == 1 { 2.0 } else { 1.0 };
            assert!(b / scale < 450.0 || a / scale >= 450.0);
        }
    }

    #[test]
    fn fit_and_validation_leave_a_window_between_them() {
        let recording = ramp(4000, None);
        let fit = cut(&recording, Base::Raw, Stretch::Fit);
        let validation = cut(&recording, Base::Raw, Stretch::Validation);
        let last_fit =
            (0..fit.len()).map(|i| fit.raw(i, fit.slack(i))[WINDOW - 1].abs() as usize).max().unwrap() / 2;
        assert!(last_fit + WINDOW < 3400 + 1);
        assert_eq!(validation.raw(0, 0)[0], 3400.0);
    }

    #[test]
    fn no_base_is_left_uncleaned() {
        let mut samples = ramp(400, None).samples().to_vec();
        for (i, sample) in samples.iter_mut().enumerate() {
            sample.accel[0] = if i % 2 == 0 { 1.0 } else { -1.0 };
        }
        let recording = ImuRecording::new(samples).unwrap();
        for base in [Base::Gaussian, Base::SavitzkyGolay { window: 51, order: 3 }] {
            let mut out = vec![0.0; WINDOW];
            cut(&recording, base, Stretch::Whole).base_into(0, 0, &mut out);
            assert!(out[60..140].iter().all(|v| v.abs() < 0.2), "{base}");
        }
    }

    #[test]
    fn a_filter_longer_than_a_window_is_refused() {
        let base = Base::SavitzkyGolay { window: 301, order: 2 };
        let recording = ramp(1000, None);
        let cut = WindowSet::cut(&[("a", &recording)], Sensor::Accel, base, Stretch::Whole, WINDOW);
        assert_eq!(cut.unwrap_err(), FilterError::SignalTooShort { len: WINDOW, window: 301 });
    }

    #[test]
    fn a_quadratic_passes_the_filtered_base_unchanged() {
        let set = cut(&ramp(400, None), Base::SavitzkyGolay { window: 51, order: 3 }, Stretch::Whole);
        let mut base = vec![0.0; WINDOW];
        set.base_into(1, 0, &mut base);
        for (filtered, raw) in base.iter().zip(set.raw(1, 0)) {
            assert!((filtered - raw).abs() < 1e-9 * 400.0);
        }
    }
}
