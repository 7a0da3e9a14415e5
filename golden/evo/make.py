# requirements: evo, numpy, scipy (versions used stand in the file it writes)
"""Writes golden.json: absolute and relative pose errors by evo, on a synthetic pair of trajectories and on 12 s of a real one.

The real one is VINS-Mono's estimate of V1_02_medium at four times its noise constants against EuRoC's ground truth, of which the
rows on either side of every estimated pose are kept. evo has no alignment of yaw and position alone; there scipy minimises over
the yaw, from many starts.

Run in this folder, with the data sets unpacked in $DPN_DATA or ../../data: python3 make.py
"""
import copy
import json
import os
import sys
from importlib.metadata import version
from pathlib import Path

import numpy as np
import scipy
from evo.core import metrics, sync
from evo.core.metrics import PoseRelation, Unit
from evo.core.sync_method import SyncMethod
from evo.core.trajectory import PoseTrajectory3D
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

EPOCH_NS = 1_403_715_000_000_000_000


def evo_trajectory(rows):
    """Rows t_ns x y z qx qy qz qw; evo's stamps are floats, so they count from an epoch nearby."""
    t = np.array([(row[0] - EPOCH_NS) * 1e-9 for row in rows])
    values = np.array([row[1:] for row in rows])
    return PoseTrajectory3D(values[:, :3], values[:, [6, 3, 4, 5]], t)


def error_summary(metric):
    statistics = metric.get_all_statistics()
    return {"count": len(metric.error), **{key: float(statistics[key]) for key in ("rmse", "mean", "median", "max")}}


def ape(truth, estimate, relation):
    metric = metrics.APE(relation)
    metric.process_data((truth, estimate))
    return error_summary(metric)


def rpe(truth, estimate, relation, delta, unit):
    metric = metrics.RPE(relation, delta, unit, rel_delta_tol=0.1, all_pairs=True, pairs_from_reference=True)
    metric.process_data((truth, estimate))
    return error_summary(metric)


def named_rpe(truth, estimate, relation, delta, unit, all_pairs, from_reference):
    metric = metrics.RPE(
        relation, delta, unit, rel_delta_tol=0.1, all_pairs=all_pairs, pairs_from_reference=from_reference
    )
    metric.process_data((truth, estimate))
    return error_summary(metric)


UNITS = {"m": Unit.meters, "f": Unit.frames, "deg": Unit.degrees}


def by_name(truth, estimate):
    """Every definition that dpn has a name for."""
    cases = {}
    for delta, unit in ((1.0, "m"), (2.5, "m"), (1, "f"), (7, "f"), (20.0, "deg")):
        for all_pairs in (False, True):
            for from_reference in (False, True):
                name = f"{delta:g}{unit}" + ":all_pairs" * all_pairs + ":pairs_from_reference" * from_reference
                cases[name] = both(named_rpe, truth, estimate, delta, UNITS[unit], all_pairs, from_reference)
    return cases


def both(kind, *arguments):
    return {
        "translation": kind(*arguments[:2], PoseRelation.translation_part, *arguments[2:]),
        "rotation": kind(*arguments[:2], PoseRelation.rotation_angle_rad, *arguments[2:]),
    }


def yaw_of_least_squares(truth, estimate):
    y = truth.positions_xyz - truth.positions_xyz.mean(axis=0)
    x = estimate.positions_xyz - estimate.positions_xyz.mean(axis=0)

    def cost(yaw):
        return np.sum((y - Rotation.from_euler("z", yaw).apply(x)) ** 2)

    starts = np.linspace(-np.pi, np.pi, 13)
    found = [minimize_scalar(cost, bracket=(s - 0.3, s + 0.3), tol=1e-14).x for s in starts]
    return min(found, key=cost)


def absolute(truth, estimate):
    cases = {"none": both(ape, truth, estimate)}
    for name, scale in (("se3", False), ("sim3", True)):
        aligned = copy.deepcopy(estimate)
        r, t, c = aligned.align(truth, correct_scale=scale)
        cases[name] = {
            **both(ape, truth, aligned),
            "rotation_matrix": np.asarray(r).tolist(),
            "offset": np.asarray(t).tolist(),
            "scale": float(c),
        }
    yaw = yaw_of_least_squares(truth, estimate)
    turn = Rotation.from_euler("z", yaw).as_matrix()
    offset = truth.positions_xyz.mean(axis=0) - turn @ estimate.positions_xyz.mean(axis=0)
    aligned = copy.deepcopy(estimate)
    transform = np.eye(4)
    transform[:3, :3], transform[:3, 3] = turn, offset
    aligned.transform(transform)
    cases["yaw_position"] = {
        **both(ape, truth, aligned),
        "rotation_matrix": turn.tolist(),
        "offset": offset.tolist(),
        "scale": 1.0,
    }
    aligned = copy.deepcopy(estimate)
    transform = np.eye(4)
    transform[:3, 3] = (truth.positions_xyz - estimate.positions_xyz).mean(axis=0)
    aligned.transform(transform)
    cases["position"] = {
        **both(ape, truth, aligned),
        "rotation_matrix": np.eye(3).tolist(),
        "offset": transform[:3, 3].tolist(),
        "scale": 1.0,
    }
    return cases


