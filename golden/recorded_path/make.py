# requirements: numpy, scipy (versions used stand in the file it writes)
"""Writes golden.json: poses at 200 Hz, and what scipy makes of them between their stamps: savgol_filter over .1 s (21 poses, order 3)
on position and quaternion, CubicSpline through the result, the quaternion brought to length 1.

Run in this folder: python3 make.py
"""
import json

import numpy as np
import scipy
from scipy.interpolate import CubicSpline
from scipy.signal import savgol_filter
from scipy.spatial.transform import Rotation

rng = np.random.default_rng(3)
n = 70
t = 5_000_000 * np.arange(n)
s = t * 1e-9
position = np.c_[np.sin(9 * s), np.cos(7 * s), s * s] + 1e-3 * rng.standard_normal((n, 3))
turn = np.c_[2 * np.sin(8 * s), 3 * s, -1 + 6 * s] + 1e-3 * rng.standard_normal((n, 3))
quaternion = Rotation.from_rotvec(turn).as_quat()[:, [3, 0, 1, 2]]
# Signs as a file has them: any.
quaternion *= np.where(rng.random(n) < .3, -1, 1)[:, None]
at = np.sort(rng.integers(0, t[-1] + 1, 40))
at[0], at[-1] = 0, t[-1]

steady = quaternion * np.cumprod(np.r_[1, np.sign((quaternion[1:] * quaternion[:-1]).sum(1))])[:, None]
p = CubicSpline(s, savgol_filter(position, 21, 3, axis=0))(at * 1e-9)
q = CubicSpline(s, savgol_filter(steady, 21, 3, axis=0))(at * 1e-9)
q /= np.linalg.norm(q, axis=1)[:, None]
json.dump({
    "made_with": {"numpy": np.__version__, "scipy": scipy.__version__},
    "t_ns": t.tolist(), "position": position.tolist(), "quaternion_wxyz": quaternion.tolist(),
    "at_ns": at.tolist(), "expected_position": p.tolist(), "expected_quaternion_wxyz": q.tolist(),
}, open("golden.json", "w"))
