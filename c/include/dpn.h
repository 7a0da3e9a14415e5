#ifndef DPN_H
#define DPN_H

#include <stddef.h>
#include <stdint.h>

/* dpn: how noisy is this IMU right now.
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
} dpn_status;

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
} dpn_sigma;

// A level that is learned from residuals.
typedef uint64_t dpn_level;

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

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* DPN_H */