def case(truth_rows, estimate_rows, frames, metres):
    truth, estimate = evo_trajectory(truth_rows), evo_trajectory(estimate_rows)
    methods = {}
    for name, method in (("nearest", SyncMethod.nearest_time), ("interpolated", SyncMethod.interpolation)):
        a, b = sync.associate_trajectories(truth, estimate, sync_method=method, max_diff=0.01)
        first = a.poses_se3[0]
        methods[name] = {
            "pairs": len(a.timestamps),
            "first_truth_position": first[:3, 3].tolist(),
            "absolute": absolute(a, b),
            "by_frames": [{"step": n, **both(rpe, a, b, n, Unit.frames)} for n in frames],
            "by_name": by_name(a, b),
            "by_metres": [{"step": m, **both(rpe, a, b, m, Unit.meters)} for m in metres],
        }
    return {"truth": truth_rows, "estimate": estimate_rows, "methods": methods}


def rows_of(t_ns, positions, rotations, digits):
    quaternions = rotations.as_quat()
    return [
        [int(t), *np.round(p, digits).tolist(), *np.round(q, digits).tolist()]
        for t, p, q in zip(t_ns, positions, quaternions)
    ]


def synthetic():
    """A flight of 15 s, truth at 20 Hz with jitter, estimate at 5 Hz in a world turned, moved and scaled, with noise and drift."""
    rng = np.random.default_rng(9)
    truth_ns = EPOCH_NS + (np.arange(300) * 50_000_000 + rng.integers(-2_000_000, 2_000_000, 300))
    estimate_ns = EPOCH_NS + 100_000_000 + np.arange(70) * 200_000_000 + rng.integers(-3_000_000, 3_000_000, 70)

    def position(t):
        return np.stack([4 * np.sin(0.5 * t), 3 * np.cos(0.37 * t), 1 + 0.4 * np.sin(0.9 * t)], axis=-1)

    def rotation(t):
        return Rotation.from_rotvec(
            np.stack([0.3 * np.sin(0.8 * t), 0.2 * np.cos(1.1 * t), 0.6 * t - 2], axis=-1)
        )

    t = (truth_ns - EPOCH_NS) * 1e-9
    truth = rows_of(truth_ns, position(t), rotation(t), 9)
    t = (estimate_ns - EPOCH_NS) * 1e-9
    world = Rotation.from_rotvec([0.03, -0.02, 1.9])
    drift = np.cumsum(0.004 * rng.standard_normal((70, 3)), axis=0)
    positions = 1.04 * world.apply(position(t)) + np.array([5, -7, 0.5]) + drift + 0.01 * rng.standard_normal((70, 3))
    rotations = world * rotation(t) * Rotation.from_rotvec(0.01 * rng.standard_normal((70, 3)))
    return truth, rows_of(estimate_ns, positions, rotations, 9)


def recorded():
    data = Path(os.environ.get("DPN_DATA", "../../data"))
    estimate = []
    for line in (data / "peers/vins_mono/V1_02_medium.x4.tum").read_text().splitlines():
        seconds, *values = line.split()
        whole, fraction = seconds.split(".")
        estimate.append([int(whole) * 10**9 + int(fraction.ljust(9, "0")), *map(float, values)])
    estimate = estimate[250:370]
    path = data / "euroc/V1_02_medium/mav0/state_groundtruth_estimate0/data.csv"
    truth = []
    for line in path.read_text().splitlines():
        if not line.startswith("#"):
            t, *v = line.split(",")
            v = [float(x) for x in v[:7]]
            truth.append([int(t), *v[:3], *v[4:7], v[3]])
    stamps = np.array([row[0] for row in truth])
    above = np.searchsorted(stamps, [row[0] for row in estimate], side="right")
    kept = sorted({int(i) for k in above for i in (k - 1, k)})
    return [truth[i] for i in kept], estimate


golden = {
    "versions": {
        "python": sys.version.split()[0],
        "evo": version("evo"),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
    },
    "cases": {
        "synthetic": case(*synthetic(), frames=[5, 25], metres=[1.0, 5.0, 10.0]),
        "V1_02_medium.x4": case(*recorded(), frames=[10, 50], metres=[1.0, 2.0, 5.0]),
    },
}
with open("golden.json", "w") as out:
    json.dump(golden, out)
    out.write("\n")
