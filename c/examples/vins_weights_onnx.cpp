// The same variances without dpn: its networks as ONNX files (`dpn export onnx --network sg11-s0 --out onnx`), asked by ONNX Runtime.
//
//   g++ -std=c++17 vins_weights_onnx.cpp -I$ORT/include -L$ORT/lib -lonnxruntime -o vins_weights_onnx
//   ./vins_weights_onnx onnx/accel/sg11-s0.onnx onnx/gyro/sg11-s0.onnx < imu.csv          rows: t_ns,gx,gy,gz,ax,ay,az
#include <onnxruntime_c_api.h>

#include <array>
#include <cstdio>
#include <deque>
#include <stdexcept>
#include <string>
#include <vector>

static const OrtApi *ort = OrtGetApiBase()->GetApi(ORT_API_VERSION);

static void check(OrtStatus *status) {
    if (!status) return;
    std::runtime_error error(ort->GetErrorMessage(status));
    ort->ReleaseStatus(status);
    throw error;
}

// A network: a second of x, y and z in SI units to the deviation of their noise.
class Network {
public:
    // What is made before an error is released: the destructor runs once the other constructor has ended.
    Network(const char *path, const char *sensor, const char *rate_hz) : Network() {
        check(ort->CreateEnv(ORT_LOGGING_LEVEL_WARNING, "dpn", &env_));
        check(ort->CreateSessionOptions(&options_));
        check(ort->CreateSession(env_, path, options_, &session_));
        check(ort->CreateCpuMemoryInfo(OrtArenaAllocator, OrtMemTypeDefault, &memory_));
        expect(path, "sensor", sensor), expect(path, "rate_hz", rate_hz);
    }
    ~Network() {
        ort->ReleaseMemoryInfo(memory_), ort->ReleaseSession(session_), ort->ReleaseSessionOptions(options_), ort->ReleaseEnv(env_);
    }

    std::array<float, 3> sigma(const std::deque<std::array<double, 3>> &second) {
        std::vector<float> windows;
        for (int axis = 0; axis < 3; ++axis)
            for (const auto &sample : second) windows.push_back(static_cast<float>(sample[axis]));
        const int64_t shape[] = {3, 200};
        OrtValue *input = nullptr, *output = nullptr;
        check(ort->CreateTensorWithDataAsOrtValue(memory_, windows.data(), 4 * windows.size(), shape, 2, ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT, &input));
        const char *in[] = {"window"}, *out[] = {"sigma"};
        check(ort->Run(session_, nullptr, in, &input, 1, out, 1, &output));
        float *values = nullptr;
        check(ort->GetTensorMutableData(output, reinterpret_cast<void **>(&values)));
        std::array<float, 3> sigma{values[0] > 0 ? values[0] : 0, values[1] > 0 ? values[1] : 0, values[2] > 0 ? values[2] : 0};
        ort->ReleaseValue(input), ort->ReleaseValue(output);
        return sigma;
    }

private:
    Network() = default;

    // Another sensor's or rate's network answers without a word, and its answer means nothing.
    void expect(const char *path, const char *key, const std::string &expected) {
        OrtAllocator *allocator = nullptr;
        OrtModelMetadata *metadata = nullptr;
        char *value = nullptr;
        check(ort->GetAllocatorWithDefaultOptions(&allocator));
        check(ort->SessionGetModelMetadata(session_, &metadata));
        OrtStatus *status = ort->ModelMetadataLookupCustomMetadataMap(metadata, allocator, key, &value);
        const std::string found = value ? value : "";
        if (value) allocator->Free(allocator, value);
        ort->ReleaseModelMetadata(metadata), check(status);
        if (found != expected) throw std::runtime_error(path + (": " + std::string(key)) + " is '" + found + "'; expected '" + expected + "'");
    }

    OrtEnv *env_ = nullptr;
    OrtSessionOptions *options_ = nullptr;
    OrtSession *session_ = nullptr;
    OrtMemoryInfo *memory_ = nullptr;
};

int main(int count, char **arguments) try {
    if (count != 3) throw std::runtime_error("give the accelerometer's and the gyroscope's .onnx");
    Network accel(arguments[1], "accel", "200"), gyro(arguments[2], "gyro", "200");
    std::deque<std::array<double, 3>> gs, as;
    long long t;
    std::array<double, 3> g, a;
    for (int n = 1; std::scanf("%lld,%lf,%lf,%lf,%lf,%lf,%lf", &t, &g[0], &g[1], &g[2], &a[0], &a[1], &a[2]) == 7; ++n) {
        gs.push_back(g), as.push_back(a);
        if (gs.size() > 200) gs.pop_front(), as.pop_front();
        if (n % 200) continue;
        const auto sa = accel.sigma(as), sg = gyro.sigma(gs);
        std::printf("%lld", t);
        for (double s : {sa[0], sa[1], sa[2], sg[0], sg[1], sg[2]}) std::printf(" %.9g", s * s);
        std::printf("\n");
    }
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
}
