//! Matrices of rank two through seven pairs.

use nalgebra::Matrix3;

/// A pivot below this share of 1 says that the seven pairs are not independent; coordinates are whitened, so their products are near 1.
const SMALLEST_PIVOT: f64 = 1e-9;

/// All `F` with `cur^T F prev = 0` for seven pairs and `det F = 0`; rows are the products `cur_i prev_j`, `i` slowest.
pub(super) fn solve(mut rows: [[f64; 9]; 7]) -> Vec<Matrix3<f64>> {
    let Some([first, second]) = null_space(&mut rows) else { return Vec::new() };
    // det(first * x + second), a cubic.
    let coefficients = [
        first.determinant(),
        cofactors(&first).dot(&second),
        cofactors(&second).dot(&first),
        second.determinant(),
    ];
    roots(coefficients).into_iter().map(|x| first * x + second).collect()
}

/// The two directions that seven rows leave free; none where they leave more.
fn null_space(rows: &mut [[f64; 9]; 7]) -> Option<[Matrix3<f64>; 2]> {
    let mut order = [0, 1, 2, 3, 4, 5, 6, 7, 8];
    for k in 0..7 {
        let (mut best, mut pivot_row, mut pivot_column) = (0.0, k, k);
        for (r, row) in rows.iter().enumerate().skip(k) {
            for (c, value) in row.iter().enumerate().skip(k) {
                if value.abs() > best {
                    (best, pivot_row, pivot_column) = (value.abs(), r, c);
                }
            }
        }
        if best < SMALLEST_PIVOT || best.is_nan() {
            return None;
        }
        rows.swap(k, pivot_row);
        rows.iter_mut().for_each(|row| row.swap(k, pivot_column));
        order.swap(k, pivot_column);
        let pivot = rows[k].map(|value| value / rows[k][k]);
        for (r, row) in rows.iter_mut().enumerate() {
            if r == k {
                *row = pivot;
            } else {
                let factor = row[k];
                row.iter_mut().zip(pivot).skip(k).for_each(|(value, p)| *value -= factor * p);
            }
        }
    }
    Some([7, 8].map(|free| {
        let mut solution = [0.0; 9];
        solution[order[free]] = 1.0;
        for k in 0..7 {
            solution[order[k]] = -rows[k][free];
        }
        let matrix = Matrix3::from_row_slice(&solution);
        matrix / matrix.norm()
    }))
}

fn cofactors(m: &Matrix3<f64>) -> Matrix3<f64> {
    let rows = [m.row(0).transpose(), m.row(1).transpose(), m.row(2).transpose()];
    let [a, b, c] = &rows;
    Matrix3::from_rows(&[b.cross(c).transpose(), c.cross(a).transpose(), a.cross(b).transpose()])
}

/// Real roots of `c0 x^3 + c1 x^2 + c2 x + c3`.
fn roots([c0, c1, c2, c3]: [f64; 4]) -> Vec<f64> {
    let largest = c1.abs().max(c2.abs()).max(c3.abs());
    if c0.abs() <= 1e-12 * largest {
        return quadratic_roots(c1, c2, c3);
    }
    let (a, b, c) = (c1 / c0, c2 / c0, c3 / c0);
    let q = (a * a - 3.0 * b) / 9.0;
    let r = (2.0 * a * a * a - 9.0 * a * b + 27.0 * c) / 54.0;
    let cube = q * q * q;
    let mut found = if r * r < cube {
        let angle = (r / cube.sqrt()).clamp(-1.0, 1.0).acos();
        let turn = std::f64::consts::TAU;
        [angle, angle + turn, angle - turn].map(|t| -2.0 * q.sqrt() * (t / 3.0).cos() - a / 3.0).to_vec()
    } else {
        let big = -r.signum() * (r.abs() + (r * r - cube).sqrt()).cbrt();
        let small = if big == 0.0 { 0.0 } else { q / big };
        vec![big + small - a / 3.0]
    };
    // A step of Newton's takes away what the closed form lost.
    for x in &mut found {
        let slope = (3.0 * *x + 2.0 * a) * *x + b;
        let value = ((*x + a) * *x + b) * *x + c;
        if slope != 0.0 {
            *x -= value / slope;
        }
    }
    found.retain(|x| x.is_finite());
    found
}

fn quadratic_roots(a: f64, b: f64, c: f64) -> Vec<f64> {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return Vec::new();
    }
    let half = -0.5 * (b + discriminant.sqrt().copysign(b));
    [half / a, c / half].into_iter().filter(|x| x.is_finite()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn roots_are_roots(x in prop::array::uniform3(-3.0..3.0f64), scale in prop::sample::select(vec![1.0, -0.02])) {
            let [x, y, z] = x;
            let cubic = [1.0, -(x + y + z), x * y + y * z + z * x, -x * y * z].map(|c| c * scale);
            let found = roots(cubic);
            prop_assert!(!found.is_empty());
            // Where two nearly meet, rounding may take both away; the third is there.
            let apart = (x - y).abs().min((y - z).abs()).min((z - x).abs());
            for root in [x, y, z] {
                let nearest = found.iter().map(|f| (f - root).abs()).fold(f64::INFINITY, f64::min);
                prop_assert!(nearest < 1e-6 || apart < 1e-2, "{found:?} without {root}");
            }
        }

        #[test]
        fn every_solution_fits_the_pairs_and_has_rank_two(values in prop::collection::vec(-1.0..1.0f64, 42)) {
            let pairs: Vec<_> = values.chunks(6).map(|v| (&v[..3], &v[3..])).collect();
            let mut rows = [[0.0; 9]; 7];
            for (row, (cur, prev)) in rows.iter_mut().zip(&pairs) {
                for i in 0..9 {
                    row[i] = cur[i / 3] * prev[i % 3];
                }
            }
            let solutions = solve(rows);
            prop_assert!(!solutions.is_empty());
            for f in solutions {
                let f = f / f.norm();
                prop_assert!(f.determinant().abs() < 1e-9);
                for row in rows {
                    let residual: f64 = (0..9).map(|i| row[i] * f[(i / 3, i % 3)]).sum();
                    prop_assert!(residual.abs() < 1e-9);
                }
            }
        }
    }

    #[test]
    fn pairs_that_repeat_have_no_solution() {
        let row = [0.3, 0.1, -0.2, 0.7, 0.4, 0.5, -0.6, 0.9, 0.8];
        assert!(solve([row; 7]).is_empty());
        assert!(solve([[f64::NAN; 9]; 7]).is_empty());
        assert_eq!(quadratic_roots(1.0, 0.0, 1.0), Vec::<f64>::new());
        assert_eq!(roots([0.0, 1.0, -3.0, 2.0]), [2.0, 1.0]);
    }
}
