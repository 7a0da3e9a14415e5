# requirements: numpy, PyWavelets (versions used stand in the file it writes)
"""Writes golden.json: how far the scaled median of absolute deviations lies above sigma for a finite window, times
the number of values, for white noise. The median of few values is biased; the excess falls as 1 / number.

Run in this folder: python3 make.py   (about a minute)
"""
import json
import sys

import numpy as np
import pywt

K = 1.482602218505602
SQRT6 = np.sqrt(6.0)
rng = np.random.default_rng(5)


def mad2(x):
    d = np.diff(x, 2, axis=1)
    d -= np.median(d, axis=1, keepdims=True)
    return K * np.median(np.abs(d), axis=1) / SQRT6, d.shape[1]


def wavelet(name):
    high = np.array(pywt.Wavelet(name).dec_hi)

    def estimate(x):
        windows = np.lib.stride_tricks.sliding_window_view(x, len(high), axis=1)[:, ::2]
        d = windows @ high[::-1]
        return K * np.median(np.abs(d), axis=1), d.shape[1]

    return estimate


def measure(estimate, n, draws):
    total = square = 0.0
    for _ in range(draws // 10000):
        s, values = estimate(rng.standard_normal((10000, n)))
        total += s.sum()
        square += (s * s).sum()
    mean = total / draws
    spread = np.sqrt(square / draws - mean * mean)
    return {"samples": n, "values": values, "excess_times_values": (mean - 1) * values,
            "standard_error": spread / np.sqrt(draws) * values, "spread_over_bound": spread * np.sqrt(2 * n)}


rows = [{"estimator": name, **measure(f, n, 400000)}
        for name, f in [("mad2", mad2), ("haar", wavelet("haar")), ("db4", wavelet("db4"))] for n in (100, 200, 400)]
json.dump({"versions": {"python": sys.version.split()[0], "numpy": np.__version__, "pywt": pywt.__version__}, "rows": rows},
          open("golden.json", "w"), indent=1)
