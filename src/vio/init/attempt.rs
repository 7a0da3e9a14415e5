//! One try on a set of frames: gyro bias, structure, alignment, refinement, in this order, each of which may say what it waits for.

use super::align::align;
use super::buffer::Chosen;
use super::config::{InitConfig, TRACK_STD_PX};
use super::frame::shared;
use super::gyro_bias::{self, RotationPair};
use super::outcome::{Initialised, InitialisedFrame, WaitReason};
use super::refine::{Known, Refined, refine};
use super::robust::median;
use super::structure::{self, Input, Structure};
use crate::preint::Preintegration;
use crate::state::{GYRO_BIAS, ImuBias, NavState, ROTATION};
use dpn_core::random::Stream;
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

/// Tracks that two frames must share to say something of the rotation.
const MIN_SHARED: usize = 12;
/// Pairs of frames up to this many apart speak of the gyro's bias.
const PAIR_REACH: usize = 2;
/// The cameras' uncertainty in the alignment, in units of the pair's baseline that the structure is built on.
const CAMERA_STD: f64 = 0.02;
/// Relative deviation of the alignment's scale beyond which refining is not tried.
const HOPELESS_SCALE_STD: f64 = 1.0;
/// Depth of the median point from which the adjustments begin where the linear alignment knows no scale \[m\]; they go on to twice of it.
const BEGIN_DEPTH_M: f64 = 6.0;
/// Time that the frames must span for that \[s\]: an alignment that knows the scale a fifth of a second later errs less, so two tries are left to it.
const BEGIN_SPAN_S: f64 = 1.38;
/// Two adjustments have ended in one place whose sizes differ by no more than this, as a logarithm, or than a share of the deviation that the scale is said to have:
/// the less certain a scale, the slower they arrive.
const SAME: f64 = 0.01;
const SAME_OF_STD: f64 = 0.2;
/// How much larger than its deviation the gyro's bias found from tracks may be off: they agree on a translation, if a wrong one, also
/// where it is small.
const BIAS_STD_INFLATION: f64 = 4.0;
/// What is expected of the gyro's bias after a rest \[rad/s\].
const REST_GYRO_STD: f64 = 5e-3;

/// What is known of the biases before looking.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Expected {
    /// The gyro's mean over a rest \[rad/s\].
    pub gyro_at_rest: Option<Vector3<f64>>,
}

/// States and structure of the `chosen` frames, or what they lack.
pub(super) fn attempt(
    chosen: &Chosen<'_>,
    expected: &Expected,
    body_from_cam: &Isometry3<f64>,
    config: &InitConfig,
    stream: &Stream,
) -> Result<Initialised, WaitReason> {
    let mut preints = chosen.preints.clone();
    let pairs = rotation_pairs(chosen, body_from_cam);
    if pairs.is_empty() {
        return Err(WaitReason::TooFewTracks { shared: 0, needed: MIN_SHARED });
    }
    let integrated_with = *preints[0].bias();
    let (prior, prior_std) = match expected.gyro_at_rest {
        Some(bias) => (bias, REST_GYRO_STD),
        None => (Vector3::zeros(), config.gyro_bias_std),
    };
    let noise = config.angle(TRACK_STD_PX);
    let turned = gyro_bias::fit(
        &pairs,
        &(prior - integrated_with.gyro),
        prior_std,
        noise,
        &mut stream.named("gyro-bias").rng(),
    );
    let bias = ImuBias { accel: integrated_with.accel, gyro: integrated_with.gyro + turned.change };
    preints.iter_mut().for_each(|p| p.reintegrate(bias));

    let rotations = camera_rotations(&preints, &body_from_cam.rotation);
    let input = Input {
        frames: &chosen.frames,
        rotations: &rotations,
        gyro_bias_std: BIAS_STD_INFLATION * turned.std,
    };
    let structure = structure::build(&input, config, &stream.named("structure"))?;
    let known = Known { frames: &chosen.frames, preints: &preints, at_rest: &chosen.at_rest, body_from_cam };
    let refined = metric(&structure, &known, config)?;
    Ok(Initialised {
        frames: chosen
            .frames
            .iter()
            .zip(&refined.states)
            .map(|(frame, state)| InitialisedFrame { t: frame.t, state: *state })
            .collect(),
        bias: refined.states[0].bias,
        scale_std: refined.scale_std,
        gravity_std: refined.gravity_std,
        from_rest: chosen.at_rest.first().copied().unwrap_or(false),
        fit: refined.fit,
    })
}

