//! A recording and the true rotation at its samples.

use dpn_core::geometry::so3;
use dpn_core::signal::stats::median;
use dpn_core::trajectory::StampedPose;
use dpn_core::{ImuRecording, ImuSample, SampleRate, Stamp};
use dpn_truth::interpolated;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use thiserror::Error;

/// A longer step between poses is a gap \[s\].
const LONGEST_GAP_S: f64 = 0.06;
/// A step between samples that is longer than so many periods is a gap.
const LONGEST_STEP: f64 = 2.5;
/// The least share of the samples that must have a truth.
const LEAST_SHARE: f64 = 0.5;
/// A truth whose steps vary less about the gyroscope's than by this share of the gyroscope's own variation is made from it.
const FOLLOWS: f64 = 0.2;

/// Why a recording and a trajectory are no course.
#[derive(Debug, Error, PartialEq)]
pub enum CourseError {
    /// Too little truth.
    #[error(
        "{name}: the trajectory says where the body was at {percent:.0} % of the samples, and a score of so little would be another recording's; \
         give a trajectory of the same clock over more than half of it (dpn noise LOG --against FILE finds a delay)"
    )]
    LittleTruth {
        /// The recording.
        name: String,
        /// Samples with a truth.
        percent: f64,
    },
}

/// Samples from the first to the last with a truth, all in the IMU's frame.
#[derive(Debug, Clone)]
pub struct Course {
    /// What it is called.
    pub name: String,
    /// Its rate.
    pub rate: SampleRate,
    /// Angular rates as read \[rad/s\].
    pub gyro: Vec<Vector3<f64>>,
    /// Specific forces as read \[m/s^2\].
    pub accel: Vec<Vector3<f64>>,
    /// From each sample to the next \[s\]; one less than samples.
    pub step_s: Vec<f64>,
    /// The true pose at each sample; none in gaps of the trajectory.
    pub truth: Vec<Option<Isometry3<f64>>>,
    /// SHA-256 of the recording.
    pub checksum: String,
}

impl Course {
    /// Joins a recording and a trajectory of its body's frame and clock.
    ///
    /// # Errors
    /// A trajectory that lies beside less than half of the recording.
    pub fn new(name: &str, recording: &ImuRecording, poses: &[StampedPose]) -> Result<Self, CourseError> {
        let samples = recording.samples();
        let truth: Vec<_> = samples.iter().map(|s| interpolated(poses, s.t, LONGEST_GAP_S)).collect();
        let known = truth.iter().flatten().count();
        let share = known as f64 / samples.len() as f64;
        let ends = truth.iter().position(Option::is_some).zip(truth.iter().rposition(Option::is_some));
        let Some((first, last)) = ends.filter(|_| share >= LEAST_SHARE) else {
            return Err(CourseError::LittleTruth { name: name.to_owned(), percent: 100.0 * share });
        };
        let within = &samples[first..=last];
        Ok(Self {
            name: name.to_owned(),
            rate: recording.rate(),
            gyro: within.iter().map(|s| s.gyro.into()).collect(),
            accel: within.iter().map(|s| s.accel.into()).collect(),
            step_s: within.windows(2).map(|pair| pair[1].t.seconds_since(pair[0].t)).collect(),
            truth: truth[first..=last].to_vec(),
            checksum: recording.checksum(),
        })
    }

    /// How many samples there are.
    pub fn len(&self) -> usize {
        self.gyro.len()
    }

    /// Whether there are none; never.
    pub fn is_empty(&self) -> bool {
        self.gyro.is_empty()
    }

    /// The samples from `from` on, as read; the first one at time 0.
    pub fn samples(&self, from: usize) -> impl Iterator<Item = ImuSample> {
        let mut seconds = 0.0;
        (from..self.len()).map(move |i| {
            let t = Stamp::from_ns((1e9 * seconds) as i64);
            // No step follows the last one.
            seconds += self.step_s.get(i).unwrap_or(&0.0);
            ImuSample { t, gyro: self.gyro[i].into(), accel: self.accel[i].into() }
        })
    }

    /// The gyroscope's reading in the middle between a sample and the next. Readings that are held until the next come half a step late, which was two fifths of a calibration's error in TUM-VI's rooms.
    pub(crate) fn middle(&self, i: usize) -> Vector3<f64> {
        0.5 * (self.gyro[i] + self.gyro[i + 1])
    }

