// What a VINS-type estimator copies: IMU weights that follow the noise, and a level for all of them from its own residuals.
//
//   g++ -std=c++17 vins_weights.cpp -I../include -L../../target/release -ldpn_c -o vins_weights
//   ./vins_weights < imu.csv          rows: t_ns,gx,gy,gz,ax,ay,az
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include "dpn.h"

static void check(dpn_status status) {
    if (status != DPN_STATUS_OK) throw std::runtime_error(dpn_last_error());
}

// One a IMU: feed it where samples come in, ask it where an interval is pre-integrated.
class ImuWeights {
public:
    ImuWeights() {
        dpn_weights accel, gyro;
        check(dpn_weights_shipped(DPN_SENSOR_ACCEL, &accel));
        check(dpn_weights_shipped(DPN_SENSOR_GYRO, &gyro));
        check(dpn_stream_new(accel, gyro, 10, &stream_));
        check(dpn_weights_free(accel));  // the stream has its own copy
        check(dpn_weights_free(gyro));
        check(dpn_level_new(10.0, 2.0, &level_));
    }
    ~ImuWeights() { dpn_stream_free(stream_), dpn_level_free(level_); }
    ImuWeights(const ImuWeights &) = delete;
    ImuWeights &operator=(const ImuWeights &) = delete;

    void sample(int64_t t_ns, const double gyro[3], const double accel[3]) { check(dpn_stream_feed(stream_, t_ns, gyro, accel)); }

    // VINS-Mono's 18 x 18 noise of an integration step: ACC_N^2, GYR_N^2, again for its end, then the walks (yours).
    void variances(double diagonal[12]) const {
        dpn_sigma sigma;
        double factor;
        check(dpn_stream_sigma(stream_, &sigma));
        check(dpn_level_factor(level_, &factor));
        if (sigma.wrong_rate) std::fprintf(stderr, "warning: the networks know 200 Hz\n");
        for (int k = 0; k < 3; ++k) {
            diagonal[k] = diagonal[6 + k] = factor * factor * sigma.accel[k] * sigma.accel[k];
            diagonal[3 + k] = diagonal[9 + k] = factor * factor * sigma.gyro[k] * sigma.gyro[k];
        }
    }

    // After the solver: an IMU factor's whitened residual squared, and 15 - tr(J H^-1 J^T).
    void solved(int64_t t_ns, double squares, double redundancy) { check(dpn_level_feed(level_, t_ns, squares, redundancy)); }

private:
    dpn_stream stream_ = 0;
    dpn_level level_ = 0;
};

int main() try {
    ImuWeights weights;
    long long t;
    double g[3], a[3], diagonal[12];
    for (int n = 1; std::scanf("%lld,%lf,%lf,%lf,%lf,%lf,%lf", &t, g, g + 1, g + 2, a, a + 1, a + 2) == 7; ++n) {
        weights.sample(t, g, a);
        if (n % 200) continue;
        weights.variances(diagonal);
        std::printf("%lld %.9g %.9g %.9g %.9g %.9g %.9g\n", t, diagonal[0], diagonal[1], diagonal[2], diagonal[3], diagonal[4], diagonal[5]);
    }
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
}
