//! Networks: from a file, from bytes, shipped.

use crate::border::{Out, bytes, text};
use crate::status::{Fault, Status, call};
use crate::table::{Table, WeightsHandle};
use dpn_pronet::Weights;
use std::ffi::c_char;
use std::path::Path;

pub(crate) static WEIGHTS: Table<Weights> = Table::new("weights");

/// One of the two inertial sensors.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sensor {
    /// Accelerometer.
    Accel = 0,
    /// Gyroscope.
    Gyro = 1,
}

/// The bytes of the network that comes with the library.
pub(crate) fn shipped(sensor: dpn_core::Sensor) -> &'static [u8] {
    match sensor {
        dpn_core::Sensor::Accel => include_bytes!("../../models/accel/sg11-s0.safetensors"),
        dpn_core::Sensor::Gyro => include_bytes!("../../models/gyro/sg11-s0.safetensors"),
    }
}

fn bad(error: impl std::fmt::Display) -> Fault {
    Fault(Status::BadWeights, error.to_string())
}

/// Reads a network from a file (.safetensors, as dpn ships and trains them).
///
/// # Safety
/// `path` is null or a string that ends with a zero; `weights` is null or may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpn_weights_load(path: *const c_char, weights: *mut WeightsHandle) -> Status {
    call(|| {
        // SAFETY: as the caller promised.
        let (path, out) = unsafe { (text("path", path)?, Out::new("weights", weights)?) };
        out.write(WEIGHTS.put(Weights::load(Path::new(path)).map_err(bad)?));
        Ok(())
    })
}

/// Reads a network from `length` bytes of such a file.
///
/// # Safety
/// `data` is null or points to `length` bytes; `weights` is null or may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpn_weights_from_bytes(
    data: *const u8,
    length: usize,
    weights: *mut WeightsHandle,
) -> Status {
    call(|| {
        // SAFETY: as the caller promised.
        let (data, out) = unsafe { (bytes("data", data, length)?, Out::new("weights", weights)?) };
        out.write(WEIGHTS.put(Weights::from_bytes(data, Path::new("data")).map_err(bad)?));
        Ok(())
    })
}

/// The network of a sensor (a `dpn_sensor`) that comes with the library, for samples at 200 Hz.
///
/// # Safety
/// `weights` is null or may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpn_weights_shipped(sensor: u32, weights: *mut WeightsHandle) -> Status {
    call(|| {
        // SAFETY: as the caller promised.
        let out = unsafe { Out::new("weights", weights)? };
        let data = match sensor {
            0 => shipped(dpn_core::Sensor::Accel),
            1 => shipped(dpn_core::Sensor::Gyro),
            other => {
                let words = "expected DPN_SENSOR_ACCEL (0) or DPN_SENSOR_GYRO (1)";
                return Err(Fault::bad(format!("`sensor` is {other}; {words}")));
            }
        };
        out.write(WEIGHTS.put(Weights::from_bytes(data, Path::new("shipped")).map_err(bad)?));
        Ok(())
    })
}

/// Frees a network. Streams that were made with it go on.
#[unsafe(no_mangle)]
pub extern "C" fn dpn_weights_free(weights: WeightsHandle) -> Status {
    call(|| WEIGHTS.free(weights))
}
