# requirements: numpy, scipy (versions used stand in the file it writes)
"""Writes golden.json: scipy.signal.welch, Hann window, half overlap, one-sided density.

Run in this folder: python3 make.py
"""
import json
import sys

import numpy as np
import scipy
from scipy.signal import welch

rng = np.random.default_rng(4)
t = np.arange(300) / 200
x = 9.81 + 0.9 * np.sin(2 * np.pi * 93 * t) + 0.05 * rng.standard_normal(300)


def case(segment, detrend):
    hz, density = welch(x, fs=200.0, nperseg=segment, detrend="constant" if detrend else False)
    return {"segment": segment, "remove_mean": detrend, "hz": hz.tolist(), "density": density.tolist()}


json.dump(
    {
        "versions": {"python": sys.version.split()[0], "numpy": np.__version__, "scipy": scipy.__version__},
        "rate": 200.0,
        "x": x.tolist(),
        "cases": [case(64, True), case(64, False), case(51, True), case(300, True), case(50, True)],
    },
    open("golden.json", "w"),
)
