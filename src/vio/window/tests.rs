//! The window on a small flight with known truth.

use super::linearisation::Linearisation;
use super::part::Part;
use super::*;
use crate::factors::loss::Loss;
use crate::factors::reprojection::Sighting;
use crate::init::tests::{Scene, body_from_cam, gentle_flight};
use crate::state::{NavState, STATE_DIM};
use dpn_core::camera::CameraModel;
use nalgebra::{DMatrix, DVector, SVector, UnitQuaternion, Vector3};
use proptest::prelude::*;

const STEP: f64 = 0.15;

pub(crate) fn config() -> WindowConfig {
    WindowConfig {
        loss: Loss::Squared,
        cost_tolerance: 1e-14,
        max_iterations: 60,
        outlier_px: 1e6,
        handover: Handover::Consume,
        ..WindowConfig::default()
    }
}

/// What frame `k` of a scene sees; points that the first frame saw are lost after `followed` frames.
pub(crate) fn seen(scene: &Scene, k: usize, followed: usize) -> Vec<Seen> {
    let camera = CameraModel::euroc_cam0();
    scene.frames[k]
        .bearings()
        .iter()
        .filter(|(id, _)| k < followed || scene.frames[0].bearing(*id).is_none())
        .filter_map(|(id, bearing)| {
            let px = camera.project(bearing)?;
            Some(Seen { id: *id, sighting: Sighting::new(&camera, &px, 0.5)? })
        })
        .collect()
}

pub(crate) fn truth(scene: &Scene, k: usize) -> NavState {
    NavState {
        world_from_body: scene.cameras[k] * body_from_cam().inverse(),
        vel_in_world: scene.velocities[k],
        bias: scene.bias,
    }
}

fn add(window: &mut Window, scene: &Scene, k: usize) {
    let preint = k.checked_sub(1).map(|p| scene.preints[p].clone());
    window.add_frame(scene.frames[k].t, truth(scene, k), preint, &seen(scene, k, 5));
}

fn window(scene: &Scene, frames: usize, config: WindowConfig) -> Window {
    let mut window = Window::new(config, body_from_cam());
    for k in 0..frames {
        add(&mut window, scene, k);
    }
    window.anchor([0.3, 0.1]);
    window.triangulate();
    window
}

fn scene(seed: u64) -> Scene {
    Scene::new(&gentle_flight(seed), 10, STEP, 0.5, seed)
}

#[test]
fn marginalising_changes_no_estimate() {
    let scene = scene(3);
    let mut whole = window(&scene, 9, config());
    whole.optimise();
    let mut sliding = window(&scene, 9, config());
    sliding.optimise();
    sliding.slide(Leaving::Oldest);
    for w in [&mut whole, &mut sliding] {
        add(w, &scene, 9);
        w.triangulate();
        w.optimise();
    }
    let (a, b) = (whole.newest().unwrap().state, sliding.newest().unwrap().state);
    let covariance = whole.newest_pose_covariance().unwrap();
    let moved = a.minus(&b);
    let against_truth = a.minus(&truth(&scene, 9));
    for k in 0..6 {
        let std = covariance[(k, k)].sqrt();
        // Derivatives stay where they were when the prior was made: what is left is of second order in the noise.
        assert!(moved[k].abs() < 0.03 * std, "unknown {k} moved by {:.2e}, std {std:.2e}", moved[k]);
        assert!(against_truth[k].abs() < 5.0 * std);
    }
    // Without its prior the window says something else: the test above can fail.
    sliding.prior = None;
    sliding.anchor([0.3, 0.1]);
    sliding.optimise();
    let forgotten = a.minus(&sliding.newest().unwrap().state);
    assert!((0..6).any(|k| forgotten[k].abs() > 0.1 * covariance[(k, k)].sqrt()));
}