    /// The true turn from sample `from` to `to`; none where one of them has no truth or samples are missing between.
    pub fn turn(&self, from: usize, to: usize) -> Option<UnitQuaternion<f64>> {
        let (a, b) = ((*self.truth.get(from)?)?, (*self.truth.get(to)?)?);
        let longest = LONGEST_STEP * self.rate.period();
        let is_whole = self.step_s[from..to].iter().all(|step| *step < longest);
        is_whole.then(|| a.rotation.inverse() * b.rotation)
    }

    /// Whether the truth was made from this gyroscope: from sample to sample it turns as the mid-point of two readings does, to less than the readings
    /// vary. A likelihood of rotation then judges how the truth was made.
    pub fn truth_follows_gyro(&self) -> bool {
        let (mut read, mut slow) = (Vec::new(), Vec::new());
        for i in 0..self.len() - 1 {
            let Some(turn) = self.turn(i, i + 1) else { continue };
            let middle = self.middle(i);
            read.push(middle);
            slow.push(so3::log(&turn) / self.step_s[i] - middle);
        }
        let change = |rates: &[Vector3<f64>]| {
            let all: Vec<f64> = rates.windows(2).map(|pair| (pair[1] - pair[0]).norm()).collect();
            if all.is_empty() { f64::NAN } else { median(&all) }
        };
        change(&slow) < FOLLOWS * change(&read)
    }
}

/// A course that turns about all axes, its gyroscope read through `matrix` and `bias`: for tests.
#[cfg(test)]
pub(crate) fn simulated(
    seconds: f64,
    matrix: nalgebra::Matrix3<f64>,
    bias: Vector3<f64>,
    noise: f64,
) -> Course {
    use dpn_core::random::Stream;
    use rand_distr::{Distribution, StandardNormal};
    let (hz, count) = (200.0, (200.0 * seconds) as usize);
    let mut rng = Stream::new(5).named("course").rng();
    let mut rotation = UnitQuaternion::identity();
    let (mut samples, mut poses) = (Vec::new(), Vec::new());
    for i in 0..count {
        let s = i as f64 / hz;
        let rate_at =
            |s: f64| Vector3::new((1.1 * s).sin(), 0.7 * (1.7 * s).cos(), 0.5 * (0.6 * s + 1.0).sin());
        let rate = rate_at(s);
        let t = Stamp::from_ns(i as i64 * 5_000_000);
        let white = Vector3::from_fn(|_, _| -> f64 { StandardNormal.sample(&mut rng) });
        let read = matrix * rate + bias + noise * white;
        let force = rotation.inverse() * Vector3::new(0.0, 0.0, dpn_core::GRAVITY);
        samples.push(ImuSample { t, gyro: read.into(), accel: force.into() });
        poses.push(StampedPose {
            t,
            world_from_body: Isometry3::from_parts(Vector3::zeros().into(), rotation),
        });
        rotation *= so3::exp(&(rate_at(s + 0.5 / hz) / hz));
    }
    Course::new("simulated", &ImuRecording::new(samples).unwrap(), &poses).unwrap()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;

    #[test]
    fn half_a_recording_without_truth_is_refused_and_a_truth_of_the_gyroscopes_own_steps_is_named() {
        let course = simulated(20.0, Matrix3::identity(), Vector3::zeros(), 0.01);
        assert!(!course.truth_follows_gyro());
        let mut made = course.clone();
        let mut rotation = UnitQuaternion::identity();
        for i in 0..made.len() {
            made.truth[i] = Some(Isometry3::from_parts(Vector3::zeros().into(), rotation));
            if i + 1 < made.len() {
                rotation *= so3::exp(&(0.5 * (made.gyro[i] + made.gyro[i + 1]) * made.step_s[i]));
            }
        }
        assert!(made.truth_follows_gyro());
        let samples =
            (0..400).map(|i| ImuSample { t: Stamp::from_ns(i * 5_000_000), gyro: [0.0; 3], accel: [0.0; 3] });
        let recording = ImuRecording::new(samples.collect()).unwrap();
        let pose = |ns| StampedPose { t: Stamp::from_ns(ns), world_from_body: Isometry3::identity() };
        let poses: Vec<_> = (0..18).map(|i| pose(i * 50_000_000)).collect();
        let error = Course::new("short", &recording, &poses).unwrap_err();
        assert!(error.to_string().contains("43 % of the samples"), "{error}");
    }
}
