//! Both networks on a stream of samples.

use crate::border::{Out, sample};
use crate::status::{Fault, Status, call};
use crate::table::{StreamHandle, Table, WeightsHandle};
use crate::weights::WEIGHTS;
use dpn_core::Sensor;
use dpn_pronet::{DualProNet, SampleStream, StreamSigma};

static STREAMS: Table<SampleStream> = Table::new("stream");

/// How noisy the IMU is at the newest sample: deviations of one sample, by axis.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sigma {
    /// Gyroscope x, y, z [rad/s].
    pub gyro: [f64; 3],
    /// Accelerometer x, y, z [m/s^2].
    pub accel: [f64; 3],
    /// 0 until the first second has passed: the deviations are then VINS-Mono's constants.
    pub known: u8,
    /// 1 where the gyroscope's last window was unlike all of the training, on any axis: its deviations are extrapolated.
    pub gyro_out_of_range: u8,
    /// 1 where the accelerometer's was.
    pub accel_out_of_range: u8,
    /// 1 while samples come at a rate more than 5 % off the networks': thin or resample them.
    pub wrong_rate: u8,
    /// 1 where the spectrum of the gyroscope's last minute says another noise, as behind a low pass: its deviations are not known.
    pub gyro_contradicted: u8,
    /// 1 where the accelerometer's does.
    pub accel_contradicted: u8,
}

/// Makes a stream of two networks, asked every so many samples (10: a camera's frame at 20 Hz).
///
/// # Safety
/// `stream` is null or may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpn_stream_new(
    accel: WeightsHandle,
    gyro: WeightsHandle,
    every: u32,
    stream: *mut StreamHandle,
) -> Status {
    call(|| {
        // SAFETY: as the caller promised.
        let out = unsafe { Out::new("stream", stream)? };
        let accel = WEIGHTS.with(accel, |weights| Ok(weights.clone()))?;
        let gyro = WEIGHTS.with(gyro, |weights| Ok(weights.clone()))?;
        let networks = DualProNet::new("c", &accel, &gyro, every as usize);
        let networks = networks.map_err(|error| Fault::bad(format!("`accel`, `gyro`, `every`: {error}")))?;
        out.write(STREAMS.put(SampleStream::new(networks)));
        Ok(())
    })
}

/// Feeds a sample: its stamp in ns, angular rate [rad/s] and specific force [m/s^2]. One that is refused changes nothing.
///
/// # Safety
/// `gyro` and `accel` are null or point to three doubles each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpn_stream_feed(
    stream: StreamHandle,
    t_ns: i64,
    gyro: *const f64,
    accel: *const f64,
) -> Status {
    call(|| {
        // SAFETY: as the caller promised.
        let sample = unsafe { sample(t_ns, gyro, accel)? };
        STREAMS.with(stream, |stream| stream.feed(sample).map_err(|error| Fault::bad(error.to_string())))
    })
}

/// Asks how noisy the IMU is at the newest sample.
///
/// # Safety
/// `sigma` is null or may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpn_stream_sigma(stream: StreamHandle, sigma: *mut Sigma) -> Status {
    call(|| {
        // SAFETY: as the caller promised.
        let out = unsafe { Out::new("sigma", sigma)? };
        out.write(STREAMS.with(stream, |stream| Ok(Sigma::from(stream.sigma())))?);
        Ok(())
    })
}

/// Frees a stream.
#[unsafe(no_mangle)]
pub extern "C" fn dpn_stream_free(stream: StreamHandle) -> Status {
    call(|| STREAMS.free(stream))
}

impl From<StreamSigma> for Sigma {
    fn from(found: StreamSigma) -> Self {
        let [accel_out, gyro_out] = found.out_of_range.map(u8::from);
        let [accel_against, gyro_against] = found.contradicted.map(u8::from);
        Self {
            gyro: found.noise.of(Sensor::Gyro),
            accel: found.noise.of(Sensor::Accel),
            known: u8::from(found.known),
            gyro_out_of_range: gyro_out,
            accel_out_of_range: accel_out,
            wrong_rate: u8::from(found.wrong_rate),
            gyro_contradicted: gyro_against,
            accel_contradicted: accel_against,
        }
    }
}