/// What several frames leave behind together is what they leave one after the other.
#[test]
fn frames_leave_at_once_as_they_leave_one_by_one() {
    for (seed, leaving) in [(3, 2), (4, 3), (5, 5)] {
        let scene = scene(seed);
        let mut each = window(&scene, 9, config());
        each.optimise();
        let mut once = each.clone();
        once.slide_oldest(leaving);
        for _ in 0..leaving {
            each.slide(Leaving::Oldest);
        }
        for w in [&mut once, &mut each] {
            add(w, &scene, 9);
            w.triangulate();
            w.optimise();
        }
        let std = each.newest_pose_covariance().unwrap().diagonal().map(f64::sqrt);
        let moved = once.newest().unwrap().state.minus(&each.newest().unwrap().state);
        for k in 0..6 {
            assert!(
                moved[k].abs() < 1e-3 * std[k],
                "{leaving} left: unknown {k} differs by {:.2e}, std {:.2e}",
                moved[k],
                std[k]
            );
        }
    }
}

#[test]
fn the_gradient_vanishes_where_the_solver_stops() {
    let mut window = window(&scene(5), 8, config());
    let solved = window.optimise();
    assert!(solved.last_cost < solved.first_cost);
    let layout = window.layout();
    let cost = |w: &Window| {
        let mut at = Linearisation::default();
        at.compute(w, &layout, Part::All, 0.0);
        at.cost
    };
    let best = cost(&window);
    // Steps of a hundredth of what the solver damps by, in every direction, never lower the cost.
    for frame in 0..8 {
        for k in 0..STATE_DIM {
            for sign in [-1.0, 1.0] {
                let mut moved = window.clone();
                let mut d = SVector::<f64, STATE_DIM>::zeros();
                d[k] = sign * 1e-6;
                moved.frames[frame].state = moved.frames[frame].state.plus(&d);
                assert!(cost(&moved) > best - 1e-6, "frame {frame} unknown {k}");
            }
        }
    }
}

#[test]
fn the_equations_predict_the_cost_of_a_small_step() {
    let mut config = config();
    config.estimate_extrinsics = true;
    config.estimate_time_offset = true;
    let window = window(&scene(7), 6, config);
    let layout = window.layout();
    let mut at = Linearisation::default();
    at.compute(&window, &layout, Part::All, 0.0);
    // A step of the states alone, depths following: the reduced model's promise against the true cost.
    let mut factor = normal::Factor::default();
    at.normal.factor(|_| 1e2, &mut factor).unwrap();
    let mut step = at.normal.gradient().to_vec();
    factor.solve_negated(&mut step);
    let slope: f64 = step.iter().zip(at.normal.gradient()).map(|(d, g)| d * g).sum();
    let bend: f64 = step.iter().zip(at.normal.times(&step)).map(|(d, h)| d * h).sum();
    let mut stepped = window.clone();
    stepped.apply(&at, &step);
    let mut after = Linearisation::default();
    after.compute(&stepped, &layout, Part::All, 0.0);
    let mut still = window.clone();
    still.apply(&at, &vec![0.0; layout.dim()]);
    let mut depths_only = Linearisation::default();
    depths_only.compute(&still, &layout, Part::All, 0.0);
    let promised = slope + 0.5 * bend;
    let kept = after.cost - depths_only.cost;
    assert!(promised < 0.0);
    assert!((kept - promised).abs() < 0.05 * promised.abs(), "promised {promised:.4e}, kept {kept:.4e}");
}

#[test]
fn the_covariance_of_all_ends_with_that_of_the_newest_pose() {
    let mut window = window(&scene(5), 8, config());
    window.optimise();
    let (all, pose) = (window.covariance().unwrap(), window.newest_pose_covariance().unwrap());
    let corner = all.view((all.nrows() - 6, all.ncols() - 6), (6, 6)).into_owned();
    assert!((corner - pose).amax() < 1e-6 * pose.amax());
    assert!((&all - all.transpose()).amax() < 1e-6 * all.amax());
    window.prior = None;
    assert!(window.covariance().is_none(), "nothing holds the gauge");
}

#[test]
fn settling_goes_on_to_where_robust_weights_leave_no_step() {
    let mut window = window(&scene(9), 8, WindowConfig { loss: Loss::Cauchy, loss_scale: 1.0, ..config() });
    window.optimise();
    let step = |window: &Window| {
        let layout = window.layout();
        let mut at = Linearisation::default();
        at.compute(window, &layout, Part::All, 0.0);
        let mut factor = normal::Factor::default();
        at.normal.factor(|_| 0.0, &mut factor).unwrap();
        let mut step = at.normal.gradient().to_vec();
        factor.solve_negated(&mut step);
        step.iter().fold(0.0f64, |largest, d| largest.max(d.abs()))
    };
    let before = step(&window);
    window.settle(20);
    assert!(step(&window) < 1e-2 * before && step(&window) < 1e-6, "{before:.1e} {:.1e}", step(&window));
}

