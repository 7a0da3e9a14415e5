// The odometry on a EuRoC folder, a pose a line as they are made: stamp, x y z, qx qy qz qw.
//
//   g++ -std=c++17 euroc.cpp -I../include -L../../target/release -ldpn_c -o euroc
//   ./euroc DATA/V1_02_medium/mav0 [SETTINGS]        more settings as TOML: 'noise = "x4"'
#include <cstdio>
#include <fstream>
#include <iostream>
#include <iterator>
#include <sstream>
#include <vector>

#include "dpn.hpp"

static std::ifstream opened(const std::string &path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw std::runtime_error(path + ": cannot be read");
    return file;
}

// The next row of `file` that is none of words.
static bool next(std::ifstream &file, std::string &row) {
    while (std::getline(file, row))
        if (!row.empty() && row[0] != '#') return true;
    return false;
}

static void print(dpn::Odometry &odometry) {
    while (auto update = odometry.update()) {
        if (!update->known) continue;
        const double *p = update->position, *q = update->orientation;
        std::printf("%lld %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", (long long)update->t_ns, p[0], p[1], p[2], q[1], q[2], q[3], q[0]);
    }
}

int main(int count, char **words) try {
    if (count < 2) throw std::runtime_error("usage: euroc FOLDER [SETTINGS]");
    const std::string folder = words[1], camera = folder + "/cam0/";
    dpn::Odometry odometry("calibration = '" + camera + "sensor.yaml'\n" + (count > 2 ? words[2] : ""));
    auto images = opened(camera + "data.csv"), samples = opened(folder + "/imu0/data.csv");
    std::string image, sample;
    long long newest = 0;  // sample
    while (next(images, image)) {
        const long long t = std::stoll(image);
        const auto comma = image.find(',');
        const auto name = image.substr(comma + 1, image.find_last_not_of(" \r") - comma);
        auto file = opened(camera + "data/" + name);
        const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
        while (newest < t && next(samples, sample)) {
            double g[3], a[3];
            if (std::sscanf(sample.c_str(), "%lld,%lf,%lf,%lf,%lf,%lf,%lf", &newest, g, g + 1, g + 2, a, a + 1, a + 2) != 7)
                throw std::runtime_error("no sample: " + sample);
            odometry.imu(newest, g, a);
        }
        odometry.encoded(t, reinterpret_cast<const uint8_t *>(bytes.data()), bytes.size());
        print(odometry);
    }
    odometry.end();
    print(odometry);
    while (auto warning = odometry.warning()) std::cerr << "warning: " << *warning << "\n";
    if (const auto waiting = odometry.waiting(); !waiting.empty()) std::cerr << "waiting: " << waiting << "\n";
} catch (const std::exception &error) {
    std::cerr << error.what() << "\n";
    return 2;
}
