//! Both networks on a stream of samples.

use crate::border::{Out, axes};
use crate::status::{Fault, Status, call};
use crate::table::{StreamHandle, Table, WeightsHandle};
use crate::weights::WEIGHTS;
use dpn_core::{ImuNoise, ImuSample, NoiseModel, Sensor, Stamp};
use dpn_pronet::DualProNet;

/// A rate further off than this is another rate.
const RATE_TOLERANCE: f64 = 0.05;
/// The rate is that of so many samples \[s\].
const RATE_OVER_S: f64 = 1.0;

struct Stream {
    networks: DualProNet,
    noise: ImuNoise,
    last: Option<Stamp>,
    /// Where the present count of samples began, and how many came since.
    counted: (Stamp, u32),
    wrong_rate: bool,
    /// Windows judged so far and those out of range, accelerometer and gyroscope.
    judged: [(u64, u64); 2],
    out_of_range: [bool; 2],
}

static STREAMS: Table<Stream> = Table::new("stream");

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
        out.write(STREAMS.put(Stream {
            networks,
            noise: ImuNoise::baseline(),
            last: None,
            counted: (Stamp::from_ns(0), 0),
            wrong_rate: false,
            judged: [(0, 0); 2],
            out_of_range: [false; 2],
        }));
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
        let (gyro, accel) = unsafe { (axes("gyro", gyro)?, axes("accel", accel)?) };
        STREAMS.with(stream, |stream| stream.feed(ImuSample { t: Stamp::from_ns(t_ns), gyro, accel }))
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
        out.write(STREAMS.with(stream, |stream| Ok(stream.sigma()))?);
        Ok(())
    })
}

/// Frees a stream.
#[unsafe(no_mangle)]
pub extern "C" fn dpn_stream_free(stream: StreamHandle) -> Status {
    call(|| STREAMS.free(stream))
}

impl Stream {
    fn feed(&mut self, sample: ImuSample) -> Result<(), Fault> {
        if let Some(last) = self.last.filter(|last| sample.t <= *last) {
            let (t, last) = (sample.t.ns(), last.ns());
            return Err(Fault::bad(format!("`t_ns` is {t} after {last}; stamps must increase")));
        }
        self.rate(sample.t);
        self.last = Some(sample.t);
        self.noise = self.networks.feed(&sample);
        for (k, sensor) in Sensor::ALL.into_iter().enumerate() {
            let count = self.networks.range_count(sensor);
            let (windows, outside) = self.judged[k];
            if count.windows > windows {
                self.out_of_range[k] = count.outside > outside;
                self.judged[k] = (count.windows, count.outside);
            }
        }
        Ok(())
    }

    /// Counts samples by the second.
    fn rate(&mut self, t: Stamp) {
        let (from, count) = &mut self.counted;
        if self.last.is_none() {
            *from = t;
            return;
        }
        *count += 1;
        let seconds = t.seconds_since(*from);
        if seconds >= RATE_OVER_S {
            let share = f64::from(*count) / seconds / self.networks.trained_rate().hz();
            self.wrong_rate = (share - 1.0).abs() > RATE_TOLERANCE;
            self.counted = (t, 0);
        }
    }

    fn sigma(&self) -> Sigma {
        let [accel_out, gyro_out] = self.out_of_range.map(u8::from);
        Sigma {
            gyro: self.noise.of(Sensor::Gyro),
            accel: self.noise.of(Sensor::Accel),
            known: u8::from(self.judged.iter().all(|(windows, _)| *windows > 0)),
            gyro_out_of_range: gyro_out,
            accel_out_of_range: accel_out,
            wrong_rate: u8::from(self.wrong_rate),
        }
    }
}