/// What landmarks leave over the states, against the same written down as one dense system and reduced by an inverse.
#[test]
fn landmarks_leave_what_a_dense_schur_complement_leaves() {
    for (extrinsics, time_offset) in [(false, false), (true, false), (false, true), (true, true)] {
        let config = WindowConfig {
            estimate_extrinsics: extrinsics,
            estimate_time_offset: time_offset,
            loss: Loss::Huber,
            loss_scale: 0.5,
            ..config()
        };
        let mut window = window(&scene(17), 7, config);
        // Off the truth, so that there is a gradient and the loss weighs.
        let off = SVector::<f64, STATE_DIM>::from_fn(|k, _| 0.01 * (k as f64).cos());
        window.frames[3].state = window.frames[3].state.plus(&off);
        for (k, landmark) in window.landmarks.iter_mut().enumerate() {
            // Some frames of the run did not see it, and its rays turn with the clock.
            if landmark.sightings.len() > 3 && k % 3 == 0 {
                landmark.sightings.remove(2);
            }
            for (_, sighting) in &mut landmark.sightings {
                sighting.ray_rate = Vector3::new(0.2, -0.1, 0.0);
            }
        }
        let layout = window.layout();
        let linearised = |window: &Window| {
            let mut at = Linearisation::default();
            at.compute(window, &layout, Part::All, 0.0);
            at
        };
        let all = linearised(&window);
        let mut blind = window.clone();
        blind.landmarks.clear();
        let blind = linearised(&blind);

        let dim = layout.dim();
        let (mut h, mut g) = (DMatrix::zeros(dim, dim), DVector::zeros(dim));
        for landmark in window.landmarks.iter().filter(|l| l.sightings.len() > 1) {
            let Some(inverse_depth) = landmark.inverse_depth else { continue };
            let (host, seen_by_host) = (landmark.host(), landmark.host_sighting());
            let others = &landmark.sightings[1..];
            let mut rows = DMatrix::zeros(2 * others.len() + 2, dim + 3);
            let mut residuals = DVector::zeros(2 * others.len() + 2);
            for (k, (target, seen)) in others.iter().enumerate() {
                let geometry = window.geometry(host, *target);
                let at = geometry.linearise(seen_by_host, seen, inverse_depth);
                let (_, weight) =
                    window.config.loss.evaluate(at.residual.norm_squared(), window.config.loss_scale);
                let pixel = at.d_host_pixel(&seen_by_host.spread);
                let camera = geometry.d_camera(&at, &seen_by_host.ray, inverse_depth);
                let clock = geometry.d_offset(&at, seen_by_host, seen);
                for r in 0..2 {
                    let row = 2 * k + r;
                    residuals[row] = at.residual[r] * weight.sqrt();
                    let mut put = |column: usize, values: &[f64]| {
                        for (k, value) in values.iter().enumerate() {
                            rows[(row, column + k)] = value * weight.sqrt();
                        }
                    };
                    put(layout.pose(host), &at.host[r]);
                    put(layout.pose(*target), &at.target[r]);
                    if let Some(place) = layout.camera() {
                        put(place, &camera[r]);
                    }
                    if let Some(place) = layout.offset() {
                        put(place, &[clock[r]]);
                    }
                    put(dim, &[at.depth[r], pixel[r][0], pixel[r][1]]);
                }
            }
            // The host's own pixel: zero, by one deviation.
            rows[(2 * others.len(), dim + 1)] = 1.0;
            rows[(2 * others.len() + 1, dim + 2)] = 1.0;
            let (all_h, all_g) = (rows.tr_mul(&rows), rows.tr_mul(&residuals));
            let w = all_h.view((dim, 0), (3, dim)).into_owned();
            let inverse = all_h.view((dim, dim), (3, 3)).into_owned().try_inverse().unwrap();
            h += all_h.view((0, 0), (dim, dim)) - w.transpose() * &inverse * &w;
            g += all_g.rows(0, dim) - w.transpose() * &inverse * all_g.rows(dim, 3);
        }
        let largest = h.amax();
        assert!(largest > 1.0 && g.amax() > 1.0);
        for r in 0..dim {
            let ours = all.normal.gradient()[r] - blind.normal.gradient()[r];
            assert!((ours - g[r]).abs() < 1e-9 * largest, "gradient {r}: {ours} {}", g[r]);
            for c in 0..=r {
                let ours = all.normal.at(r, c) - blind.normal.at(r, c);
                assert!((ours - h[(r, c)]).abs() < 1e-9 * largest, "{r}, {c}: {ours} {}", h[(r, c)]);
            }
        }
    }
}

