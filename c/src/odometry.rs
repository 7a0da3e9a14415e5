//! The odometry: settings in, samples and images or tracks in, poses and the IMU's noise out.

use crate::border::{Out, bytes, image, sample, text, values};
use crate::status::{Fault, Status, call, kept};
use crate::table::{OdometryHandle, Table};
use crate::weights::shipped;
use dpn_core::estimate::DEFAULT_TAG;
use dpn_core::{Sensor, Stamp};
use dpn_live::{LiveError, NoiseInForce, Odometry, OdometryConfig};
use dpn_pronet::network::Network;
use dpn_vio::estimator;
use std::ffi::c_char;
use std::path::Path;

static ODOMETRIES: Table<Odometry> = Table::new("odometry");

/// What an odometry is doing.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Waiting until the first states can be told.
    Initialising = 0,
    /// Estimating.
    Tracking = 1,
    /// Given up at this frame; the next ones initialise again.
    Restarted = 2,
}

/// What came of a frame. World z up, body = IMU; NaN where nothing is known.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Update {
    /// The frame's stamp on the IMU's clock, in ns.
    pub t_ns: i64,
    /// What the odometry is doing.
    pub phase: Phase,
    /// 1 where the frame has a pose.
    pub known: u8,
    /// Tracks that went on from earlier frames.
    pub tracked: u32,
    /// Landmarks with a depth.
    pub landmarks: u32,
    /// Of the body in the world, in m.
    pub position: [f64; 3],
    /// World from body, Hamilton quaternion w, x, y, z.
    pub orientation: [f64; 4],
    /// In the world [m/s].
    pub velocity: [f64; 3],
    /// Of the accelerometer [m/s^2].
    pub accel_bias: [f64; 3],
    /// Of the gyroscope [rad/s].
    pub gyro_bias: [f64; 3],
    /// Of the pose as believed, row by row: position, then rotation on the right. Known with `covariance = true` below `[estimator]`.
    pub covariance: [f64; 36],
    /// Relative standard deviation of the scale, as believed.
    pub scale_std: f64,
    /// By what the noise told is multiplied from here on: accelerometer x, y, z, gyroscope x, y, z, walks of their biases, pixel. Known where it is learned.
    pub levels: [f64; 9],
}

/// The IMU's noise as it is in force: what was told times what was learned.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Rate of the samples in Hz: a density is a deviation over its root.
    pub rate_hz: f64,
    /// Deviation of a gyroscope's sample, x, y, z [rad/s].
    pub gyro: [f64; 3],
    /// Deviation of an accelerometer's sample, x, y, z [m/s^2].
    pub accel: [f64; 3],
    /// Walk of the gyroscope's bias [rad/s^2/sqrt(Hz)].
    pub gyro_walk: f64,
    /// Walk of the accelerometer's bias [m/s^3/sqrt(Hz)].
    pub accel_walk: f64,
    /// Deviation of a pixel, in px.
    pub pixel: f64,
    /// How unsure the learned ones are, as deviations of their logarithms: accelerometer x, y, z, gyroscope x, y, z, the two walks; 1 and more where next to
    /// nothing is known; NaN where nothing is learned.
    pub unsure: [f64; 8],
}

fn words(error: &LiveError) -> String {
    match error.hint() {
        Some(hint) => format!("{error}; {hint}"),
        None => error.to_string(),
    }
}

fn bad(error: LiveError) -> Fault {
    Fault::bad(words(&error))
}

/// Makes an odometry of a TOML text:
///
/// ```toml
/// calibration = "cam0/sensor.yaml"   # of the camera: a file of Kalibr, OpenVINS, VINS, ORB-SLAM3, Basalt, OKVIS or ASL, or a table with its keys
/// camera = "images"                  # or "tracks", of a front-end of your own
/// noise = "self"                     # learned while it runs; or figures, "const(0.05,0.004)": m/s^2 and rad/s a sample
/// seed = 0
/// [estimator]                        # settings as `dpn run --config` has them
/// covariance = true
/// ```
///
/// All but `calibration` may be left out. All work is done in the calls, by the thread that makes them.
///
/// # Safety
/// `settings` is null or a string that ends with a zero; `odometry` is null or may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpn_odometry_new(settings: *const c_char, odometry: *mut OdometryHandle) -> Status {
    call(|| {
        // SAFETY: as the caller promised.
        let (settings, out) = unsafe { (text("settings", settings)?, Out::new("odometry", odometry)?) };
        let made = OdometryConfig::parse(settings).and_then(|config| Odometry::new(&config, networks()));
        out.write(ODOMETRIES.put(made.map_err(|error| Fault(Status::BadSettings, words(&error)))?));
        Ok(())
    })
}

