//! A gyroscope's matrix and bias against true turns, by robust least squares: `rate = matrix * reading + bias`.
//!
//! Over spans of samples the readings' product of increments is held against the true turn, `r = Log(turn^-1 prod Exp(rate_i dt_i))`, with the reading in the middle of each step. Gauss-Newton, a residual
//! beyond twice its recording's median one pulls as if it were there (Huber). Deviations are a jackknife's over recordings, over parts of them where there are few: residuals are not
//! independent, for a bias lasts.

use crate::course::Course;
use dpn_core::geometry::so3;
use dpn_core::signal::stats::{Ddof, deviation, median, median_of};
use nalgebra::{Matrix3, SMatrix, SVector, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// Samples to a span.
const SPAN: usize = 32;
/// A residual beyond so many medians pulls less.
const HUBER: f64 = 2.0;
/// Steps; the model is nearly linear.
const STEPS: usize = 6;
/// Bias and matrix.
const UNKNOWNS: usize = 12;
/// The fewest groups of a jackknife.
const LEAST_GROUPS: usize = 8;
/// A free number's information beforehand, against singular equations where a body hardly turns: deviation 1.
const PRIOR: f64 = 1.0;
/// The same of one that is held.
const HELD: f64 = 1e12;
/// Deviation of a recording's bias where there is no other to tell \[rad/s\].
pub(crate) const UNKNOWN_SPREAD: f64 = 1e-3;

/// What takes a reading to a rate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(into = "Numbers", from = "Numbers")]
pub struct Affine {
    /// `matrix * reading + bias` is the rate.
    pub matrix: Matrix3<f64>,
    /// \[rad/s\].
    pub bias: Vector3<f64>,
}

/// As it is written: rows of the matrix.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Numbers {
    matrix: [[f64; 3]; 3],
    bias: [f64; 3],
}

impl From<Affine> for Numbers {
    fn from(of: Affine) -> Self {
        Self { matrix: of.matrix.transpose().data.0, bias: of.bias.into() }
    }
}

impl From<Numbers> for Affine {
    fn from(of: Numbers) -> Self {
        Self { matrix: Matrix3::from_fn(|row, column| of.matrix[row][column]), bias: of.bias.into() }
    }
}

impl Affine {
    /// Readings as they are.
    pub fn none() -> Self {
        Self { matrix: Matrix3::identity(), bias: Vector3::zeros() }
    }

    /// The rate.
    pub fn apply(&self, reading: &Vector3<f64>) -> Vector3<f64> {
        self.matrix * reading + self.bias
    }
}

/// An affine calibration and how well it is known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Fitted {
    /// The calibration.
    pub affine: Affine,
    /// Deviations of its numbers.
    pub std: Affine,
    /// The median residual over a span \[rad\].
    pub residual: f64,
    /// How far recordings' own biases lie apart, each with this matrix, a deviation by axis \[rad/s\]; 1 mrad/s where there is one recording.
    pub spread: [f64; 3],
    /// Spans that were held against true turns.
    pub spans: usize,
}

/// Which numbers are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unknown {
    /// Matrix and bias.
    All,
    /// The bias alone.
    Bias,
}

/// Fits one calibration to all of `courses`; none where they have no span with a truth.
pub fn fit(courses: &[&Course], unknown: Unknown) -> Option<Fitted> {
    let spans = |course: &Course| (0..(course.len() - 1) / SPAN).map(|s| s * SPAN).collect::<Vec<_>>();
    // Group of the jackknife, course, first sample, true turn.
    let parts = LEAST_GROUPS.div_ceil(courses.len().max(1));
    let mut rows = Vec::new();
    for (c, course) in courses.iter().enumerate() {
        let starts = spans(course);
        for (i, &from) in starts.iter().enumerate() {
            let group = c * parts + i * parts / starts.len();
            rows.extend(course.turn(from, from + SPAN).map(|turn| (group, *course, from, turn)));
        }
    }
    if rows.is_empty() {
        return None;
    }
    let held: SVector<f64, UNKNOWNS> = SVector::from_fn(|i, _| match unknown {
        Unknown::Bias if i >= 3 => HELD,
        _ => PRIOR,
    });
    let mut affine = Affine::none();
    let mut out = None;
    for _ in 0..STEPS {
        let terms: Vec<_> =
            rows.iter().map(|(_, course, from, turn)| term(&affine, course, *from, turn)).collect();
        let sizes: Vec<f64> = terms.iter().map(|(r, _)| r.norm()).collect();
        let typical = median(&sizes);
        // Whatever a recording's noise is: its bias is another one, which is more.
        let of_course: Vec<f64> = (0..courses.len())
            .map(|c| {
                let of = rows.iter().zip(&sizes).filter(|(row, _)| row.0 / parts == c);
                median_of(of.map(|(_, size)| *size)).unwrap_or(typical)
            })
            .collect();
        let mut groups = vec![
            (SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros(), SVector::<f64, UNKNOWNS>::zeros());
            courses.len() * parts
        ];
        for (((group, ..), (r, by)), size) in rows.iter().zip(&terms).zip(&sizes) {
            let weight = pull(*size, of_course[group / parts]) / typical.powi(2).max(f64::MIN_POSITIVE);
            groups[*group].0 += weight * by.transpose() * by;
            groups[*group].1 += weight * by.transpose() * r;
        }
        let prior = SMatrix::from_diagonal(&held);
        let sum = groups.iter().fold((prior, SVector::zeros()), |(h, g), (a, b)| (h + a, g + b));
        let solve = |h: SMatrix<f64, UNKNOWNS, UNKNOWNS>,
                     g: SVector<f64, UNKNOWNS>|
         -> Option<SVector<f64, UNKNOWNS>> { Some(-h.cholesky()?.solve(&g)) };
        let step = solve(sum.0, sum.1)?;
        let used: Vec<_> = groups.iter().filter(|(h, _)| h[(0, 0)] > 0.0).collect();
        let without = used.iter().map(|(h, g)| solve(sum.0 - h, sum.1 - g)).collect::<Option<Vec<_>>>()?;
        let n = without.len() as f64;
        let mean = without.iter().sum::<SVector<f64, UNKNOWNS>>() / n;
        let spread =
            without.iter().map(|w| (w - mean).component_mul(&(w - mean))).sum::<SVector<f64, UNKNOWNS>>();
        let std = (spread * ((n - 1.0) / n)).map(f64::sqrt);
        affine =
            Affine { matrix: affine.matrix + matrix(&step), bias: affine.bias + step.fixed_rows::<3>(0) };
        let std = Affine { matrix: matrix(&std), bias: std.fixed_rows::<3>(0).into() };
        let spread = of_recordings(&groups, parts);
        out = Some(Fitted { affine, std, residual: typical, spread, spans: rows.len() });
    }
    out
}