#[test]
fn a_prior_without_anchor_knows_neither_place_nor_heading() {
    let scene = scene(11);
    let mut window = window(&scene, 9, config());
    window.optimise();
    window.prior = None;
    let prior = window.prior_without_oldest(1);
    let layout = prior.layout;
    let scale = (0..layout.dim()).map(|k| prior.system.at(k, k)).fold(0.0, f64::max);
    let mut direction = vec![0.0; layout.dim()];
    for axis in 0..3 {
        direction.fill(0.0);
        for frame in 0..layout.frames {
            direction[layout.state(frame, axis)] = 1.0;
        }
        let along = prior.system.times(&direction).iter().fold(0.0f64, |m, v| m.max(v.abs()));
        assert!(along < 1e-9 * scale, "shift {axis}: {along:.2e} of {scale:.2e}");
    }
    direction.fill(0.0);
    for frame in 0..layout.frames {
        let state = &window.frames()[frame + 1].state;
        let position = Vector3::z().cross(&state.world_from_body.translation.vector);
        let rotation = state.world_from_body.rotation.inverse() * Vector3::z();
        let velocity = Vector3::z().cross(&state.vel_in_world);
        for k in 0..3 {
            direction[layout.state(frame, k)] = position[k];
            direction[layout.state(frame, 3 + k)] = rotation[k];
            direction[layout.state(frame, 6 + k)] = velocity[k];
        }
    }
    let along = prior.system.times(&direction).iter().fold(0.0f64, |m, v| m.max(v.abs()));
    assert!(along < 1e-9 * scale, "heading: {along:.2e} of {scale:.2e}");
}

#[test]
fn noise_travels_with_the_samples_when_intervals_are_merged() {
    let scene = scene(13);
    let mut window = window(&scene, 6, config());
    let before: f64 = window.frames()[4..].iter().map(|f| f.preint.as_ref().unwrap().duration()).sum();
    window.slide(Leaving::SecondNewest);
    let merged = window.newest().unwrap().preint.as_ref().unwrap();
    assert!((merged.duration() - before).abs() < 1e-12);
    assert_eq!(merged.samples().len(), 2 * (STEP * 200.0) as usize + 1);
    let mut whole = scene.preints[3].clone();
    whole.append(&scene.preints[4]);
    assert_eq!(merged.covariance(), whole.covariance());
}

#[test]
fn parallax_of_a_pure_rotation_is_none() {
    let turning = |t: f64| {
        nalgebra::Isometry3::from_parts(
            (-(UnitQuaternion::from_euler_angles(0.0, 0.2 * t, 0.4 * t)
                * Vector3::new(-0.0216, -0.0647, 0.0098)))
            .into(),
            UnitQuaternion::from_euler_angles(0.0, 0.2 * t, 0.4 * t),
        )
    };
    let scene = Scene::new(&turning, 4, STEP, 0.0, 1);
    let window = window(&scene, 4, config());
    let parallax = window.parallax(0, 3);
    assert!(parallax.common > 20);
    assert!(parallax.mean * 460.0 < 0.01, "{} px", parallax.mean * 460.0);
    let moving = Scene::new(&gentle_flight(2), 4, STEP, 0.0, 1);
    assert!(self::window(&moving, 4, config()).parallax(0, 3).mean * 460.0 > 5.0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]
    #[test]
    fn what_is_consumed_counts_a_sighting_at_most_once(seed in 0u64..50) {
        let scene = scene(seed);
        let mut window = window(&scene, 9, config());
        let total: usize = window.landmarks().iter().map(|l| l.sightings.len()).sum();
        let used: usize = window.landmarks().iter().map(|l| l.handed_over(1)).sum();
        window.slide(Leaving::Oldest);
        let left: usize = window.landmarks().iter().map(|l| l.sightings.len()).sum();
        // The newest sighting stays as the anchor of what comes; alone it is no measurement.
        prop_assert!(used + left <= total + window.landmarks().len(), "{used} + {left} of {total}");
        prop_assert!(window.landmarks().iter().all(|l| l.sightings.iter().all(|(f, _)| *f < 8)));
    }
}

