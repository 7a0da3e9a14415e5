# requirements: numpy, scipy, allantools (versions used stand in the file it writes)
"""Writes golden.json: overlapping Allan deviations by allantools (oadev), of a made-up signal that stands in the file, and of the six axes of a
recorded log at rest (adis16405_imu1.csv, an ADIS16405 at 100 Hz, a million rows), which does not.

Run in this folder: python3 make.py FOLDER   (FOLDER holds static/adis16405_imu1.csv; a minute or two)
"""
import json
import sys

import allantools
import numpy as np

rng = np.random.default_rng(7)
n, rate = 2000, 50.0
walk = np.cumsum(rng.normal(size=n)) * 0.02
signal = np.round(9.8 + rng.normal(size=n) * 0.3 + walk, 4)


def oadev(x, rate, ms):
    taus, dev, _, _ = allantools.oadev(np.asarray(x) - np.mean(x), rate=rate, data_type="freq", taus=np.array(ms) / rate)
    assert np.allclose(taus * rate, ms), (taus * rate, ms)
    return [float(f"{v:.12g}") for v in dev]


def averages(n):
    out = []
    k = 0
    while True:
        m = int(np.floor(10 ** (k / 8) + 0.5))
        if m > n // 3:
            return out
        if m not in out:
            out.append(m)
        k += 1


small = averages(n)
case = {
    "versions": {"python": sys.version.split()[0], "numpy": np.__version__, "allantools": allantools.__version__},
    "made_up": {"rate_hz": rate, "signal": signal.tolist(), "averages": small, "deviations": oadev(signal, rate, small)},
}
data = np.loadtxt(f"{sys.argv[1]}/static/adis16405_imu1.csv", delimiter=",", comments="#")
large = averages(len(data))
names = ["gyro x", "gyro y", "gyro z", "accel x", "accel y", "accel z"]
case["adis16405"] = {
    "rate_hz": 100.0,
    "averages": large,
    "deviations": {name: oadev(data[:, 1 + i], 100.0, large) for i, name in enumerate(names)},
}
with open("golden.json", "w") as f:
    json.dump(case, f)
    f.write("\n")
