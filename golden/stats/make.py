# requirements: numpy, scipy (versions used stand in the file it writes)
"""Writes golden.json: window statistics by numpy and scipy.

Run in this folder: python3 make.py
"""
import json
import sys

import numpy as np
import scipy
from scipy import stats

rng = np.random.default_rng(2)
signals = {
    "gravity": 9.81 + 0.08 * rng.standard_normal(40),
    "skewed": rng.exponential(0.004, 41),
    "offset": 1e6 + rng.standard_normal(30),
    "ties": np.round(rng.standard_normal(33) * 2) / 2,
    "two": np.array([3.0, -1.0]),
}
levels = [0.0, 0.05, 0.25, 0.5, 0.61, 0.95, 1.0]


def row(x):
    return {
        "x": x.tolist(),
        "mean": np.mean(x),
        "deviation_0": np.std(x),
        "deviation_1": np.std(x, ddof=1),
        "median": np.median(x),
        "mad": stats.median_abs_deviation(x, scale="normal"),
        "quantiles": np.quantile(x, levels).tolist(),
        "skewness": stats.skew(x),
        "kurtosis": stats.kurtosis(x),
        "differences": [np.diff(x, k).tolist() for k in range(1, min(5, len(x)))],
    }


json.dump(
    {
        "versions": {"python": sys.version.split()[0], "numpy": np.__version__, "scipy": scipy.__version__},
        "levels": levels,
        "rows": {name: row(x) for name, x in signals.items()},
    },
    open("golden.json", "w"),
)