/// Whatever leaves and whenever: of each sighting the prior and the window together hold one whole, at any time.
#[test]
fn split_sightings_are_one_whole_in_prior_and_window_at_any_time() {
    let scene = scene(3);
    let mut window = window(&scene, 9, WindowConfig { handover: Handover::Split, ..config() });
    let mut parts = 0;
    while window.frames().len() > 3 {
        let before: Vec<Landmark> = window.landmarks().to_vec();
        let handed: Vec<Vec<f64>> = before
            .iter()
            .map(|l| (0..l.handed_over(1)).map(|k| window.handed_part(l, k, 1)).collect())
            .collect();
        let last = window.frames().len() - 1;
        window.slide(Leaving::Oldest);
        for (landmark, handed) in before.iter().zip(&handed).filter(|(_, handed)| !handed.is_empty()) {
            assert!(
                (handed[0] - landmark.sightings[0].1.left).abs() < 1e-15,
                "the host hands over all that is left"
            );
            if landmark.last_frame() < last {
                // A track that has ended goes in whole.
                assert!(window.landmarks().iter().all(|l| l.id != landmark.id));
                assert!(landmark.sightings.iter().zip(handed).all(|((_, s), part)| s.left == *part));
                continue;
            }
            let Some(now) = window.landmarks().iter().find(|l| l.id == landmark.id) else { continue };
            for (((_, was), part), (_, is)) in
                landmark.sightings.iter().zip(handed).skip(1).zip(&now.sightings)
            {
                assert!((part + is.left - was.left).abs() < 1e-15);
                assert!(is.left > 0.0 && is.left <= 1.0);
                parts += usize::from(is.left < 1.0);
            }
        }
    }
    assert!(parts > 100, "{parts}");
}

/// Frames that leave together take with them what they take one after the other.
#[test]
fn split_sightings_keep_as_much_when_frames_leave_at_once() {
    for leaving in 1..7 {
        let scene = scene(3);
        let mut once = window(&scene, 9, WindowConfig { handover: Handover::Split, ..config() });
        let mut each = once.clone();
        once.slide_oldest(leaving);
        for _ in 0..leaving {
            each.slide(Leaving::Oldest);
        }
        assert_eq!(once.landmarks().len(), each.landmarks().len());
        for (a, b) in once.landmarks().iter().zip(each.landmarks()) {
            assert_eq!((a.id, a.sightings.len()), (b.id, b.sightings.len()));
            for ((frame_a, a), (frame_b, b)) in a.sightings.iter().zip(&b.sightings) {
                assert_eq!(frame_a, frame_b);
                assert!((a.left - b.left).abs() < 1e-12, "{leaving} left: {} and {}", a.left, b.left);
            }
        }
    }
}

/// Where half is left of every sighting, landmarks say half of what they say whole.
#[test]
fn what_is_left_of_a_sighting_is_what_it_weighs() {
    let scene = scene(3);
    let equations = |left: f64| {
        let mut window = window(&scene, 5, config());
        for (_, sighting) in window.landmarks.iter_mut().flat_map(|l| &mut l.sightings) {
            sighting.left = left;
        }
        window.prior = None;
        for frame in &mut window.frames {
            frame.preint = None;
        }
        let layout = window.layout();
        let mut at = Linearisation::default();
        at.compute(&window, &layout, Part::All, 0.0);
        (0..layout.dim()).map(|k| at.normal.at(k, k)).collect::<Vec<f64>>()
    };
    let (whole, half) = (equations(1.0), equations(0.5));
    let mut seen = 0;
    for (whole, half) in whole.iter().zip(&half).filter(|(whole, _)| **whole > 1e-6) {
        // Exactly half, but for roundings: the host's own pixel is believed half as firmly too.
        assert!((half / whole - 0.5).abs() < 1e-6, "{half} of {whole}");
        seen += 1;
    }
    assert!(seen >= 24, "{seen}");
}