/// A group's normal equations.
type Group = (SMatrix<f64, UNKNOWNS, UNKNOWNS>, SVector<f64, UNKNOWNS>);

/// Deviation of the recordings' own biases, each recording `parts` groups.
fn of_recordings(groups: &[Group], parts: usize) -> [f64; 3] {
    let own = |of: &[Group]| {
        let (h, g) =
            of.iter().fold((SMatrix::zeros(), SVector::zeros()), |(h, g), (a, b): &Group| (h + a, g + b));
        Some(h.fixed_view::<3, 3>(0, 0).cholesky()?.solve(&g.fixed_rows::<3>(0)))
    };
    let own: Vec<Vector3<f64>> = groups.chunks(parts).filter_map(own).collect();
    if own.len() < 2 {
        return [UNKNOWN_SPREAD; 3];
    }
    std::array::from_fn(|axis| deviation(&own.iter().map(|bias| bias[axis]).collect::<Vec<_>>(), Ddof::One))
}

/// What a residual of that size weighs, by the median one (Huber).
pub(crate) fn pull(size: f64, median: f64) -> f64 {
    (HUBER * median / size).min(1.0)
}

/// Of an unknown vector: bias, then the matrix column by column.
fn matrix(of: &SVector<f64, UNKNOWNS>) -> Matrix3<f64> {
    Matrix3::from_column_slice(&of.as_slice()[3..])
}

/// Residual of the span from `from` on and its derivatives.
fn term(
    affine: &Affine,
    course: &Course,
    from: usize,
    turn: &UnitQuaternion<f64>,
) -> (Vector3<f64>, SMatrix<f64, 3, UNKNOWNS>) {
    let mut product = UnitQuaternion::identity();
    let mut by = SMatrix::<f64, 3, UNKNOWNS>::zeros();
    for i in from..from + SPAN {
        let (reading, step) = (course.middle(i), course.step_s[i]);
        let angle = affine.apply(&reading) * step;
        let increment = so3::exp(&angle);
        let back = increment.inverse().to_rotation_matrix();
        by = back.matrix() * by;
        let here = so3::right_jacobian(&angle) * step;
        for (column, factor) in [1.0, reading.x, reading.y, reading.z].into_iter().enumerate() {
            let mut block = by.fixed_columns_mut::<3>(3 * column);
            block += factor * here;
        }
        product *= increment;
    }
    let r = so3::log(&(turn.inverse() * product));
    (r, so3::right_jacobian_inverse(&r) * by)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::course::simulated;

    #[test]
    fn matrix_and_bias_come_back_within_their_deviations_and_outliers_do_not_move_them() {
        let read_by = Matrix3::new(1.03, 0.01, -0.004, 0.002, 0.97, 0.012, -0.006, 0.003, 1.01);
        let bias = Vector3::new(0.02, -0.01, 0.005);
        let mut course = simulated(60.0, read_by, bias, 0.005);
        // A truth that is off by half a radian for three seconds.
        for pose in course.truth[4000..4600].iter_mut().flatten() {
            pose.rotation *= so3::exp(&Vector3::new(0.5, 0.0, 0.0));
        }
        let found = fit(&[&course], Unknown::All).unwrap();
        let matrix = read_by.try_inverse().unwrap();
        let off = (found.affine.matrix - matrix, found.affine.bias + matrix * bias);
        assert!(off.0.norm() < 3e-3 && off.1.norm() < 5e-4, "{off:?}");
        let worst = off.0.component_div(&found.std.matrix).abs().max();
        assert!(worst < 5.0, "{worst} deviations, {found:?}");
        let alone = fit(&[&course], Unknown::Bias).unwrap();
        assert!((alone.affine.matrix - Matrix3::identity()).norm() < 1e-6);
    }

    #[test]
    fn the_derivatives_are_those_of_the_residual() {
        let course = simulated(1.0, Matrix3::identity(), Vector3::zeros(), 0.1);
        let turn = so3::exp(&Vector3::new(0.1, 0.05, -0.2));
        let at = Affine { matrix: Matrix3::identity() * 1.1, bias: Vector3::new(0.1, 0.2, -0.1) };
        let (_, by) = term(&at, &course, 3, &turn);
        dpn_testing::check_jacobian("affine", &by, 1e-6, |d| {
            let d = SVector::<f64, UNKNOWNS>::from_column_slice(d.as_slice());
            let moved = Affine { matrix: at.matrix + matrix(&d), bias: at.bias + d.fixed_rows::<3>(0) };
            nalgebra::DVector::from_column_slice(term(&moved, &course, 3, &turn).0.as_slice())
        });
    }
}
