//! Exact ground truth made as bad as published ones are.

use dpn_core::Stamp;
use dpn_core::geometry::so3;
use dpn_core::random::Stream;
use dpn_core::trajectory::StampedPose;
use dpn_core::truth::{GroundTruth, TrueState};
use dpn_sim::SimulatedFlight;
use nalgebra::{Isometry3, Vector3};
use rand::Rng;
use rand_distr::StandardNormal;

/// What is done to the exact poses.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Degradation {
    /// Poses a second.
    pub(crate) rate_hz: f64,
    /// White noise of positions, an axis \[m\].
    pub(crate) position_std_m: f64,
    /// White noise of rotations, an axis \[deg\].
    pub(crate) rotation_std_deg: f64,
    /// Stamps are later than the pose by this \[s\].
    pub(crate) delay_s: f64,
    /// Rotation vector of `body_from_published_body` \[deg\].
    pub(crate) mount_deg: [f64; 3],
    /// Rotation vector of the published world against the true one \[deg\].
    pub(crate) tilt_deg: [f64; 3],
    /// The published origin in the IMU's frame \[m\].
    pub(crate) lever_m: [f64; 3],
    /// Every ten seconds nothing is published for this long \[s\].
    pub(crate) gap_s: f64,
    /// Positions and rotations are means over this, twice \[s\].
    pub(crate) smoothed_s: f64,
}

impl Degradation {
    /// Nothing, at 200 Hz.
    pub(crate) const NONE: Self = Self {
        rate_hz: 200.0,
        position_std_m: 0.0,
        rotation_std_deg: 0.0,
        delay_s: 0.0,
        mount_deg: [0.0; 3],
        tilt_deg: [0.0; 3],
        lever_m: [0.0; 3],
        gap_s: 0.0,
        smoothed_s: 0.0,
    };
    /// White noise of 2 mm and .2 deg.
    pub(crate) const NOISE: Self = Self { position_std_m: 2e-3, rotation_std_deg: 0.2, ..Self::NONE };

    /// The degradations by name, alone with the noise and all together.
    pub(crate) fn all() -> Vec<(&'static str, Self)> {
        let turned = Self {
            mount_deg: [1.0, -2.0, 1.5],
            tilt_deg: [0.5, -0.4, 0.0],
            lever_m: [0.02, -0.01, 0.03],
            ..Self::NOISE
        };
        vec![
            ("noise", Self::NOISE),
            ("late", Self { delay_s: 2.5e-3, ..Self::NOISE }),
            ("turned", turned),
            ("gaps", Self { gap_s: 3.0, ..Self::NOISE }),
            ("20 Hz", Self { rate_hz: 20.0, ..Self::NOISE }),
            (
                "smoothed",
                Self { smoothed_s: 0.1, position_std_m: 3e-4, rotation_std_deg: 0.03, ..Self::NONE },
            ),
            ("all", Self { delay_s: 2.5e-3, gap_s: 3.0, rate_hz: 60.0, smoothed_s: 0.05, ..turned }),
        ]
    }

    /// The flight's poses, degraded.
    pub(crate) fn of(&self, flight: &SimulatedFlight, seed: u64) -> GroundTruth {
        let mut rng = Stream::new(seed).named("degraded truth").rng();
        let first = flight.recording.samples()[0].t;
        let duration = flight.trajectory.duration();
        let rotation = |degrees: [f64; 3]| so3::exp(&Vector3::from(degrees).map(f64::to_radians));
        let (mount, tilt) = (rotation(self.mount_deg), rotation(self.tilt_deg));
        let count = ((duration - 0.5) * self.rate_hz) as usize;
        let states = (0..count).filter_map(|i| {
            let stamp = 0.25 + i as f64 / self.rate_hz;
            let mut noise = |std: f64| Vector3::from_fn(|_, _| std * rng.sample::<f64, _>(StandardNormal));
            let (dp, dr) = (noise(self.position_std_m), noise(self.rotation_std_deg.to_radians()));
            if stamp % 10.0 > 10.0 - self.gap_s {
                return None;
            }
            let exact = self.smoothed(flight, stamp - self.delay_s);
            let origin = exact.translation.vector + exact.rotation * Vector3::from(self.lever_m);
            let pose = Isometry3::from_parts(
                (tilt * origin + dp).into(),
                tilt * exact.rotation * mount * so3::exp(&dr),
            );
            Some(state(StampedPose { t: first.plus_seconds(stamp), world_from_body: pose }))
        });
        GroundTruth::new(states.collect()).unwrap()
    }

    /// A mean of means: a triangle.
    fn smoothed(&self, flight: &SimulatedFlight, at: f64) -> Isometry3<f64> {
        let middle = flight.trajectory.pose(at);
        if self.smoothed_s == 0.0 {
            return middle;
        }
        const HALF: i32 = 20;
        let (mut position, mut turn, mut sum) = (Vector3::zeros(), Vector3::zeros(), 0.0);
        for i in -HALF..=HALF {
            let share = f64::from(i) / f64::from(HALF);
            let pose = flight.trajectory.pose(at + share * self.smoothed_s);
            let weight = 1.0 - share.abs();
            position += weight * pose.translation.vector;
            turn += weight * so3::log(&(middle.rotation.inverse() * pose.rotation));
            sum += weight;
        }
        Isometry3::from_parts((position / sum).into(), middle.rotation * so3::exp(&(turn / sum)))
    }
}

/// A pose as ground truth holds it.
pub(crate) fn state(pose: StampedPose) -> TrueState {
    TrueState { t: pose.t, world_from_body: pose.world_from_body, vel_in_world: None, biases: None }
}

/// Root mean square difference of `truth` to the flight: position, all axes together \[m\], rotation \[deg\]; and the share of the flight it covers.
pub(crate) fn against(truth: &GroundTruth, flight: &SimulatedFlight) -> (f64, f64, f64) {
    let first: Stamp = flight.recording.samples()[0].t;
    let (mut position, mut rotation) = (0.0, 0.0);
    for state in truth.states() {
        let exact = flight.trajectory.pose(state.t.seconds_since(first));
        position += (state.world_from_body.translation.vector - exact.translation.vector).norm_squared();
        rotation += so3::log(&(exact.rotation.inverse() * state.world_from_body.rotation)).norm_squared();
    }
    let n = truth.states().len() as f64;
    ((position / n).sqrt(), (rotation / n).sqrt().to_degrees(), n / flight.recording.len() as f64)
}