/// States in metres. The linear alignment makes motions too small, for cameras that are not exact lessen what it sees of them, and an adjustment that begins too
/// small can end where noise of the accelerometer explains what is wrong. So it is begun twice, the second time from twice the size, and both have to end in one
/// place: in the very same where the alignment knows no scale, and they begin at a depth that is anybody's.
fn metric(structure: &Structure, known: &Known<'_>, config: &InitConfig) -> Result<Refined, WaitReason> {
    let uncertain = |relative_std| WaitReason::ScaleUncertain { relative_std, allowed: config.max_scale_std };
    let aligned = |expected| {
        let found =
            align(&structure.cameras, CAMERA_STD, known.preints, known.body_from_cam, config, expected)
                .ok_or(uncertain(f64::INFINITY))?;
        let std = if found.scale > 0.0 { found.scale_std } else { f64::INFINITY };
        if std <= HOPELESS_SCALE_STD { Ok(found) } else { Err(uncertain(std)) }
    };
    let span: f64 = known.preints.iter().map(Preintegration::duration).sum();
    let (first, share) = match aligned(None) {
        Err(_) if span >= BEGIN_SPAN_S => {
            let inverse_depth = median(structure.landmarks.iter().filter_map(|l| l.inverse_depth));
            (aligned(Some(BEGIN_DEPTH_M * inverse_depth))?, 0.0)
        }
        alignment => (alignment?, SAME_OF_STD),
    };
    let found = refine(structure, &first, known, config)?;
    let again = refine(structure, &aligned(Some(2.0 * first.scale))?, known, config)?;
    let apart = (extent(&found.states) / extent(&again.states)).ln().abs();
    if apart <= SAME.max(share * found.scale_std) {
        Ok(found)
    } else {
        Err(uncertain(apart.max(config.max_scale_std)))
    }
}

/// Root of the mean square distance of the positions from their mean \[m\].
fn extent(states: &[NavState]) -> f64 {
    let positions = states.iter().map(|s| s.world_from_body.translation.vector);
    let mean = positions.clone().sum::<Vector3<f64>>() / states.len() as f64;
    (positions.map(|p| (p - mean).norm_squared()).sum::<f64>() / states.len() as f64).sqrt()
}

/// What neighbouring frames and the gyro between them say of its bias.
fn rotation_pairs(chosen: &Chosen<'_>, body_from_cam: &Isometry3<f64>) -> Vec<RotationPair> {
    let r_cb = body_from_cam.rotation.inverse();
    let mut pairs = Vec::new();
    for first in 0..chosen.frames.len() {
        let mut turn = UnitQuaternion::identity();
        let mut d_turn = Matrix3::zeros();
        for second in (first + 1..chosen.frames.len()).take(PAIR_REACH) {
            let preint: &Preintegration = &chosen.preints[second - 1];
            let step = preint.delta().rotation;
            let d_step = preint.jacobian().fixed_view::<3, 3>(ROTATION, GYRO_COLUMN).into_owned();
            // Exp(a) before the step is Exp(step^T a) after it.
            d_turn = step.inverse().to_rotation_matrix().matrix() * d_turn + d_step;
            turn *= step;
            let common = shared(chosen.frames[first], chosen.frames[second]);
            if common.len() >= MIN_SHARED {
                pairs.push(RotationPair {
                    first_from_second: r_cb * turn * r_cb.inverse(),
                    d_rotation_d_bias: r_cb.to_rotation_matrix().matrix() * d_turn,
                    shared: common,
                });
            }
        }
    }
    pairs
}

/// Column of the gyro's bias in a pre-integration's Jacobian.
const GYRO_COLUMN: usize = GYRO_BIAS - crate::state::ACCEL_BIAS;

/// World from camera for every frame, the first body being the world.
fn camera_rotations(
    preints: &[Preintegration],
    body_from_cam: &UnitQuaternion<f64>,
) -> Vec<UnitQuaternion<f64>> {
    let mut world_from_body = UnitQuaternion::identity();
    let mut rotations = vec![*body_from_cam];
    for preint in preints {
        world_from_body =
            UnitQuaternion::new_normalize((world_from_body * preint.delta().rotation).into_inner());
        rotations.push(world_from_body * body_from_cam);
    }
    rotations
}
