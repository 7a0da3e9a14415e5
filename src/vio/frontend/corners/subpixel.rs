//! Where between the pixels a corner is.
//!
//! At a corner `q` every gradient `g_i` nearby is either nothing or across the line from `q` to its own place: `g_i . (p_i - q) = 0`.
//! Least squares over a window, weighted by distance, and again around the place found. Source: Foerstner and Guelch 1987; the same as
//! OpenCV's `cornerSubPix` without a dead zone.

use crate::frontend::image::Plane;

const STEPS: usize = 20;
const EPSILON_PX: f64 = 0.01;

/// The corner near `px` within a window of `2 half + 1` px; `px` itself where there is none, or none that near.
pub fn refine(plane: &Plane, px: [f32; 2], half: usize) -> [f32; 2] {
    let start = px.map(f64::from);
    let reach = half as isize;
    let weight = |d: isize| (-(d as f64 / half.max(1) as f64).powi(2)).exp();
    let mut place = start;
    for _ in 0..STEPS {
        let inside = (0.0..plane.width() as f64).contains(&place[0])
            && (0.0..plane.height() as f64).contains(&place[1]);
        if !inside {
            return px;
        }
        let [mut a, mut b, mut c, mut bx, mut by] = [0.0; 5];
        for dy in -reach..=reach {
            for dx in -reach..=reach {
                let (x, y) = (place[0] + dx as f64, place[1] + dy as f64);
                let gx = sample(plane, x + 1.0, y) - sample(plane, x - 1.0, y);
                let gy = sample(plane, x, y + 1.0) - sample(plane, x, y - 1.0);
                let w = weight(dx) * weight(dy);
                let [xx, xy, yy] = [w * gx * gx, w * gx * gy, w * gy * gy];
                a += xx;
                b += xy;
                c += yy;
                bx += xx * dx as f64 + xy * dy as f64;
                by += xy * dx as f64 + yy * dy as f64;
            }
        }
        let determinant = a * c - b * b;
        if determinant.abs() <= f64::EPSILON * f64::EPSILON {
            break;
        }
        let step = [(c * bx - b * by) / determinant, (a * by - b * bx) / determinant];
        place = [place[0] + step[0], place[1] + step[1]];
        if step[0] * step[0] + step[1] * step[1] <= EPSILON_PX * EPSILON_PX {
            break;
        }
    }
    let far = (place[0] - start[0]).abs().max((place[1] - start[1]).abs());
    // Not a number is not near either.
    if far <= half as f64 { place.map(|c| c as f32) } else { px }
}

/// The grey value between pixels; within the border of the plane.
fn sample(plane: &Plane, x: f64, y: f64) -> f64 {
    let (left, top) = (x.floor(), y.floor());
    let (fx, fy) = (x - left, y - top);
    let row = |dy: isize| {
        let run = plane.run(left as isize, top as isize + dy, 2);
        let (a, b) = (f64::from(run[0]), f64::from(run[1]));
        a + fx * (b - a)
    };
    let (above, below) = (row(0), row(1));
    above + fy * (below - above)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::GrayImage;
    use proptest::prelude::*;

    /// A chessboard's corner at `(x, y)`, turned, smoothed by the pixels' area.
    fn saddle(x: f64, y: f64, angle: f64) -> Plane {
        let (sin, cos) = angle.sin_cos();
        let image = GrayImage::from_fn(40, 40, |u, v| {
            let (dx, dy) = (u as f64 - x, v as f64 - y);
            let (a, b) = (cos * dx + sin * dy, cos * dy - sin * dx);
            (128.0 + 100.0 * (a / 0.8).tanh() * (b / 0.8).tanh()).round() as u8
        });
        Plane::new(image.unwrap().view())
    }

    proptest! {
        #[test]
        fn a_chessboard_corner_is_found_to_a_twelfth_pixel(x in 18.0..22.0f64, y in 18.0..22.0f64, angle in 0.0..1.5f64) {
            let plane = saddle(x, y, angle);
            let [u, v] = refine(&plane, [x.round() as f32, y.round() as f32], 5).map(f64::from);
            prop_assert!((u - x).hypot(v - y) < 0.08, "{u} {v}");
        }
    }

    #[test]
    fn nothing_to_find_leaves_the_point_where_it_was() {
        let plane = Plane::new(GrayImage::from_fn(30, 30, |_, _| 9).unwrap().view());
        for px in [[15.0, 15.0], [0.0, 29.0], [-40.0, 3.0]] {
            assert_eq!(refine(&plane, px, 10), px);
        }
    }
}
