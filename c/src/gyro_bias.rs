//! A gyroscope's learned bias on a stream of samples.

use crate::border::{Out, sample, text};
use crate::status::{Fault, Status, call};
use crate::table::{GyroBiasHandle, Table};
use dpn_inertial::{Correction, Model, Running};
use std::ffi::c_char;
use std::path::Path;

static BIASES: Table<Running> = Table::new("gyro_bias");

/// What takes a reading of the gyroscope to a rate: `matrix * reading + bias`. Give it to an estimator as a calibration and a slow bias; no sample is to be corrected by
/// anything quicker.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GyroCorrection {
    /// Row by row.
    pub matrix: [f64; 9],
    /// The calibration's bias, the network's average and what gravity tells beside them [rad/s].
    pub bias: [f64; 3],
    /// Its deviation by axis [rad/s].
    pub deviation: [f64; 3],
    /// 0 until the network has seen as much past as it looks at: the bias is the calibration's then.
    pub known: u8,
    /// 1 while samples come at a rate more than 5 % off the network's: thin or resample them.
    pub wrong_rate: u8,
}

/// Reads a network of `dpn train --model inertial` (network.safetensors), of this very IMU.
///
/// # Safety
/// `path` is null or a string that ends with a zero; `gyro_bias` is null or may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpn_gyro_bias_load(path: *const c_char, gyro_bias: *mut GyroBiasHandle) -> Status {
    call(|| {
        // SAFETY: as the caller promised.
        let (path, out) = unsafe { (text("path", path)?, Out::new("gyro_bias", gyro_bias)?) };
        let model =
            Model::load(Path::new(path)).map_err(|error| Fault(Status::BadWeights, error.to_string()))?;
        out.write(BIASES.put(Running::new(model)));
        Ok(())
    })
}

/// Feeds a sample: its stamp in ns, angular rate [rad/s] and specific force [m/s^2]. One that is refused changes nothing.
///
/// # Safety
/// `gyro` and `accel` are null or point to three doubles each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpn_gyro_bias_feed(
    gyro_bias: GyroBiasHandle,
    t_ns: i64,
    gyro: *const f64,
    accel: *const f64,
) -> Status {
    call(|| {
        // SAFETY: as the caller promised.
        let sample = unsafe { sample(t_ns, gyro, accel)? };
        BIASES.with(gyro_bias, |running| running.feed(&sample).map_err(|error| Fault::bad(error.to_string())))
    })
}

/// Asks what holds at the newest sample.
///
/// # Safety
/// `correction` is null or may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpn_gyro_bias_correction(
    gyro_bias: GyroBiasHandle,
    correction: *mut GyroCorrection,
) -> Status {
    call(|| {
        // SAFETY: as the caller promised.
        let out = unsafe { Out::new("correction", correction)? };
        out.write(BIASES.with(gyro_bias, |running| Ok(GyroCorrection::from(running.correction())))?);
        Ok(())
    })
}

/// Frees it.
#[unsafe(no_mangle)]
pub extern "C" fn dpn_gyro_bias_free(gyro_bias: GyroBiasHandle) -> Status {
    call(|| BIASES.free(gyro_bias))
}

impl From<Correction> for GyroCorrection {
    fn from(of: Correction) -> Self {
        let mut matrix = [0.0; 9];
        matrix.copy_from_slice(of.matrix.transpose().as_slice());
        Self {
            matrix,
            bias: of.bias.into(),
            deviation: of.deviation.into(),
            known: u8::from(of.known),
            wrong_rate: u8::from(of.wrong_rate),
        }
    }
}