/// Those that come with the library, by the name that `dualpronet` has for them.
fn networks() -> Vec<Network> {
    let network = |sensor: Sensor| {
        let name = format!("models/{}/{DEFAULT_TAG}.safetensors", sensor.name());
        Network::from_bytes(shipped(sensor), Path::new(&name)).expect("it is tested to be a network")
    };
    Sensor::ALL.map(network).into()
}

/// Feeds a sample: its stamp in ns, angular rate [rad/s] and specific force [m/s^2]. One that is refused changes nothing.
///
/// # Safety
/// `gyro` and `accel` are null or point to three doubles each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpn_odometry_imu(
    odometry: OdometryHandle,
    t_ns: i64,
    gyro: *const f64,
    accel: *const f64,
) -> Status {
    call(|| {
        // SAFETY: as the caller promised.
        let sample = unsafe { sample(t_ns, gyro, accel)? };
        ODOMETRIES.with(odometry, |odometry| odometry.feed_sample(sample).map_err(bad))
    })
}

/// Feeds a grey image of 8 bits: the camera's stamp in ns, and rows of `width` bytes that begin `stride` bytes apart. It is copied; one that is refused changes
/// nothing. Samples and images may come in any order between the two, each in increasing time.
///
/// # Safety
/// `pixels` is null or points to `height` such rows.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpn_odometry_image(
    odometry: OdometryHandle,
    t_ns: i64,
    pixels: *const u8,
    width: usize,
    height: usize,
    stride: usize,
) -> Status {
    call(|| {
        // SAFETY: as the caller promised.
        let image = unsafe { image(pixels, [width, height, stride])? };
        ODOMETRIES.with(odometry, |odometry| odometry.feed_image(Stamp::from_ns(t_ns), image).map_err(bad))
    })
}

/// Feeds an image as a file or a message has it: the bytes of a PNG or JPEG.
///
/// # Safety
/// `data` is null or points to `length` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpn_odometry_encoded(
    odometry: OdometryHandle,
    t_ns: i64,
    data: *const u8,
    length: usize,
) -> Status {
    call(|| {
        // SAFETY: as the caller promised.
        let data = unsafe { bytes("data", data, length)? };
        ODOMETRIES.with(odometry, |odometry| odometry.feed_encoded(Stamp::from_ns(t_ns), data).map_err(bad))
    })
}

/// Feeds the tracks of a frame, where the settings say `camera = "tracks"`: `count` ids, each at most once and for ever the same point's, and as many pairs
/// x, y: distorted pixels, or where `normalised` is not 0 the points x / z, y / z of the camera's frame.
///
/// # Safety
/// `ids` and `points` are null or point to `count` numbers and pairs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpn_odometry_tracks(
    odometry: OdometryHandle,
    t_ns: i64,
    ids: *const u64,
    points: *const f64,
    count: usize,
    normalised: u8,
) -> Status {
    call(|| {
        // SAFETY: as the caller promised; a pair of doubles is two of them.
        let (ids, points) =
            unsafe { (values("ids", ids, count)?, values("points", points.cast::<[f64; 2]>(), count)?) };
        let tracks = ids.into_iter().zip(points);
        ODOMETRIES.with(odometry, |odometry| {
            odometry.feed_tracks(Stamp::from_ns(t_ns), tracks, normalised != 0).map_err(bad)
        })
    })
}

/// Says that nothing more comes: points are followed into the last images too.
#[unsafe(no_mangle)]
pub extern "C" fn dpn_odometry_end(odometry: OdometryHandle) -> Status {
    call(|| ODOMETRIES.with(odometry, |odometry| odometry.end().map_err(bad)))
}

/// Works off the next frame whose samples are all there; `DPN_STATUS_NOT_YET` where there is none. To be called until then after every image or frame.
///
/// # Safety
/// `update` is null or may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpn_odometry_update(odometry: OdometryHandle, update: *mut Update) -> Status {
    call(|| {
        // SAFETY: as the caller promised.
        let out = unsafe { Out::new("update", update)? };
        let update = ODOMETRIES.with(odometry, |odometry| Ok(odometry.next_update()))?;
        out.write(update.map(|update| Update::from(&update)).ok_or_else(not_yet)?);
        Ok(())
    })
}

