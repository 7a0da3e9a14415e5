// dpn for C++17: handles that free themselves, std::optional for what is not there yet, dpn::Error for what cannot be.
//
// An object may be moved and not copied; two threads that use one take turns. Nothing here keeps a pointer of yours beyond its call.
#ifndef DPN_HPP
#define DPN_HPP

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "dpn.h"

namespace dpn {

// What was refused, in words that name the argument, and its code.
class Error : public std::runtime_error {
public:
    Error(dpn_status status, const char *words) : std::runtime_error(words), status(status) {}
    const dpn_status status;
};

inline void check(dpn_status status) {
    if (status != DPN_STATUS_OK) throw Error(status, dpn_last_error());
}

// Whether there was something to give.
inline bool given(dpn_status status) {
    if (status != DPN_STATUS_NOT_YET) check(status);
    return status == DPN_STATUS_OK;
}

// A number from the library's table, freed once. 0 is nobody's: what was moved from is refused, not undefined.
template <dpn_status (*Free)(uint64_t)>
class Handle {
public:
    Handle() = default;
    Handle(Handle &&other) noexcept : number(std::exchange(other.number, 0)) {}
    Handle &operator=(Handle &&other) noexcept {
        std::swap(number, other.number);
        return *this;
    }
    ~Handle() {
        if (number) Free(number);
    }

protected:
    uint64_t number = 0;
};

// The odometry: samples with images or tracks in, updates out. `settings` is a TOML text (dpn_odometry_new has its keys).
class Odometry : public Handle<dpn_odometry_free> {
public:
    explicit Odometry(const std::string &settings) { check(dpn_odometry_new(settings.c_str(), &number)); }

    // rad/s, m/s^2.
    void imu(int64_t t_ns, const double gyro[3], const double accel[3]) { check(dpn_odometry_imu(number, t_ns, gyro, accel)); }
    // Grey, 8 bits, rows `stride` bytes apart.
    void image(int64_t t_ns, const uint8_t *pixels, size_t width, size_t height, size_t stride) {
        check(dpn_odometry_image(number, t_ns, pixels, width, height, stride));
    }
    // PNG or JPEG.
    void encoded(int64_t t_ns, const uint8_t *data, size_t length) { check(dpn_odometry_encoded(number, t_ns, data, length)); }
    // `points` are x, y, x, y, ...: distorted pixels, or normalised.
    void tracks(int64_t t_ns, const uint64_t *ids, const double *points, size_t count, bool normalised = false) {
        check(dpn_odometry_tracks(number, t_ns, ids, points, count, normalised));
    }
    void end() { check(dpn_odometry_end(number)); }

    // The next frame that samples have reached, worked off.
    std::optional<dpn_update> update() {
        dpn_update update;
        return given(dpn_odometry_update(number, &update)) ? std::optional(update) : std::nullopt;
    }
    std::optional<dpn_noise> noise() const {
        dpn_noise noise;
        return given(dpn_odometry_noise(number, &noise)) ? std::optional(noise) : std::nullopt;
    }
    // Empty while poses come.
    std::string waiting() const {
        const char *words;
        check(dpn_odometry_waiting(number, &words));
        return words;
    }
    std::optional<std::string> warning() {
        const char *words;
        return given(dpn_odometry_warning(number, &words)) ? std::optional<std::string>(words) : std::nullopt;
    }
};

// The shipped networks beside running samples, asked every so many.
class Stream : public Handle<dpn_stream_free> {
public:
    explicit Stream(uint32_t every = 10) {
        Weights accel(DPN_SENSOR_ACCEL), gyro(DPN_SENSOR_GYRO);
        check(dpn_stream_new(accel.get(), gyro.get(), every, &number));
    }
    void feed(int64_t t_ns, const double gyro[3], const double accel[3]) { check(dpn_stream_feed(number, t_ns, gyro, accel)); }
    dpn_sigma sigma() const {
        dpn_sigma sigma;
        check(dpn_stream_sigma(number, &sigma));
        return sigma;
    }

private:
    struct Weights : Handle<dpn_weights_free> {
        explicit Weights(dpn_sensor sensor) { check(dpn_weights_shipped(sensor, &number)); }
        dpn_weights get() const { return number; }
    };
};

// A gyroscope's bias, by a network of `dpn train --model inertial` of this very IMU, beside running samples.
class GyroBias : public Handle<dpn_gyro_bias_free> {
public:
    explicit GyroBias(const std::string &path) { check(dpn_gyro_bias_load(path.c_str(), &number)); }
    void feed(int64_t t_ns, const double gyro[3], const double accel[3]) { check(dpn_gyro_bias_feed(number, t_ns, gyro, accel)); }
    // matrix * reading + bias is the rate; slow, for an estimator's bias and not for its samples.
    dpn_gyro_correction correction() const {
        dpn_gyro_correction correction;
        check(dpn_gyro_bias_correction(number, &correction));
        return correction;
    }
};

// A level that another estimator's residuals tune.
class Level : public Handle<dpn_level_free> {
public:
    explicit Level(double memory_s = 10.0, double prior = 2.0) { check(dpn_level_new(memory_s, prior, &number)); }
    void feed(int64_t t_ns, double squares, double redundancy) { check(dpn_level_feed(number, t_ns, squares, redundancy)); }
    double factor() const {
        double factor;
        check(dpn_level_factor(number, &factor));
        return factor;
    }
};

}  // namespace dpn

#endif
