#ifndef DPN_H
#define DPN_H

#include <stddef.h>
#include <stdint.h>

/* dpn: how noisy is this IMU right now, and an odometry that finds out.
 *
 * Every function returns DPN_STATUS_OK or says what is wrong: a code, and words in dpn_last_error(). Handles are numbers from a table: freeing one twice, or using one
 * that was freed, is DPN_STATUS_UNKNOWN_HANDLE and nothing else. Functions may be called from any thread. Units: s, m/s^2, rad/s; stamps in nanoseconds. */


// What a call came to.
typedef enum {
  // All is well.
  DPN_STATUS_OK = 0,
  // A pointer that must not be null is.
  DPN_STATUS_NULL_ARGUMENT = 1,
  // A value that cannot be taken.
  DPN_STATUS_BAD_ARGUMENT = 2,
  // A handle that was never given out, or was freed.
  DPN_STATUS_UNKNOWN_HANDLE = 3,
  // A file or bytes that are no network of dpn's.
  DPN_STATUS_BAD_WEIGHTS = 4,
  // A fault of dpn itself; the object it happened in should be freed.
  DPN_STATUS_PANIC = 5,
  // Settings or a calibration that cannot be used.
  DPN_STATUS_BAD_SETTINGS = 6,
  // Nothing to give yet: no fault, there are no words.
  DPN_STATUS_NOT_YET = 7,
} dpn_status;

// What an odometry is doing.
typedef enum {
  // Waiting until the first states can be told.
  DPN_PHASE_INITIALISING = 0,
  // Estimating.
  DPN_PHASE_TRACKING = 1,
  // Given up at this frame; the next ones initialise again.
  DPN_PHASE_RESTARTED = 2,
} dpn_phase;

// One of the two inertial sensors.
typedef enum {
  // Accelerometer.
  DPN_SENSOR_ACCEL = 0,
  // Gyroscope.
  DPN_SENSOR_GYRO = 1,
} dpn_sensor;

// A trained network.
typedef uint64_t dpn_weights;

// Two networks on a stream of samples.
typedef uint64_t dpn_stream;

// How noisy the IMU is at the newest sample: deviations of one sample, by axis.
typedef struct {
  // Gyroscope x, y, z [rad/s].
  double gyro[3];
  // Accelerometer x, y, z [m/s^2].
  double accel[3];
  // 0 until the first second has passed: the deviations are then VINS-Mono's constants.
  uint8_t known;
  // 1 where the gyroscope's last window was unlike all of the training, on any axis: its deviations are extrapolated.
  uint8_t gyro_out_of_range;
  // 1 where the accelerometer's was.
  uint8_t accel_out_of_range;
  // 1 while samples come at a rate more than 5 % off the networks': thin or resample them.
  uint8_t wrong_rate;
  // 1 where the spectrum of the gyroscope's last minute says another noise, as behind a low pass: its deviations are not known.
  uint8_t gyro_contradicted;
  // 1 where the accelerometer's does.
  uint8_t accel_contradicted;
} dpn_sigma;

// A level that is learned from residuals.
typedef uint64_t dpn_level;

// A visual-inertial odometry.
typedef uint64_t dpn_odometry;

// What came of a frame. World z up, body = IMU; NaN where nothing is known.
typedef struct {
  // The frame's stamp on the IMU's clock, in ns.
  int64_t t_ns;
  // What the odometry is doing.
  dpn_phase phase;
  // 1 where the frame has a pose.
  uint8_t known;
  // Tracks that went on from earlier frames.
  uint32_t tracked;
  // Landmarks with a depth.
  uint32_t landmarks;
  // Of the body in the world, in m.
  double position[3];
  // World from body, Hamilton quaternion w, x, y, z.
  double orientation[4];
  // In the world [m/s].
  double velocity[3];
  // Of the accelerometer [m/s^2].
  double accel_bias[3];
  // Of the gyroscope [rad/s].
  double gyro_bias[3];
  // Of the pose as believed, row by row: position, then rotation on the right. Known with `covariance = true` below `[estimator]`.
  double covariance[36];
  // Relative standard deviation of the scale, as believed.
  double scale_std;
  // By what the noise told is multiplied from here on: accelerometer x, y, z, gyroscope x, y, z, walks of their biases, pixel. Known where it is learned.
  double levels[9];
} dpn_update;

