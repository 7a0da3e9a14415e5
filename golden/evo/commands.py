# requirements: evo, numpy, scipy (versions used stand in the file it writes)
"""Writes commands.json: what evo_ape and evo_rpe, run as programs, say of twenty made-up pairs of trajectories under their options.

A pair is a flight of some seconds and an estimate of it in a world of its own, with drift, noise and stamps that are off. Numbers are rounded
before anybody reads them, quaternions are of length 1 to twelve digits, and stamps are small, so that evo's floats hold them.

Run in this folder: python3 commands.py
"""
import json
import os
import subprocess
import sys
import tempfile
import zipfile
from importlib.metadata import version
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

# Layout of both files, rows of truth and estimate, options of evo_ape and of evo_rpe.
CASES = [
    ("tum", 60, 30, [], []),
    ("tum", 60, 30, ["-a"], ["-r", "angle_deg"]),
    ("tum", 60, 30, ["-a", "-s"], ["-s"]),
    ("tum", 60, 30, ["-s"], ["-a", "-s", "-r", "full"]),
    ("tum", 60, 30, ["--align_origin"], ["-d", "3"]),
    ("tum", 60, 30, ["-a", "--n_to_align", "10"], ["-d", "1", "-u", "m"]),
    ("tum", 60, 30, ["-a", "-s", "--n_to_align", "12"], ["-d", "1.5", "-u", "m", "--all_pairs"]),
    ("tum", 60, 30, ["-s", "--align_origin"], ["-s", "--align_origin", "-d", "20", "-u", "d"]),
    ("tum", 60, 30, ["-a", "-r", "rot_part"], ["-r", "rot_part", "-d", "0.4", "-u", "r", "--all_pairs"]),
    ("tum", 60, 30, ["-a", "-r", "angle_deg"], ["-r", "point_distance"]),
    ("tum", 60, 30, ["-a", "-r", "angle_rad"], ["-r", "angle_rad", "-d", "4", "--all_pairs"]),
    ("tum", 60, 30, ["-a", "-r", "full"], ["-r", "full", "-d", "2", "-u", "m", "--all_pairs", "--pairs_from_reference"]),
    ("tum", 60, 30, ["-a", "-r", "point_distance"], ["-r", "point_distance", "-d", "1", "-u", "m"]),
    ("tum", 60, 30, ["-a", "--t_max_diff", "0.03"], ["--t_max_diff", "0.03", "-d", "2", "-u", "m", "-t", "0.3", "--all_pairs"]),
    ("tum", 60, 30, ["-a", "--t_offset", "0.06"], ["--t_offset", "-0.065"]),
    ("tum", 60, 30, ["-a", "--t_start", "101", "--t_end", "103.1"], ["--t_start", "100.5", "--t_end", "103"]),
    ("tum", 24, 48, ["-a"], ["-d", "1", "-u", "m", "--all_pairs"]),
    ("kitti", 30, 30, ["-a"], ["-d", "1", "-u", "m"]),
    ("kitti", 30, 30, ["-a", "-s", "-r", "full"], ["-r", "angle_deg", "-d", "5", "--all_pairs"]),
    ("euroc", 60, 30, ["-a", "-s"], ["-d", "1", "-u", "m", "--all_pairs"]),
]
SECONDS = 4.0


def flight(seed, layout, rows, of_estimate):
    rng = np.random.default_rng([seed, of_estimate])
    t = SECONDS * np.arange(1, rows + 1) / rows
    if layout != "kitti":
        t = t + rng.uniform(-0.006, 0.006, rows)
    t = np.round(t, 4)
    way = np.random.default_rng([seed, 7]).uniform(0.5, 2.0, (3, 3))
    position = np.stack([a * np.sin(w * t + p) for a, w, p in way], axis=-1)
    rotation = Rotation.from_rotvec(np.stack([0.3 * np.sin(w * t + a) * p for a, w, p in way], axis=-1))
    if of_estimate:
        world = Rotation.from_rotvec(rng.uniform(-1.5, 1.5, 3))
        drift = np.cumsum(0.01 * rng.standard_normal((rows, 3)), axis=0)
        position = rng.uniform(0.8, 1.25) * world.apply(position) + rng.uniform(-5, 5, 3) + drift
        rotation = world * rotation * Rotation.from_rotvec(0.02 * rng.standard_normal((rows, 3)))
    return t, np.round(position, 6), np.round(rotation.as_quat(), 12), rotation


def lines(layout, of_estimate, t, position, quaternion, rotation):
    if layout == "kitti":
        matrices = np.concatenate([rotation.as_matrix(), position[:, :, None]], axis=2).reshape(-1, 12)
        return [" ".join(f"{v:.12f}" for v in row) for row in matrices]
    if layout == "euroc" and not of_estimate:
        head = ["#timestamp,px,py,pz,qw,qx,qy,qz,vx,vy,vz,bwx,bwy,bwz,bax,bay,baz"]
        return head + [
            ",".join([str(round((100 + s) * 1e9))] + [repr(float(v)) for v in [*p, q[3], *q[:3]]] + ["0"] * 9)
            for s, p, q in zip(t, position, quaternion)
        ]
    return [
        " ".join([f"{100 + s:.4f}"] + [repr(float(v)) for v in [*p, *q]]) for s, p, q in zip(t, position, quaternion)
    ]


def said(command, layout, files, options, folder):
    results = folder / "results.zip"
    results.unlink(missing_ok=True)
    program = Path(sys.executable).parent / command
    home = {**os.environ, "HOME": str(folder)}
    subprocess.run(
        [program, layout, *files, *options, "--save_results", results, "--no_warnings"],
        check=True, stdout=subprocess.DEVNULL, cwd=folder, env=home,
    )
    with zipfile.ZipFile(results) as packed:
        stats = json.loads(packed.read("stats.json"))
        errors = np.load(packed.open("error_array.npy"))
    return {"options": options, "count": len(errors), **{key: stats[key] for key in ("rmse", "mean", "median", "max")}}


cases = []
with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    for seed, (layout, truth_rows, estimate_rows, ape, rpe) in enumerate(CASES):
        truth = lines(layout, False, *flight(seed, layout, truth_rows, 0))
        estimate = lines(layout, True, *flight(seed, layout, estimate_rows, 1))
        files = [folder / "truth", folder / "estimate"]
        for file, text in zip(files, (truth, estimate)):
            file.write_text("\n".join(text) + "\n")
        cases.append({
            "truth": truth,
            "estimate": estimate,
            "ape": said("evo_ape", layout, files, ape, folder),
            "rpe": said("evo_rpe", layout, files, rpe, folder),
        })

versions = {"python": sys.version.split()[0], **{name: version(name) for name in ("evo", "numpy", "scipy")}}
with open("commands.json", "w") as out:
    json.dump({"versions": versions, "cases": cases}, out, indent=0)
    out.write("\n")