/// Asks for the IMU's noise in force; `DPN_STATUS_NOT_YET` until the samples' rate is known.
///
/// # Safety
/// `noise` is null or may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpn_odometry_noise(odometry: OdometryHandle, noise: *mut Noise) -> Status {
    call(|| {
        // SAFETY: as the caller promised.
        let out = unsafe { Out::new("noise", noise)? };
        let noise = ODOMETRIES.with(odometry, |odometry| Ok(odometry.noise()))?;
        out.write(noise.map(Noise::from).ok_or_else(not_yet)?);
        Ok(())
    })
}

/// Asks what is waited for; an empty string while poses come. The string lasts until this thread asks for another by this function or the next.
///
/// # Safety
/// `words` is null or may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpn_odometry_waiting(odometry: OdometryHandle, words: *mut *const c_char) -> Status {
    call(|| {
        // SAFETY: as the caller promised.
        let out = unsafe { Out::new("words", words)? };
        let waiting = ODOMETRIES.with(odometry, |odometry| Ok(odometry.waiting()))?;
        out.write(kept(&waiting.unwrap_or_default()));
        Ok(())
    })
}

/// Asks what seems to be wrong with the input: one remark after the other, then `DPN_STATUS_NOT_YET`.
///
/// # Safety
/// `words` is null or may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpn_odometry_warning(odometry: OdometryHandle, words: *mut *const c_char) -> Status {
    call(|| {
        // SAFETY: as the caller promised.
        let out = unsafe { Out::new("words", words)? };
        let warning = ODOMETRIES.with(odometry, |odometry| Ok(odometry.take_warning()))?;
        out.write(kept(&warning.ok_or_else(not_yet)?));
        Ok(())
    })
}

/// Frees an odometry.
#[unsafe(no_mangle)]
pub extern "C" fn dpn_odometry_free(odometry: OdometryHandle) -> Status {
    call(|| ODOMETRIES.free(odometry))
}

fn not_yet() -> Fault {
    Fault(Status::NotYet, String::new())
}

impl From<&estimator::Update> for Update {
    fn from(update: &estimator::Update) -> Self {
        let mut made = Self {
            t_ns: update.t.ns(),
            phase: match update.phase {
                estimator::Phase::Initialising(_) => Phase::Initialising,
                estimator::Phase::Tracking => Phase::Tracking,
                estimator::Phase::Restarted(_) => Phase::Restarted,
            },
            known: u8::from(update.state.is_some()),
            tracked: update.tracked,
            landmarks: update.landmarks,
            position: [f64::NAN; 3],
            orientation: [f64::NAN; 4],
            velocity: [f64::NAN; 3],
            accel_bias: [f64::NAN; 3],
            gyro_bias: [f64::NAN; 3],
            covariance: [f64::NAN; 36],
            scale_std: update.scale_std.unwrap_or(f64::NAN),
            levels: [f64::NAN; 9],
        };
        if let Some(state) = &update.state {
            let q = state.world_from_body.rotation;
            made.position = state.world_from_body.translation.vector.into();
            made.orientation = [q.w, q.i, q.j, q.k];
            made.velocity = state.vel_in_world.into();
            made.accel_bias = state.bias.accel.into();
            made.gyro_bias = state.bias.gyro.into();
        }
        if let Some(covariance) = &update.covariance {
            made.covariance.copy_from_slice(covariance.transpose().as_slice());
        }
        if let Some(levels) = &update.levels {
            made.levels[..8].copy_from_slice(&levels.inertial.0);
            made.levels[8] = levels.pixel;
        }
        made
    }
}

impl From<NoiseInForce> for Noise {
    fn from(noise: NoiseInForce) -> Self {
        Self {
            rate_hz: noise.rate.hz(),
            gyro: noise.sample.of(Sensor::Gyro),
            accel: noise.sample.of(Sensor::Accel),
            gyro_walk: noise.gyro_walk,
            accel_walk: noise.accel_walk,
            pixel: noise.pixel,
            unsure: noise.unsure.unwrap_or([f64::NAN; 8]),
        }
    }
}
