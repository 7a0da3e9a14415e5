//! What takes the noise out of a window before known noise is put in.

use dpn_core::signal::SavitzkyGolay;

/// Deviations of the Gaussian kernels a window may be smoothed with \[samples\].
pub const GAUSSIAN_WIDTHS: [f64; 4] = [1.5, 2.0, 3.0, 4.5];

/// A filter for one window.
#[derive(Debug, Clone)]
pub(crate) enum Cleaner {
    /// Leaves the window as it is.
    Nothing,
    /// Savitzky-Golay with polynomial edges.
    SavitzkyGolay(SavitzkyGolay),
    /// Gaussian smoothing; a window's index chooses among the kernels (each from its centre outwards).
    Gaussian(Vec<Vec<f64>>),
}

impl Cleaner {
    /// The kernels of [`GAUSSIAN_WIDTHS`], cut at six deviations.
    pub(crate) fn gaussian() -> Self {
        let kernel = |width: &f64| {
            let reach = (6.0 * width).ceil() as usize;
            let mut kernel: Vec<f64> =
                (0..=reach).map(|k| (-0.5 * (k as f64 / width).powi(2)).exp()).collect();
            let sum = kernel[0] + 2.0 * kernel[1..].iter().sum::<f64>();
            kernel.iter_mut().for_each(|weight| *weight /= sum);
            kernel
        };
        Self::Gaussian(GAUSSIAN_WIDTHS.iter().map(kernel).collect())
    }

    /// Writes window `index`, cleaned, into `out`.
    ///
    /// # Shapes
    /// `raw` and `out`: a window's samples.
    pub(crate) fn clean(&self, index: usize, raw: &[f64], out: &mut [f64]) {
        match self {
            Self::Nothing => out.copy_from_slice(raw),
            Self::SavitzkyGolay(filter) => {
                filter.smooth_into(raw, out).expect("`Base::cleaner` makes no filter longer than a window");
            }
            Self::Gaussian(kernels) => smooth(&kernels[index % kernels.len()], raw, out),
        }
    }
}

#[cfg(feature = "wgpu")]
impl Cleaner {
    /// The matrices that windows of `len` samples are multiplied by, row by row: a window's index chooses among them in turn.
    pub(crate) fn matrices(&self, len: usize) -> Vec<Vec<f64>> {
        let kinds = if let Self::Gaussian(kernels) = self { kernels.len() } else { 1 };
        let matrix = |kind| {
            let (mut unit, mut column, mut rows) = (vec![0.0; len], vec![0.0; len], vec![0.0; len * len]);
            for at in 0..len {
                unit[at] = 1.0;
                self.clean(kind, &unit, &mut column);
                unit[at] = 0.0;
                for (row, value) in rows.chunks_exact_mut(len).zip(&column) {
                    row[at] = *value;
                }
            }
            rows
        };
        (0..kinds).map(matrix).collect()
    }
}

/// Convolves with a symmetric kernel; beyond its ends the window is turned about its end points.
fn smooth(kernel: &[f64], raw: &[f64], out: &mut [f64]) {
    let last = raw.len() as i64 - 1;
    let at = |i: i64| -> f64 {
        if i < 0 {
            2.0 * raw[0] - raw[(-i).min(last) as usize]
        } else if i > last {
            2.0 * raw[last as usize] - raw[(2 * last - i).max(0) as usize]
        } else {
            raw[i as usize]
        }
    };
    for (i, value) in out.iter_mut().enumerate() {
        let i = i as i64;
        let wings = kernel.iter().enumerate().skip(1);
        *value =
            kernel[0] * at(i) + wings.map(|(k, w)| w * (at(i - k as i64) + at(i + k as i64))).sum::<f64>();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::window::WINDOW;

    #[test]
    fn a_line_passes_gaussian_smoothing_and_white_noise_does_not() {
        let line: Vec<f64> = (0..WINDOW).map(|i| 9.81 + 0.01 * i as f64).collect();
        let alternating: Vec<f64> = (0..WINDOW).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let mut out = vec![0.0; WINDOW];
        for index in 0..GAUSSIAN_WIDTHS.len() {
            Cleaner::gaussian().clean(index, &line, &mut out);
            assert!(line.iter().zip(&out).all(|(a, b)| (a - b).abs() < 1e-9), "width {index}");
            Cleaner::gaussian().clean(index, &alternating, &mut out);
            assert!(out[40..160].iter().all(|v| v.abs() < 5e-5), "width {index}");
        }
    }
}
