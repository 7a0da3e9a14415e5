"""Trajectories held against a truth: absolute (ATE) and relative (RPE) errors and NEES as ``dpn run`` reports them.

A trajectory is (t, position, orientation): t (n,) int64 ns or float s, position (n, 3) m, orientation (n, 4) world from body,
Hamilton quaternion w x y z. Every fault of one is a :class:`dpn.Error`.
"""

from __future__ import annotations

import json
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _dpn
from ._arrays import cube, poses


def _errors(truth: Any, estimate: Any, *how: Any) -> Any:
    return json.loads(_dpn.trajectory_errors(*poses("truth", truth), *poses("estimate", estimate), *how))


def ate(truth: Any, estimate: Any, *, align: str = "se3", max_diff_s: float = 0.01) -> dict[str, Any]:
    """Absolute trajectory error.

    ``truth``, ``estimate``: trajectories. ``align``: position, yaw-position, se3 or sim3. Pairs are of nearest stamps.
    Returns ``translation_m`` and ``rotation_rad``, each with count, rmse, mean, median, max.
    Raises :class:`dpn.Error`: wrong arrays, too few pairs.
    """
    found: dict[str, Any] = _errors(truth, estimate, align, max_diff_s, None, None)
    return found


def rpe(
    truth: Any, estimate: Any, *, metres: float | None = None, seconds: float | None = None, max_diff_s: float = 0.01
) -> dict[str, Any] | None:
    """Relative pose error over stretches of so many ``metres`` or ``seconds`` (one of the two); the rest as for :func:`ate`.

    None where no stretch is that long.
    """
    if (metres is None) == (seconds is None):
        raise _dpn.Error("metres, seconds: expected one of the two")
    found: dict[str, Any] | None = _errors(truth, estimate, "se3", max_diff_s, metres, seconds)
    return found


class Nees(NamedTuple):
    """Normalised estimation error squared, a row a pose that has a truth: 3 on average where the covariance is right.

    ``t_ns`` (k,) int64 [ns]; ``position``, ``orientation`` (k,), chi-square of 3 degrees of freedom each.
    """

    t_ns: NDArray[np.int64]
    position: NDArray[np.float64]
    orientation: NDArray[np.float64]


def _one(pose: Any) -> Any:
    try:
        return [[part] for part in pose]
    except TypeError:
        return pose


def nees(truth: Any, estimate: Any, covariance: ArrayLike, *, anchor: Any = None) -> Nees:
    """NEES of a run's poses under the covariances it believes.

    ``truth``, ``estimate``: trajectories; truth is interpolated, not across gaps above 0.1 s. ``covariance`` (n, 6, 6) one a
    pose of the estimate: position in its world [m], then rotation on the right, R <- R Exp(d) [rad]. ``anchor``: the pose
    taken for known, (t_ns, position, orientation) as :attr:`dpn.Run.anchor` has it; it fixes yaw and position, which no
    estimator observes. Without it the first pose does, and is left out.

    Raises :class:`dpn.Error`: wrong arrays, a covariance that is not positive definite, fewer than two poses with a truth.
    """
    true_t_ns, true_poses = poses("truth", truth)
    est_t_ns, est_poses = poses("estimate", estimate)
    believed = cube("covariance", covariance, len(est_t_ns), 6)
    known = None if anchor is None else poses("anchor", _one(anchor))
    t_ns, found = _dpn.trajectory_nees(true_t_ns, true_poses, est_t_ns, est_poses, believed, known)
    return Nees(t_ns, found[:, 0], found[:, 1])
