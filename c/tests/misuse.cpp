// Everything that must not be called, on an odometry that goes on afterwards.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <vector>

#include "dpn.hpp"

static const char *SETTINGS = R"(
camera = "images"
noise = "x4"
[calibration]
resolution = [64, 48]
rate_hz = 20
camera_model = "pinhole"
intrinsics = [40.0, 40.0, 32.0, 24.0]
distortion_model = "none"
distortion_coefficients = []
T_BS = { rows = 4, cols = 4, data = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0] }
)";

static void hold(bool fine, const char *what, int line) {
    if (fine) return;
    std::fprintf(stderr, "misuse.cpp:%d: %s; last error: %s\n", line, what, dpn_last_error());
    std::exit(1);
}
#define HOLD(what) hold(what, #what, __LINE__)
#define REFUSED(call, code, words) \
    HOLD((call) == code);          \
    HOLD(std::strstr(dpn_last_error(), words))

int main() {
    dpn_odometry o = 0;
    REFUSED(dpn_odometry_new(nullptr, &o), DPN_STATUS_NULL_ARGUMENT, "`settings` is null");
    REFUSED(dpn_odometry_new(SETTINGS, nullptr), DPN_STATUS_NULL_ARGUMENT, "`odometry` is null");
    REFUSED(dpn_odometry_new("", &o), DPN_STATUS_BAD_SETTINGS, "calibration");
    REFUSED(dpn_odometry_new("calibration = 'none.yaml'", &o), DPN_STATUS_BAD_SETTINGS, "none.yaml");
    REFUSED(dpn_odometry_new("\xff", &o), DPN_STATUS_BAD_ARGUMENT, "no UTF-8");
    HOLD(o == 0);
    dpn::check(dpn_odometry_new(SETTINGS, &o));

    const double gyro[3] = {0.0, 0.0, 0.1}, accel[3] = {0.0, 0.0, 9.81}, nan[3] = {0.0, std::nan(""), 0.0};
    std::vector<uint8_t> pixels(64 * 48, 7);
    dpn_update update;
    dpn_noise noise;
    const char *words = nullptr;
    dpn::check(dpn_odometry_waiting(o, &words));
    HOLD(std::strcmp(words, "no IMU sample has come") == 0);
    HOLD(dpn_odometry_update(o, &update) == DPN_STATUS_NOT_YET && dpn_odometry_noise(o, &noise) == DPN_STATUS_NOT_YET);
    HOLD(dpn_odometry_warning(o, &words) == DPN_STATUS_NOT_YET);
    REFUSED(dpn_odometry_update(o, nullptr), DPN_STATUS_NULL_ARGUMENT, "`update` is null");
    REFUSED(dpn_odometry_waiting(o, nullptr), DPN_STATUS_NULL_ARGUMENT, "`words` is null");
    REFUSED(dpn_odometry_imu(o, 1, nullptr, accel), DPN_STATUS_NULL_ARGUMENT, "`gyro` is null");
    REFUSED(dpn_odometry_imu(o, 1, gyro, nan), DPN_STATUS_BAD_ARGUMENT, "`accel` is");
    dpn::check(dpn_odometry_imu(o, 1000, gyro, accel));
    REFUSED(dpn_odometry_imu(o, 999, gyro, accel), DPN_STATUS_BAD_ARGUMENT, "increasing time");
    REFUSED(dpn_odometry_image(o, 1, nullptr, 64, 48, 64), DPN_STATUS_NULL_ARGUMENT, "`pixels` is null");
    REFUSED(dpn_odometry_image(o, 1, pixels.data(), 64, 48, 63), DPN_STATUS_BAD_ARGUMENT, "`stride` is 63");
    REFUSED(dpn_odometry_image(o, 1, pixels.data(), 64, 0, 64), DPN_STATUS_BAD_ARGUMENT, "64 x 0");
    REFUSED(dpn_odometry_image(o, 1, pixels.data(), 64, SIZE_MAX, SIZE_MAX), DPN_STATUS_BAD_ARGUMENT, "an image of");
    REFUSED(dpn_odometry_image(o, 1, pixels.data(), 32, 24, 32), DPN_STATUS_BAD_ARGUMENT, "32 x 24");
    REFUSED(dpn_odometry_encoded(o, 1, pixels.data(), pixels.size()), DPN_STATUS_BAD_ARGUMENT, "PNG or JPEG");
    REFUSED(dpn_odometry_encoded(o, 1, pixels.data(), SIZE_MAX), DPN_STATUS_BAD_ARGUMENT, "no array is as long");
    const uint64_t id = 3;
    REFUSED(dpn_odometry_tracks(o, 1, &id, gyro, 1, 0), DPN_STATUS_BAD_ARGUMENT, "made for images");
    REFUSED(dpn_odometry_tracks(o, 1, nullptr, gyro, 1, 0), DPN_STATUS_NULL_ARGUMENT, "`ids` is null");
    REFUSED(dpn_odometry_tracks(o, 1, &id, gyro, SIZE_MAX, 0), DPN_STATUS_BAD_ARGUMENT, "at most");
    // A row's last bytes are the buffer's last: nothing behind them is read.
    std::vector<uint8_t> apart(80 * 47 + 64, 9);
    dpn::check(dpn_odometry_image(o, 2000, apart.data(), 64, 48, 80));
    REFUSED(dpn_odometry_image(o, 2000, apart.data(), 64, 48, 80), DPN_STATUS_BAD_ARGUMENT, "increasing time");
    REFUSED(dpn_stream_free(o), DPN_STATUS_UNKNOWN_HANDLE, "`stream` is");
    REFUSED(dpn_odometry_end(o + 1), DPN_STATUS_UNKNOWN_HANDLE, "`odometry` is");

    // Two threads feed it, a third takes what there is, a fourth frees it under them.
    const auto fed = [&](int begin) {
        for (int i = 0; i < 400; ++i) {
            const int64_t t = 5000000LL * (2 * i + begin + 1);
            if (dpn_odometry_imu(o, t, gyro, accel) == DPN_STATUS_UNKNOWN_HANDLE) return;
            if (i % 10 == 0) dpn_odometry_image(o, t, pixels.data(), 64, 48, 64);
        }
    };
    std::thread one(fed, 0), two(fed, 1), three([&] {
        dpn_update taken;
        dpn_status status;
        do status = dpn_odometry_update(o, &taken);
        while (status != DPN_STATUS_UNKNOWN_HANDLE);
    });
    one.join();
    HOLD(dpn_odometry_free(o) == DPN_STATUS_OK);
    two.join(), three.join();
    REFUSED(dpn_odometry_free(o), DPN_STATUS_UNKNOWN_HANDLE, "not freed yet");

    // What was moved from is refused, and what is freed is freed once.
    dpn::Odometry first(SETTINGS), second(std::move(first));
    try {
        first.imu(1, gyro, accel);
        return 1;
    } catch (const dpn::Error &error) {
        HOLD(error.status == DPN_STATUS_UNKNOWN_HANDLE && std::strstr(error.what(), "`odometry` is 0"));
    }
    second.imu(1, gyro, accel);
    HOLD(!second.update() && !second.noise() && !second.warning() && second.waiting() == "no image has come");
    dpn::Stream stream;
    stream.feed(1, gyro, accel);
    HOLD(!stream.sigma().known && dpn::Level().factor() == 1.0);
    std::puts("all refused");
}
