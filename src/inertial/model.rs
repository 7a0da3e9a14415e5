//! A trained network with what it needs to be used rightly, in a file.

use crate::affine::{Fitted, UNKNOWN_SPREAD};
use crate::config::InertialConfig;
use crate::course::Course;
use crate::network;
use dpn_core::SampleRate;
use dpn_core::config::Validate;
use dpn_core::signal::stats::{Ddof, deviation, mean};
use dpn_pronet::StoreError;
use dpn_pronet::store::{self, Named};
use nalgebra::{DMatrix, Vector3};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What its file calls itself.
const FORMAT: &str = "dpn-inertial-network";
/// One unit of an answer \[rad/s\]: degrees a second, about.
pub(crate) const UNIT: f64 = 0.01;
/// What it says of itself.
pub(crate) const USE: &str = "a slow bias of this very IMU: average it over `average_s`, add it to the affine rate as a bias with a deviation; never hand single corrected samples to an odometry";

/// What stands beside the weights.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Card {
    /// How it is to be used.
    pub usage: String,
    /// How it was trained.
    pub config: InertialConfig,
    /// The affine calibration it starts from.
    pub affine: crate::Affine,
    /// How far the training recordings' biases lie apart, a deviation by axis \[rad/s\].
    #[serde(default = "unknown_spread")]
    pub spread: [f64; 3],
    /// Means of the six axes, gyroscope first, that are taken from readings,
    pub mean: [f64; 6],
    /// and deviations that they are divided by.
    pub deviation: [f64; 6],
    /// Rate of its samples.
    pub rate: SampleRate,
    /// Checksums of the recordings it was trained on.
    pub data: Vec<String>,
}

fn unknown_spread() -> [f64; 3] {
    [UNKNOWN_SPREAD; 3]
}

/// A network.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// What to know about it.
    pub card: Card,
    pub(crate) parameters: Vec<f32>,
}

impl Model {
    /// One before its training.
    pub(crate) fn new(
        config: &InertialConfig,
        fitted: &Fitted,
        courses: &[Course],
        parameters: Vec<f32>,
    ) -> Self {
        let axis = |i: usize| {
            let of = |course: &Course| (0..course.len()).map(|s| axis_of(course, s, i)).collect::<Vec<_>>();
            courses.iter().flat_map(of).collect::<Vec<_>>()
        };
        let axes: [Vec<f64>; 6] = std::array::from_fn(axis);
        let card = Card {
            usage: USE.to_owned(),
            config: config.clone(),
            affine: fitted.affine,
            spread: fitted.spread,
            mean: axes.each_ref().map(|axis| mean(axis)),
            deviation: axes.each_ref().map(|axis| deviation(axis, Ddof::Zero).max(1e-6)),
            rate: courses[0].rate,
            data: courses.iter().map(|course| course.checksum.clone()).collect(),
        };
        Self { card, parameters }
    }

    /// What is to be added to the affine rate at each sample \[rad/s\]; before the first sample that one stood still.
    pub fn corrections(&self, course: &Course) -> Vec<Vector3<f64>> {
        let answers = course.len().div_ceil(network::STRIDE);
        let samples = DMatrix::from_fn(6, network::samples_for(answers), |row, column| {
            let sample = (column + 1).saturating_sub(network::PAST).min(course.len() - 1);
            self.seen(row, axis_of(course, sample, row))
        });
        let (out, _) = network::forward(&self.parameters, samples);
        let at = |i: usize| out.column(i / network::STRIDE).map(|v| UNIT * f64::from(v));
        (0..course.len()).map(|i| at(i).fixed_rows::<3>(0).into()).collect()
    }

    /// A reading as the network sees it.
    pub(crate) fn seen(&self, axis: usize, value: f64) -> f32 {
        ((value - self.card.mean[axis]) / self.card.deviation[axis]) as f32
    }

    /// The bytes of its file.
    ///
    /// # Errors
    /// None that is known: a card is JSON.
    pub fn to_bytes(&self) -> Result<Vec<u8>, StoreError> {
        let named = |(name, shape, place): (String, Vec<usize>, std::ops::Range<usize>)| Named {
            numbers: self.parameters[place].to_vec(),
            name,
            shape,
        };
        let tensors: Vec<Named> = network::parameters().into_iter().map(named).collect();
        store::to_bytes(FORMAT, &self.card, &tensors, Path::new("network"))
    }

    /// Reads its file.
    ///
    /// # Errors
    /// One that cannot be read, another file, a damaged one.
    pub fn load(path: &Path) -> Result<Self, StoreError> {
        Self::from_bytes(&store::read(path)?, path)
    }

    /// Takes a file's bytes; `path` is for messages.
    ///
    /// # Errors
    /// Another file; a damaged one.
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Self, StoreError> {
        let (card, mut tensors): (Card, _) = store::from_bytes(FORMAT, bytes, path)?;
        let unusable = |detail: String| StoreError::Description { path: path.to_owned(), detail };
        card.config.validate().map_err(|e| unusable(e.to_string()))?;
        if !card.deviation.iter().all(|d| *d > 0.0) || !card.spread.iter().all(|d| *d >= 0.0 && d.is_finite())
        {
            return Err(unusable(format!("deviations of {:?} and {:?}", card.deviation, card.spread)));
        }
        let mut parameters = Vec::with_capacity(network::count());
        for (name, shape, _) in network::parameters() {
            parameters.extend(store::take(&mut tensors, &name, &shape, path)?);
        }
        store::nothing_left(&tensors, path)?;
        Ok(Self { card, parameters })
    }
}

/// One axis of a sample, gyroscope first.
pub(crate) fn axis_of(course: &Course, sample: usize, axis: usize) -> f64 {
    if axis < 3 { course.gyro[sample][axis] } else { course.accel[sample][axis - 3] }
}
