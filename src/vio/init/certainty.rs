//! How certain an adjusted window is of scale and gravity, and how much each inertial sensor was overruled in it.
//!
//! All comes from the covariance `S` of the window's unknowns ([`Window::covariance`]). For a group of whitened rows `r_g = J_g x` the
//! redundancy is `n_g - tr(J_g S J_g^T)`: the sum of squares it should have. The root of what it has over that is the factor by which
//! the group's noise was larger than said. Source: Forstner 1979 (variance components). The gyro's group is the rotation's three rows
//! alone; the accelerometer's the six that position and velocity add to it.

use crate::factors::inertial::{inertial_jacobians, sqrt_information};
use crate::state::{ROTATION, STATE_DIM};
use crate::window::Window;
use nalgebra::{DMatrix, Matrix3, SMatrix};

/// Rows of position, rotation and velocity.
const MOTION_ROWS: usize = 9;

/// A group of whitened rows after the adjustment.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Excess {
    /// Sum of squares.
    squares: f64,
    /// Its expectation.
    redundancy: f64,
}

impl Excess {
    /// The factor on the group's deviation, starting from a `prior` factor that counts as much as `weight` redundant rows, where
    /// the rows were expected to be `now` times as large as their noise says.
    pub(super) fn factor(&self, now: f64, prior: f64, weight: f64) -> f64 {
        let squares = self.squares * now * now + prior * prior * weight;
        (squares / (self.redundancy + weight)).sqrt()
    }
}

/// Relative deviation of the scale, with the `covariance` of the window.
pub(super) fn scale_std(window: &Window, covariance: &DMatrix<f64>) -> f64 {
    window.log_size_slope().map_or(f64::INFINITY, |slope| slope.dot(&(covariance * &slope)).max(0.0).sqrt())
}

/// Deviation of the direction of gravity as the frame's body sees it \[rad\]: the larger of its two.
pub(super) fn gravity_std(window: &Window, covariance: &DMatrix<f64>, frame: usize) -> f64 {
    let at = window.layout().state(frame, ROTATION);
    let r_wb = window.frames()[frame].state.world_from_body.rotation.to_rotation_matrix();
    let block: Matrix3<f64> = covariance.fixed_view::<3, 3>(at, at).into_owned();
    let in_world = r_wb.matrix() * block * r_wb.matrix().transpose();
    let tilt = in_world.fixed_view::<2, 2>(0, 0).into_owned();
    tilt.symmetric_eigenvalues().max().max(0.0).sqrt()
}

