# requirements: numpy, PyWavelets (versions used stand in the file it writes)
"""Writes golden.json: finest detail coefficients by pywt.dwt, those alone that no border extension touches.

Run in this folder: python3 make.py
"""
import json
import sys

import numpy as np
import pywt

rng = np.random.default_rng(3)
signals = {n: (9.81 + 0.08 * rng.standard_normal(n)).tolist() for n in (8, 33, 64)}


def inner(x, name):
    length = pywt.Wavelet(name).dec_len
    detail = pywt.dwt(x, name, mode="symmetric")[1]
    # pywt: detail[k] = sum_j dec_hi[j] x[2 k + 1 - j], so 2 k + 1 runs from length - 1 to len(x) - 1
    return detail[(length - 1) // 2 : len(x) // 2].tolist()


json.dump(
    {
        "versions": {"python": sys.version.split()[0], "numpy": np.__version__, "pywt": pywt.__version__},
        "cases": [
            {"wavelet": name, "x": x, "detail": inner(x, name)} for x in signals.values() for name in ("haar", "db2", "db4")
        ],
    },
    open("golden.json", "w"),
)
