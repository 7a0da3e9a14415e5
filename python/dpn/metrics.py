"""Trajectories held against a truth: absolute (ATE) and relative (RPE) errors as ``dpn run`` reports them."""

import json

from . import _dpn
from ._arrays import poses


def _errors(truth, estimate, align, max_diff_s, step_m=None, step_s=None):
    args = [*poses("truth", truth), *poses("estimate", estimate)]
    return json.loads(_dpn.trajectory_errors(*args, align, max_diff_s, step_m, step_s))


def ate(truth, estimate, *, align="se3", max_diff_s=0.01):
    """Absolute trajectory error.

    ``truth``, ``estimate``: (t, position, orientation) with t (n,) int64 ns or float s, position (n, 3) m, orientation (n, 4)
    world from body, w x y z. ``align``: position, yaw-position, se3 or sim3. Pairs are of nearest stamps.
    Returns ``translation_m`` and ``rotation_rad``, each with count, rmse, mean, median, max.
    Raises :class:`dpn.Error`: wrong arrays, too few pairs.
    """
    return _errors(truth, estimate, align, max_diff_s)


def rpe(truth, estimate, *, metres=None, seconds=None, max_diff_s=0.01):
    """Relative pose error over stretches of so many ``metres`` or ``seconds`` (one of the two); arrays and result as in :func:`ate`.

    None where no stretch is that long.
    """
    if (metres is None) == (seconds is None):
        raise _dpn.Error("metres, seconds: expected one of the two")
    return _errors(truth, estimate, "se3", max_diff_s, metres, seconds)