/// What the gyro's and the accelerometer's whitened rows sum to and should.
pub(super) fn inertial_excess(window: &Window, covariance: &DMatrix<f64>) -> [Excess; 2] {
    let layout = window.layout();
    let mut excess = [Excess::default(); 2];
    for j in 1..window.frames().len() {
        let Some(preint) = &window.frames()[j].preint else { continue };
        let Some(root) = sqrt_information(preint) else { continue };
        let (i, frames) = (j - 1, window.frames());
        let (residual, d_i, d_j) = inertial_jacobians(preint, &frames[i].state, &frames[j].state);
        let place = |k: usize| layout.state(if k < STATE_DIM { i } else { j }, k % STATE_DIM);
        let block = DMatrix::from_fn(2 * STATE_DIM, 2 * STATE_DIM, |r, c| covariance[(place(r), place(c))]);
        let mut d = SMatrix::<f64, STATE_DIM, { 2 * STATE_DIM }>::zeros();
        d.fixed_columns_mut::<STATE_DIM>(0).copy_from(&d_i);
        d.fixed_columns_mut::<STATE_DIM>(STATE_DIM).copy_from(&d_j);
        let explained = d * block * d.transpose();
        // A lower triangular root whitens its first rows alone, too.
        let motion = root.fixed_view::<MOTION_ROWS, MOTION_ROWS>(0, 0).into_owned();
        let all = Excess {
            squares: (motion * residual.fixed_rows::<MOTION_ROWS>(0)).norm_squared(),
            redundancy: MOTION_ROWS as f64
                - (motion * explained.fixed_view::<MOTION_ROWS, MOTION_ROWS>(0, 0) * motion.transpose())
                    .trace(),
        };
        let rotation = preint.covariance().fixed_view::<3, 3>(ROTATION, ROTATION).into_owned();
        let Some(information) = rotation.try_inverse() else { continue };
        let turn = residual.fixed_rows::<3>(ROTATION).into_owned();
        let gyro = Excess {
            squares: turn.dot(&(information * turn)),
            redundancy: 3.0 - (information * explained.fixed_view::<3, 3>(ROTATION, ROTATION)).trace(),
        };
        let accel =
            Excess { squares: all.squares - gyro.squares, redundancy: all.redundancy - gyro.redundancy };
        for (sum, one) in excess.iter_mut().zip([gyro, accel]) {
            sum.squares += one.squares;
            sum.redundancy += one.redundancy.max(0.0);
        }
    }
    excess
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::factors::loss::Loss;
    use crate::init::adjustment::{self, settle};
    use crate::init::frame::{InitFrame, tracks};
    use crate::init::tests::{Scene, body_from_cam, gentle_flight};
    use crate::preint::{NoisySample, Preintegration};
    use crate::state::{ACCEL_BIAS, GYRO_BIAS, NavState, POSITION};
    use dpn_core::ImuSample;
    use dpn_core::geometry::sphere::tangent_basis;
    use dpn_core::random::Stream;
    use nalgebra::{Vector2, Vector3};
    use rand_distr::{Distribution, StandardNormal};

    const FRAMES: usize = 6;
    /// Deviation of a direction \[rad\].
    const TRACK_STD: f64 = 1e-3;

    /// An exact flight as a window at the truth, its gauge held; the samples' noise is the baseline's.
    fn exact(seed: u64) -> Window {
        let scene = Scene::new(&gentle_flight(seed), FRAMES, 0.25, 0.0, seed);
        let mut window = adjustment::window(body_from_cam(), 0.0);
        // What is said holds for normal noise; robust weights would give up some of it.
        window.config.loss = Loss::Squared;
        let frames: Vec<&InitFrame> = scene.frames.iter().collect();
        for (k, frame) in frames.iter().enumerate() {
            let state = NavState {
                world_from_body: scene.cameras[k] * body_from_cam().inverse(),
                vel_in_world: scene.velocities[k],
                bias: scene.bias,
            };
            let preint = k.checked_sub(1).map(|p| scene.preints[p].clone());
            window.add_frame(frame.t, state, preint, &[]);
        }
        window.landmarks = tracks(&frames, TRACK_STD);
        window.retain_landmarks(|l| l.id % 4 == 0);
        window.triangulate();
        let mut prior = window.prior_about(vec![window.frames()[0].state]);
        prior.hold(0, POSITION, 1e-5);
        prior.hold_heading(0, 1e-5);
        // The biases are known: their prior's noise need not be drawn.
        prior.hold(0, ACCEL_BIAS, 1e-6);
        prior.hold(0, GYRO_BIAS, 1e-6);
        window.prior = Some(prior);
        settle(&mut window);
        window
    }

    /// The flight as noisy tracks and a noisy IMU would have told it, adjusted.
    fn noisy_copy(exact: &Window, copy: u64) -> Window {
        let mut rng = Stream::new(copy).named("certainty").rng();
        let mut normal = move || -> f64 { StandardNormal.sample(&mut rng) };
        let mut window = exact.clone();
        for frame in window.frames.iter_mut().skip(1) {
            let Some(preint) = &frame.preint else { continue };
            let mut off = |std: [f64; 3], value: [f64; 3]| [0, 1, 2].map(|k| value[k] + std[k] * normal());
            let mut samples = preint.samples().iter().map(|s| {
                let accel = off(s.noise.of(dpn_core::Sensor::Accel), s.sample.accel);
                let gyro = off(s.noise.of(dpn_core::Sensor::Gyro), s.sample.gyro);
                NoisySample { sample: ImuSample { accel, gyro, ..s.sample }, ..*s }
            });
            let mut again = Preintegration::new(*preint.config(), *preint.bias(), samples.next().unwrap());
            samples.for_each(|s| again.push(s));
            frame.preint = Some(again);
        }
        for (_, sighting) in window.landmarks.iter_mut().flat_map(|l| &mut l.sightings) {
            let off = tangent_basis(&sighting.bearing) * Vector2::new(normal(), normal()) * TRACK_STD;
            let bearing = (sighting.bearing + off).normalize();
            *sighting = crate::factors::reprojection::Sighting::from_bearing(&bearing, TRACK_STD).unwrap();
        }
        settle(&mut window);
        window
    }

    /// Natural logarithm of the frames' root mean square distance from their mean.
    fn log_spread(window: &Window) -> f64 {
        let positions: Vec<_> =
            window.frames().iter().map(|f| f.state.world_from_body.translation.vector).collect();
        let mean = positions.iter().sum::<Vector3<f64>>() / positions.len() as f64;
        0.5 * positions.iter().map(|p| (p - mean).norm_squared()).sum::<f64>().ln()
    }

    #[test]
    fn deviations_are_those_of_noisy_copies() {
        /// Noisy copies.
        const COPIES: u64 = 150;
        let exact = exact(4);
        let covariance = exact.covariance().unwrap();
        let newest = FRAMES - 1;
        let up = |w: &Window| w.frames()[newest].state.world_from_body.rotation.inverse() * Vector3::z();
        let (mut scales, mut tilts) = (0.0, 0.0);
        let (mut squares, mut redundancy, mut track_factor) = ([0.0; 2], [0.0; 2], 0.0);
        for copy in 0..COPIES {
            let noisy = noisy_copy(&exact, copy);
            scales += (log_spread(&noisy) - log_spread(&exact)).powi(2);
            tilts += up(&noisy).cross(&up(&exact)).norm_squared();
            for (k, excess) in inertial_excess(&noisy, &covariance).iter().enumerate() {
                squares[k] += excess.squares;
                redundancy[k] += excess.redundancy;
            }
            track_factor += adjustment::track_std_factor(&noisy, |landmarks| 3.0 * landmarks as f64);
        }
        // The deviation of a deviation from n samples is 1/sqrt(2 n), here 6 %.
        let ratio = (scales / COPIES as f64).sqrt() / scale_std(&exact, &covariance);
        assert!((0.82..1.25).contains(&ratio), "scale: sampled over said {ratio:.3}");
        // Two directions, of which the larger deviation is said.
        let ratio = (tilts / COPIES as f64).sqrt() / gravity_std(&exact, &covariance, newest);
        assert!((0.82..1.7).contains(&ratio), "tilt: sampled over said {ratio:.3}");
        for (name, k) in [("gyro", 0), ("accelerometer", 1)] {
            let ratio = squares[k] / redundancy[k];
            assert!((0.85..1.15).contains(&ratio), "{name}: squares over redundancy {ratio:.3}");
        }
        let factor = track_factor / COPIES as f64;
        assert!((0.93..1.07).contains(&factor), "tracks: {factor:.3} of their deviation");
    }

    #[test]
    fn a_factor_moves_from_the_prior_to_what_the_rows_say_as_they_outweigh_it() {
        let none = Excess { squares: 0.0, redundancy: 0.0 };
        assert!((none.factor(1.0, 3.0, 6.0) - 3.0).abs() < 1e-12);
        let many = Excess { squares: 4e4, redundancy: 1e4 };
        // Twice as large as expected, where 1.5 times the noise was expected: three times the noise.
        assert!((many.factor(1.5, 1.0, 6.0) - 3.0).abs() < 1e-2);
    }
}
