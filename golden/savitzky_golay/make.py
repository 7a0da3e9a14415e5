# requirements: numpy, scipy (versions used stand in the file it writes)
"""Writes golden.json: inputs, scipy.signal.savgol_filter(mode="interp"), and the same filter in exact rationals.

Run in this folder: python3 make.py
"""
import json
import sys
from fractions import Fraction

import numpy as np
import scipy
from scipy.signal import savgol_filter


def exact(x, window, order):
    """Least squares in rational arithmetic: every output is the fitted polynomial, rounded once at the end."""
    half = window // 2
    powers = [[Fraction(i - half) ** k for k in range(order + 1)] for i in range(window)]
    normal = [
        [sum(powers[i][a] * powers[i][b] for i in range(window)) for b in range(order + 1)]
        + [Fraction(int(a == b)) for b in range(order + 1)]
        for a in range(order + 1)
    ]
    size = order + 1
    for col in range(size):  # Gauss-Jordan; the pivot is never zero for a positive definite matrix
        pivot = normal[col][col]
        normal[col] = [v / pivot for v in normal[col]]
        for row in range(size):
            if row != col:
                factor = normal[row][col]
                normal[row] = [v - factor * p for v, p in zip(normal[row], normal[col])]
    inverse = [row[size:] for row in normal]
    hat = []
    for i in range(window):
        left = [sum(powers[i][a] * inverse[a][b] for a in range(size)) for b in range(size)]
        hat.append([sum(left[b] * powers[j][b] for b in range(size)) for j in range(window)])
    x = [Fraction(v) for v in x]
    out = []
    for t in range(len(x)):
        start = min(max(t - half, 0), len(x) - window)
        out.append(float(sum(h * v for h, v in zip(hat[t - start], x[start : start + window]))))
    return out


rng = np.random.default_rng(1)
t = np.arange(120) / 200
signals = {
    "gravity": 9.81 + 0.4 * np.sin(2 * np.pi * 1.3 * t) + 0.9 * np.sin(2 * np.pi * 93 * t) + 0.05 * rng.standard_normal(120),
    "gyro": 0.2 * np.cos(2 * np.pi * 0.7 * t) + 0.004 * rng.standard_normal(120),
    "offset": 1e6 + rng.standard_normal(120),
    "short": rng.standard_normal(57),
}
against_scipy = [
    (name, window, order)
    for name in ["gravity", "gyro"]
    for window, order in [(5, 2), (7, 2), (11, 2), (21, 3), (51, 3)]
] + [("gyro", 1, 0), ("gyro", 9, 0), ("gyro", 5, 4), ("gyro", 9, 1), ("offset", 11, 2), ("short", 57, 3)]
against_exact = [("short", 5, 2), ("short", 11, 2), ("short", 21, 3), ("short", 51, 3), ("short", 51, 12), ("short", 13, 12),
                 ("offset", 21, 3)]

json.dump(
    {
        "versions": {"python": sys.version.split()[0], "numpy": np.__version__, "scipy": scipy.__version__},
        "signals": {name: x.tolist() for name, x in signals.items()},
        "scipy": [
            {"signal": n, "window": w, "order": p, "expected": savgol_filter(signals[n], w, p, mode="interp").tolist()}
            for n, w, p in against_scipy
        ],
        "exact": [{"signal": n, "window": w, "order": p, "expected": exact(signals[n].tolist(), w, p)} for n, w, p in against_exact],
    },
    open("golden.json", "w"),
)