// The IMU's noise as it is in force: what was told times what was learned.
typedef struct {
  // Rate of the samples in Hz: a density is a deviation over its root.
  double rate_hz;
  // Deviation of a gyroscope's sample, x, y, z [rad/s].
  double gyro[3];
  // Deviation of an accelerometer's sample, x, y, z [m/s^2].
  double accel[3];
  // Walk of the gyroscope's bias [rad/s^2/sqrt(Hz)].
  double gyro_walk;
  // Walk of the accelerometer's bias [m/s^3/sqrt(Hz)].
  double accel_walk;
  // Deviation of a pixel, in px.
  double pixel;
  // How unsure the learned ones are, as deviations of their logarithms: accelerometer x, y, z, gyroscope x, y, z, the two walks; 1 and more where next to
  // nothing is known; NaN where nothing is learned.
  double unsure[8];
} dpn_noise;

// A gyroscope's bias that a network learns.
typedef uint64_t dpn_gyro_bias;

// What takes a reading of the gyroscope to a rate: `matrix * reading + bias`. Give it to an estimator as a calibration and a slow bias; no sample is to be corrected by
// anything quicker.
typedef struct {
  // Row by row.
  double matrix[9];
  // The calibration's bias, the network's average and what gravity tells beside them [rad/s].
  double bias[3];
  // Its deviation by axis [rad/s].
  double deviation[3];
  // 0 until the network has seen as much past as it looks at: the bias is the calibration's then.
  uint8_t known;
  // 1 while samples come at a rate more than 5 % off the network's: thin or resample them.
  uint8_t wrong_rate;
} dpn_gyro_correction;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Words on the last call of this thread that took a status; empty where all was well. They last until the thread's next call.
const char *dpn_last_error(void);

// The version of this library, for example "0.1.0"; lasts for ever.
const char *dpn_version(void);

// Reads a network from a file (.safetensors, as dpn ships and trains them).
//
// # Safety
// `path` is null or a string that ends with a zero; `weights` is null or may be written to.
dpn_status dpn_weights_load(const char *path, dpn_weights *weights);

// Reads a network from `length` bytes of such a file.
//
// # Safety
// `data` is null or points to `length` bytes; `weights` is null or may be written to.
dpn_status dpn_weights_from_bytes(const uint8_t *data, size_t length, dpn_weights *weights);

// The network of a sensor (a `dpn_sensor`) that comes with the library, for samples at 200 Hz.
//
// # Safety
// `weights` is null or may be written to.
dpn_status dpn_weights_shipped(uint32_t sensor, dpn_weights *weights);

// Frees a network. Streams that were made with it go on.
dpn_status dpn_weights_free(dpn_weights weights);

// Makes a stream of two networks, asked every so many samples (10: a camera's frame at 20 Hz).
//
// # Safety
// `stream` is null or may be written to.
dpn_status dpn_stream_new(dpn_weights accel, dpn_weights gyro, uint32_t every, dpn_stream *stream);

// Feeds a sample: its stamp in ns, angular rate [rad/s] and specific force [m/s^2]. One that is refused changes nothing.
//
// # Safety
// `gyro` and `accel` are null or point to three doubles each.
dpn_status dpn_stream_feed(dpn_stream stream,
                           int64_t t_ns,
                           const double *gyro,
                           const double *accel);

// Asks how noisy the IMU is at the newest sample.
//
// # Safety
// `sigma` is null or may be written to.
dpn_status dpn_stream_sigma(dpn_stream stream, dpn_sigma *sigma);

// Frees a stream.
dpn_status dpn_stream_free(dpn_stream stream);

// Makes a level: the factor by which a deviation that was told is to be multiplied, 1 until residuals say otherwise. A residual counts for a third after
// `memory_s` seconds; what is told counts at the start as `prior` residuals (10 s and 2 in dpn's own odometry).
//
// # Safety
// `level` is null or may be written to.
dpn_status dpn_level_new(double memory_s,
                         double prior,
                         dpn_level *level);

// Feeds a residual of the time `t_ns` in ns: the sum of its squares, whitened with the deviation told times the level in force, and its redundancy: its
// rows less what the states take up, tr(J H^-1 J^T) with the whitened Jacobian J and the states' covariance H^-1.
dpn_status dpn_level_feed(dpn_level level,
                          int64_t t_ns,
                          double squares,
                          double redundancy);

// Asks for the factor in force on the deviation told.
//
// # Safety
// `factor` is null or may be written to.
dpn_status dpn_level_factor(dpn_level level, double *factor);

// Frees a level.
dpn_status dpn_level_free(dpn_level level);

