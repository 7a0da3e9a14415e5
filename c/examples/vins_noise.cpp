// The noise for a VINS-type estimator, learned from its own tracks: the odometry sees what that one's front-end saw, and says what noise goes with it.
//
//   g++ -std=c++17 vins_noise.cpp -I../include -L../../target/release -ldpn_c -o vins_noise
//   ./vins_noise CALIBRATION IMU.csv TRACKS.txt
//
// IMU.csv has rows t_ns,gx,gy,gz,ax,ay,az; TRACKS.txt a frame a line: t_ns count, then id x y of each point in pixels.
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <sstream>
#include <vector>

#include "dpn.hpp"

static bool next(std::ifstream &file, std::string &row) {
    while (std::getline(file, row))
        if (!row.empty() && row[0] != '#') return true;
    return false;
}

static double largest(const double sigma[3]) { return std::fmax(sigma[0], std::fmax(sigma[1], sigma[2])); }

int main(int count, char **words) try {
    if (count < 4) throw std::runtime_error("usage: vins_noise CALIBRATION IMU.csv TRACKS.txt");
    // Points that were followed through images err together.
    dpn::Odometry odometry(std::string("calibration = '") + words[1] + "'\ncamera = \"tracks\"\n[estimator]\nfed_tracks = \"followed\"\n");
    std::ifstream samples(words[2]), frames(words[3]);
    if (!samples || !frames) throw std::runtime_error("a file cannot be read");
    std::string frame, sample;
    long long newest = 0;  // sample
    while (next(frames, frame)) {
        std::istringstream row(frame);
        long long t = 0;
        size_t points = 0;
        if (!(row >> t >> points) || points > 10000) throw std::runtime_error("no frame: " + frame.substr(0, 40));
        std::vector<uint64_t> ids(points);
        std::vector<double> px(2 * points);
        for (size_t k = 0; k < points; ++k)
            if (!(row >> ids[k] >> px[2 * k] >> px[2 * k + 1])) throw std::runtime_error("a frame ends early: " + frame.substr(0, 40));
        while (newest < t && next(samples, sample)) {
            double g[3], a[3];
            if (std::sscanf(sample.c_str(), "%lld,%lf,%lf,%lf,%lf,%lf,%lf", &newest, g, g + 1, g + 2, a, a + 1, a + 2) != 7)
                throw std::runtime_error("no sample: " + sample);
            odometry.imu(newest, g, a);
        }
        odometry.tracks(t, ids.data(), px.data(), points);
        while (odometry.update()) {}
    }
    const auto noise = odometry.noise();
    if (!noise) throw std::runtime_error(odometry.waiting());
    // As VINS-Mono's configuration has them: deviations of a sample, the noisiest axis, and of the rate at which a bias changes within one. Unsure: of the
    // logarithm, 1 where next to nothing is known.
    const double *unsure = noise->unsure, root = std::sqrt(noise->rate_hz);
    std::printf("acc_n: %.4g    # unsure %.2f\n", largest(noise->accel), largest(unsure));
    std::printf("gyr_n: %.4g    # unsure %.2f\n", largest(noise->gyro), largest(unsure + 3));
    std::printf("acc_w: %.4g    # unsure %.2f\n", noise->accel_walk * root, unsure[6]);
    std::printf("gyr_w: %.4g    # unsure %.2f\n", noise->gyro_walk * root, unsure[7]);
} catch (const std::exception &error) {
    std::cerr << error.what() << "\n";
    return 2;
}
