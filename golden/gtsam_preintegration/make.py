# requirements: gtsam, numpy (versions used stand in the file it writes)
"""Writes golden.json: pre-integration by GTSAM (`PreintegratedImuMeasurementsManifold`, `PreintegratedCombinedMeasurementsManifold`).

GTSAM steps forward with one reading a step (R <- R Exp(w dt), v <- v + R a dt, p <- p + v dt + R a dt^2/2), dpn with the mid-point of
two. So there are two kinds of case:

steps      the readings of an uneven 200 Hz; GTSAM is given, for each step, the one reading with which its own step is the
           mid-point's: w = (w0 + w1)/2, a = (a0 + Exp(w dt) a1)/2, biases off. Means and predicted states agree to rounding.
continuum  readings as closed forms of time; GTSAM runs at 4, 8 and 16 kHz, and its results are extrapolated to step zero (its
           error has terms in dt and dt^2, which the extrapolation removes). Mean, bias Jacobians and covariances are those of
           continuous time, whatever the scheme.

GTSAM's order is rotation, position, velocity, with position and velocity perturbed in the frame at the end of the interval; the bias
covariance block has the sign of (computed - true). Here everything is in dpn's terms: position, rotation, velocity, accelerometer bias,
gyro bias; position and velocity in the frame at the beginning; true - computed.

Run in this folder: python3 make.py
"""
import importlib.metadata
import json
import sys

import gtsam
import numpy as np

GRAVITY = 9.81
rng = np.random.default_rng(9)


def params(accel_density, gyro_density, accel_walk, gyro_walk):
    p = gtsam.PreintegrationCombinedParams.MakeSharedU(GRAVITY)
    p.setAccelerometerCovariance(np.diag(np.square(accel_density)))
    p.setGyroscopeCovariance(np.diag(np.square(gyro_density)))
    p.setIntegrationCovariance(np.zeros((3, 3)))
    p.setBiasAccCovariance(np.eye(3) * accel_walk**2)
    p.setBiasOmegaCovariance(np.eye(3) * gyro_walk**2)
    return p


def bias_of(accel, gyro):
    return gtsam.imuBias.ConstantBias(np.array(accel), np.array(gyro))


def quaternion(rot3):
    q = rot3.toQuaternion()
    return [q.w(), q.x(), q.y(), q.z()]


def wave(c, t):
    return c[:, 0] + c[:, 1] * np.sin(c[:, 2] * t + c[:, 3])


def waves(scale, lift):
    c = np.stack([rng.uniform(-1, 1, 3), rng.uniform(-1, 1, 3), rng.uniform(3, 20, 3), rng.uniform(0, 6, 3)], axis=1)
    c[:, :2] *= scale
    c[2, 0] += lift
    return c


def motion():
    return waves(1.0, 0.0), waves(2.5, GRAVITY)


def steps_case():
    gyro_waves, accel_waves = motion()
    n = 40
    stamps = [int(round((k + rng.uniform(-0.2, 0.2)) * 5e6)) for k in range(n + 1)]
    gyro = [wave(gyro_waves, s * 1e-9) for s in stamps]
    accel = [wave(accel_waves, s * 1e-9) for s in stamps]
    ba, bg = rng.uniform(-0.3, 0.3, 3), rng.uniform(-0.1, 0.1, 3)
    bias = bias_of(ba, bg)
    m = gtsam.PreintegratedImuMeasurementsManifold(params([1e-2] * 3, [1e-3] * 3, 1e-4, 1e-5), bias)
    for k in range(n):
        dt = (stamps[k + 1] - stamps[k]) * 1e-9
        w = 0.5 * (gyro[k] + gyro[k + 1]) - bg
        turn = gtsam.Rot3.Expmap(w * dt).matrix()
        m.integrateMeasurement(0.5 * (accel[k] - ba + turn @ (accel[k + 1] - ba)) + ba, w + bg, dt)
    rotation = gtsam.Rot3.Expmap(rng.uniform(-2, 2, 3))
    position, velocity = rng.uniform(-5, 5, 3), rng.uniform(-3, 3, 3)
    end = m.predict(gtsam.NavState(rotation, position, velocity), bias)
    return {
        "t_ns": stamps, "gyro": [list(w) for w in gyro], "accel": [list(a) for a in accel],
        "accel_bias": list(ba), "gyro_bias": list(bg),
        "rotation_wxyz": quaternion(m.deltaRij()), "position": list(m.deltaPij()), "velocity": list(m.deltaVij()),
        "state_i": {"rotation_wxyz": quaternion(rotation), "position": list(position), "velocity": list(velocity)},
        "state_j": {"rotation_wxyz": quaternion(end.attitude()), "position": list(end.position()),
                    "velocity": list(end.velocity())},
    }


def in_our_terms(rotation, dim):
    """Maps GTSAM's tangent vector at the end of the interval to ours."""
    t = np.zeros((dim, dim))
    t[0:3, 3:6] = rotation
    t[3:6, 0:3] = np.eye(3)
    t[6:9, 6:9] = rotation
    if dim == 15:
        t[9:15, 9:15] = -np.eye(6)
    return t


def run(case, hz):
    gyro_waves, accel_waves = np.array(case["gyro_waves"]), np.array(case["accel_waves"])
    bias = bias_of(case["accel_bias"], case["gyro_bias"])
    p = params(case["accel_density"], case["gyro_density"], case["accel_walk"], case["gyro_walk"])
    white = gtsam.PreintegratedImuMeasurementsManifold(p, bias)
    combined = gtsam.PreintegratedCombinedMeasurementsManifold(p, bias)
    n = int(round(case["duration"] * hz))
    for k in range(n):
        t = k / hz
        for m in (white, combined):
            m.integrateMeasurement(wave(accel_waves, t), wave(gyro_waves, t), 1.0 / hz)
    rotation = white.deltaRij().matrix()
    h1, h2 = np.zeros((9, 9), order="F"), np.zeros((9, 6), order="F")
    white.predict(gtsam.NavState(), bias, h1, h2)
    t9, t15 = in_our_terms(rotation, 9), in_our_terms(rotation, 15)
    return {
        "rotation_vector": gtsam.Rot3.Logmap(white.deltaRij()),
        "position": white.deltaPij(), "velocity": white.deltaVij(),
        "jacobian": t9 @ h2,
        "covariance_white": t9 @ white.preintMeasCov() @ t9.T,
        "covariance": t15 @ combined.preintMeasCov() @ t15.T,
    }


def continuum_case():
    gyro_waves, accel_waves = motion()
    case = {
        "duration": 0.25, "gyro_waves": gyro_waves.tolist(), "accel_waves": accel_waves.tolist(),
        "accel_bias": list(rng.uniform(-0.3, 0.3, 3)), "gyro_bias": list(rng.uniform(-0.1, 0.1, 3)),
        "accel_density": list(rng.uniform(2e-3, 8e-3, 3)), "gyro_density": list(rng.uniform(1e-4, 4e-4, 3)),
        "accel_walk": 3e-2, "gyro_walk": 2e-3,
    }
    h4, h8, h16 = (run(case, hz) for hz in (4000, 8000, 16000))
    case["expected"] = {key: ((8 * h16[key] - 6 * h8[key] + h4[key]) / 3).tolist() for key in h4}
    return case


versions = {"python": sys.version.split()[0], "numpy": np.__version__, "gtsam": importlib.metadata.version("gtsam")}
json.dump({"versions": versions, "steps": [steps_case() for _ in range(3)], "continuum": [continuum_case() for _ in range(3)]},
          open("golden.json", "w"), indent=None, separators=(",", ":"))