#[test]
fn a_share_of_a_landmark_is_that_share_of_its_information() {
    let scene = scene(3);
    let prior = |handover| window(&scene, 3, WindowConfig { handover, ..config() }).prior_without_oldest(1);
    // Two sightings a landmark hand over all of it, three a half: less is known where shares are handed over.
    let (all, part) = (prior(Handover::Reuse), prior(Handover::Split));
    let places = 0..all.layout.dim();
    assert!(places.clone().all(|k| part.system.at(k, k) <= all.system.at(k, k) * (1.0 + 1e-9)));
    assert!(places.clone().any(|k| part.system.at(k, k) < 0.9 * all.system.at(k, k)));
}

/// What sightings are off after a frame: nothing in a scene without noise, all of what the frame was moved by, and no more than the clip.
#[test]
fn sightings_off_their_landmarks_show_in_the_mean_square() {
    let mut window = window(&scene(3), 9, config());
    window.optimise();
    let last = window.frames().len() - 1;
    let good = window.mean_visual_square(last).unwrap();
    window.frames[last].state.world_from_body.translation.vector += Vector3::new(0.0, 0.02, 0.02);
    let moved = window.mean_visual_square(last).unwrap();
    window.frames[last].state.world_from_body.translation.vector += Vector3::new(0.0, 2.0, 2.0);
    let far = window.mean_visual_square(last).unwrap();
    assert!(good < 2.0 && moved > 2.0 * good && far > moved, "{good} {moved} {far}");
    assert!(far <= 9.0 && far > 8.0, "{far}");
    assert_eq!(window.mean_visual_square(last + 1), None);
}

#[test]
fn frames_that_only_the_longer_window_has_go_along_when_the_others_are_moved() {
    for seed in 0..6 {
        let scene = scene(seed);
        let mut longer = window(&scene, 8, config());
        longer.prior = None;
        let cost = |window: &Window| {
            let mut at = Linearisation::default();
            at.compute(window, &window.layout(), Part::All, 0.0);
            at.cost
        };
        let before = cost(&longer);
        // No measurement knows where the world begins, nor of its heading.
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.4);
        let moved = nalgebra::Isometry3::from_parts(Vector3::new(2.0, -1.0, 0.5).into(), turn);
        let mut newest = longer.clone();
        newest.frames.drain(..5);
        for frame in &mut newest.frames {
            frame.state.world_from_body = moved * frame.state.world_from_body;
            frame.state.vel_in_world = turn * frame.state.vel_in_world;
        }
        longer.take_estimates(&newest);
        let after = cost(&longer);
        assert!((after - before).abs() < 1e-6 * before, "seed {seed}: {before} became {after}");
    }
}

#[test]
fn the_deviation_of_the_scale_is_that_of_the_covariance_along_the_size() {
    for seed in 0..3 {
        let mut window = window(&scene(seed), 8, config());
        window.optimise();
        let (slope, covariance) = (window.log_size_slope().unwrap(), window.covariance().unwrap());
        let size = |w: &Window| {
            let all = w.frames().iter().map(|f| f.state.world_from_body.translation.vector);
            let mean = all.clone().sum::<Vector3<f64>>() / w.frames().len() as f64;
            all.map(|p| (p - mean).norm_squared()).sum::<f64>().sqrt()
        };
        for k in [0, 3, 7] {
            let at = |h: f64| {
                let mut moved = window.clone();
                moved.frames[k].state.world_from_body.translation.vector.y += h;
                size(&moved).ln()
            };
            let numeric = (at(1e-6) - at(-1e-6)) / 2e-6;
            let place = window.layout().state(k, crate::state::POSITION) + 1;
            assert!((slope[place] - numeric).abs() < 1e-6 * numeric.abs().max(1.0));
        }
        let expected = slope.dot(&(&covariance * &slope)).sqrt();
        // The last step moves the states beyond where they were linearised.
        let std = window.scale_std().unwrap();
        assert!((std / expected - 1.0).abs() < 1e-3, "{std} and {expected}");
    }
}