// Makes an odometry of a TOML text:
//
// ```toml
// calibration = "cam0/sensor.yaml"   # of the camera: a file of Kalibr, OpenVINS, VINS, ORB-SLAM3, Basalt, OKVIS or ASL, or a table with its keys
// camera = "images"                  # or "tracks", of a front-end of your own
// noise = "self"                     # learned while it runs; or figures, "const(0.05,0.004)": m/s^2 and rad/s a sample
// seed = 0
// [estimator]                        # settings as `dpn run --config` has them
// covariance = true
// ```
//
// All but `calibration` may be left out. All work is done in the calls, by the thread that makes them.
//
// # Safety
// `settings` is null or a string that ends with a zero; `odometry` is null or may be written to.
dpn_status dpn_odometry_new(const char *settings,
                            dpn_odometry *odometry);

// Feeds a sample: its stamp in ns, angular rate [rad/s] and specific force [m/s^2]. One that is refused changes nothing.
//
// # Safety
// `gyro` and `accel` are null or point to three doubles each.
dpn_status dpn_odometry_imu(dpn_odometry odometry,
                            int64_t t_ns,
                            const double *gyro,
                            const double *accel);

// Feeds a grey image of 8 bits: the camera's stamp in ns, and rows of `width` bytes that begin `stride` bytes apart. It is copied; one that is refused changes
// nothing. Samples and images may come in any order between the two, each in increasing time.
//
// # Safety
// `pixels` is null or points to `height` such rows.
dpn_status dpn_odometry_image(dpn_odometry odometry,
                              int64_t t_ns,
                              const uint8_t *pixels,
                              size_t width,
                              size_t height,
                              size_t stride);

// Feeds an image as a file or a message has it: the bytes of a PNG or JPEG.
//
// # Safety
// `data` is null or points to `length` bytes.
dpn_status dpn_odometry_encoded(dpn_odometry odometry,
                                int64_t t_ns,
                                const uint8_t *data,
                                size_t length);

// Feeds the tracks of a frame, where the settings say `camera = "tracks"`: `count` ids, each at most once and for ever the same point's, and as many pairs
// x, y: distorted pixels, or where `normalised` is not 0 the points x / z, y / z of the camera's frame.
//
// # Safety
// `ids` and `points` are null or point to `count` numbers and pairs.
dpn_status dpn_odometry_tracks(dpn_odometry odometry,
                               int64_t t_ns,
                               const uint64_t *ids,
                               const double *points,
                               size_t count,
                               uint8_t normalised);

// Says that nothing more comes: points are followed into the last images too.
dpn_status dpn_odometry_end(dpn_odometry odometry);

// Works off the next frame whose samples are all there; `DPN_STATUS_NOT_YET` where there is none. To be called until then after every image or frame.
//
// # Safety
// `update` is null or may be written to.
dpn_status dpn_odometry_update(dpn_odometry odometry,
                               dpn_update *update);

// Asks for the IMU's noise in force; `DPN_STATUS_NOT_YET` until the samples' rate is known.
//
// # Safety
// `noise` is null or may be written to.
dpn_status dpn_odometry_noise(dpn_odometry odometry, dpn_noise *noise);

// Asks what is waited for; an empty string while poses come. The string lasts until this thread asks for another by this function or the next.
//
// # Safety
// `words` is null or may be written to.
dpn_status dpn_odometry_waiting(dpn_odometry odometry,
                                const char **words);

// Asks what seems to be wrong with the input: one remark after the other, then `DPN_STATUS_NOT_YET`.
//
// # Safety
// `words` is null or may be written to.
dpn_status dpn_odometry_warning(dpn_odometry odometry,
                                const char **words);

// Frees an odometry.
dpn_status dpn_odometry_free(dpn_odometry odometry);

// Reads a network of `dpn train --model inertial` (network.safetensors), of this very IMU.
//
// # Safety
// `path` is null or a string that ends with a zero; `gyro_bias` is null or may be written to.
dpn_status dpn_gyro_bias_load(const char *path, dpn_gyro_bias *gyro_bias);

// Feeds a sample: its stamp in ns, angular rate [rad/s] and specific force [m/s^2]. One that is refused changes nothing.
//
// # Safety
// `gyro` and `accel` are null or point to three doubles each.
dpn_status dpn_gyro_bias_feed(dpn_gyro_bias gyro_bias,
                              int64_t t_ns,
                              const double *gyro,
                              const double *accel);

// Asks what holds at the newest sample.
//
// # Safety
// `correction` is null or may be written to.
dpn_status dpn_gyro_bias_correction(dpn_gyro_bias gyro_bias, dpn_gyro_correction *correction);

// Frees it.
dpn_status dpn_gyro_bias_free(dpn_gyro_bias gyro_bias);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* DPN_H */
