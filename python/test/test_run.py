"""``dpn.run`` against ``dpn run``, and what it says of arguments that are wrong."""

import os
import signal
import threading
import time

import numpy as np
import pytest
from conftest import CAMERA, ROOT, said_by_run

import dpn

SPAN = {"start": 50.0, "end": 70.0}
FLAGS = ["--from", "50", "--to", "70"]
# Of one run and another: processor's times.
TIMES = ["cpu_per_data_s", "p95_update_ms", "stage_s"]


def figures(report):
    row = {key: value for key, value in report["report"]["row"].items() if key not in TIMES}
    if row["front_end"]:
        row["front_end"] = {k: v for k, v in row["front_end"].items() if not k.endswith("_ms") and "cpu" not in k}
    rest = {key: value for key, value in report.items() if key != "report"}
    return rest, {**report["report"], "row": row}


def observations(path):
    t, ids, px = [], [], []
    for line in path.read_text().splitlines():
        if not line.startswith("#"):
            stamp, _, *values = line.split()
            values = np.array(values, dtype=float).reshape(-1, 3)
            t += [int(stamp)] * len(values)
            ids += [int(v) for v in values[:, 0]]
            px.append(values[:, 1:])
    return np.array(t), np.array(ids), np.concatenate(px)


def truth(folder):
    rows = np.genfromtxt(folder / "mav0/state_groundtruth_estimate0/data.csv", delimiter=",", skip_header=1)
    stamps = np.genfromtxt(folder / "mav0/state_groundtruth_estimate0/data.csv", delimiter=",", skip_header=1, usecols=0, dtype=np.int64)
    return stamps, rows[:, 1:4], rows[:, 4:8]


@pytest.mark.parametrize("noise", ["x1", "self", "dualpronet"])
def test_a_folders_run_is_the_command_lines(flight, tmp_path, noise):
    folder, tracks = flight
    said = said_by_run(tmp_path, folder, "--tracks", tracks, "--calib", CAMERA, "--noise", noise, *FLAGS, "--set", "covariance=true")
    run = dpn.run(folder, noise, tracks=tracks, calibration=CAMERA, config={"covariance": True}, **SPAN)
    assert figures(run.report) == figures(said)
    assert said["report"]["row"]["ate_se3"] < 0.5 and run.known.sum() == said["report"]["row"]["poses"]
    written = np.loadtxt(tmp_path / "trajectory.tum")
    assert (run.trajectory[:, 1:] == written[:, 1:]).all() and np.abs(run.trajectory[:, 0] - written[:, 0]).max() < 1e-6
    states = [line.split(",") for line in (tmp_path / "states.csv").read_text().splitlines() if line[0] != "#"]
    states = np.array([[v or "nan" for v in line[2:]] for line in states], dtype=float)
    for first, found in ((7, run.velocity), (10, run.accel_bias), (13, run.gyro_bias)):
        assert np.array_equal(states[:, first : first + 3], found, equal_nan=True)
    believed = np.sqrt(np.diagonal(run.covariance, axis1=1, axis2=2))
    assert np.allclose(states[:, 16:22], believed, rtol=1e-12, equal_nan=True)
    in_force = run.noise[np.searchsorted(run.noise_t_ns, run.t_ns, side="right") - 1]
    assert (states[:, 22:28] == in_force).all()
    assert (run.levels is not None) == (noise == "self")
    if noise == "self":
        assert np.array_equal(states[:, 34:37], run.levels[:, 6:], equal_nan=True)


def test_arrays_give_the_numbers_of_their_files(flight):
    folder, tracks = flight
    of_files = dpn.run(folder, "x1", tracks=tracks, calibration=CAMERA, **SPAN)
    t, gyro, accel = (lambda log: (log.t_ns, log.gyro, log.accel))(dpn.read(folder))
    camera = {
        "T_BS": {"cols": 4, "rows": 4, "data": np.array(
            [0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975, 0.999557249008, 0.0149672133247,
             0.025715529948, -0.064676986768, -0.0257744366974, 0.00375618835797, 0.999660727178, 0.00981073058949, 0, 0, 0, 1])},
        "rate_hz": 20, "resolution": [752, 480], "camera_model": "pinhole", "intrinsics": [458.654, 457.296, 367.215, 248.375],
        "distortion_model": "radial-tangential",
        "distortion_coefficients": [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05],
    }
    log = dpn.recording(t, gyro, accel)
    of_arrays = dpn.run(log, "x1", tracks=observations(tracks), calibration=camera, truth=truth(folder), name=folder.name, **SPAN)
    assert np.array_equal(of_arrays.position, of_files.position, equal_nan=True)
    ours, theirs = (run.report["report"]["row"] for run in (of_arrays, of_files))
    assert abs(ours["ate_se3"] / theirs["ate_se3"] - 1) < 1e-6 and ours["poses"] == theirs["poses"]
    known = of_arrays.known
    estimate = (of_arrays.t_ns[known], of_arrays.position[known], of_arrays.orientation[known])
    assert abs(dpn.metrics.ate(truth(folder), estimate)["translation_m"]["rmse"] / ours["ate_se3"] - 1) < 0.02


def test_nees_is_that_of_the_report(flight):
    folder, tracks = flight
    run = dpn.run(folder, "x1", tracks=tracks, calibration=CAMERA, config={"covariance": True}, **SPAN)
    known, row = run.known, run.report["report"]["row"]
    estimate = (run.t_ns[known], run.position[known], run.orientation[known])
    found = dpn.metrics.nees(truth(folder), estimate, run.covariance[known], anchor=run.anchor)
    assert found.position.mean() == pytest.approx(row["nees_position"], rel=1e-6)
    assert found.orientation.mean() == pytest.approx(row["nees_orientation"], rel=1e-6)
    # Half the deviation is four times the NEES: the test can fail.
    half = dpn.metrics.nees(truth(folder), estimate, run.covariance[known] / 4, anchor=run.anchor)
    assert half.position.mean() == pytest.approx(4 * row["nees_position"], rel=1e-6)
    with pytest.raises(dpn.Error, match=r"covariance: shape \(3, 6, 6\); expected"):
        dpn.metrics.nees(truth(folder), estimate, run.covariance[:3])
    with pytest.raises(dpn.Error, match=r"anchor: int; expected \(t, position, orientation\)"):
        dpn.metrics.nees(truth(folder), estimate, run.covariance[known], anchor=3)
    with pytest.raises(dpn.Error, match="not positive definite"):
        dpn.metrics.nees(truth(folder), estimate, 0 * run.covariance[known])


def test_noise_may_be_a_file_and_configuration_a_file(flight, tmp_path):
    folder, tracks = flight
    log = dpn.read(folder)
    rows = [f"{t},.1,.1,.1,.01,.01,.01" for t in log.t_ns[[0, -1]]]
    header = "#timestamp [ns],accel_std_x,accel_std_y,accel_std_z,gyro_std_x,gyro_std_y,gyro_std_z\n"
    (tmp_path / "noise.csv").write_text(header + "\n".join(rows) + "\n")
    (tmp_path / "vio.toml").write_text("[window]\nkey_frames = 6\n")
    spec = f'file("{tmp_path / "noise.csv"}")'
    run = dpn.run(folder, spec, tracks=tracks, calibration=CAMERA, config=tmp_path / "vio.toml", **SPAN)
    assert (run.noise[:, 0] == 0.1).all() and run.report["estimator"]["window"]["key_frames"] == 6
    same = dpn.run(folder, spec, tracks=tracks, calibration=CAMERA, config={"window": {"key_frames": 6}}, **SPAN)
    assert np.array_equal(run.position, same.position, equal_nan=True)


@pytest.mark.skipif(not (ROOT / "data/motion").exists(), reason="the pack of images is not unpacked")
def test_images_are_followed_as_by_the_command_line(tmp_path):
    folder = ROOT / "data/motion/MH_01_easy_start"
    said = said_by_run(tmp_path, folder, "--noise", "x1", "--to", "10")
    run = dpn.run(folder, "x1", end=10)
    assert figures(run.report) == figures(said)
    assert said["report"]["row"]["camera"] == "images" and run.known.sum() > 50


def test_progress_is_told_in_seconds_and_may_end_the_run():
    told = []
    run = dpn.run("room-medium", "x1", start=50, end=60, progress=lambda done, total: told.append((done, total)))
    done = [entry[0] for entry in told]
    assert len(told) == len(run.t_ns) and done == sorted(done) and told[-1][0] > 0.98 * told[-1][1] > 9

    def enough(done, total):
        if done > 2:
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        dpn.run("room-medium", "x1", progress=enough)
    began = time.perf_counter()
    with pytest.raises(ZeroDivisionError):
        dpn.run("room-medium", "x1", camera="rendered", progress=lambda done, total: 1 / 0)
    assert time.perf_counter() - began < 20


def test_ctrl_c_ends_a_run_and_other_threads_go_on():
    # A thread that sends the signal runs at all only where the interpreter was let go of.
    threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    began = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        for _ in range(1000):
            dpn.run("room-medium", "x1")
    assert time.perf_counter() - began < 5


def wrong(flight):
    log = dpn.read(flight[0])
    t, ids, px = observations(flight[1])
    nan = px.copy()
    nan[3, 1] = np.nan
    twice = ids.copy()
    twice[1] = twice[0]
    given = {"tracks": (t, ids, px), "calibration": CAMERA}
    of = lambda **other: (log, {**given, **other})
    yield "tracks: expected (t, ids, px)", of(tracks=None)
    yield "tracks: expected (t, ids, px)", of(tracks=flight[1])
    yield "calibration: None; expected a file or a dictionary", of(calibration=None)
    yield f"tracks[0]: {t[-1]} to ", of(tracks=(t[::-1], ids, px))
    yield "tracks[1]: dtype float64; expected whole numbers from 0", of(tracks=(t, ids * 1.0, px))
    yield f"tracks[1]: shape (5,); expected ({len(t)},)", of(tracks=(t, ids[:5], px))
    yield "tracks[1]: -1 at [0]; expected whole numbers from 0", of(tracks=(t, np.where(ids == ids[0], -1, ids), px))
    yield f"tracks[1]: id {ids[0]} twice in the frame of {t[0]} ns", of(tracks=(t, twice, px))
    yield f"tracks[2]: shape (2, {len(t)}); expected ({len(t)}, 2); transpose it", of(tracks=(t, ids, px.T))
    yield "tracks[2]: nan at [3, 1]; expected finite numbers", of(tracks=(t, ids, nan))
    yield "both on one clock", of(tracks=(t + 10**12, ids, px))
    yield "truth: int; expected (t, position, orientation)", of(truth=3)
    yield "camera: 'images'; expected none where `log` is a Recording", of(camera="images")
    yield "calibration: ", of(calibration={"T_BS": 3})
    yield "calibration: object; expected finite numbers", (log, {**given, "calibration": {"a": object()}})
    yield "noise: ", of(noise="dualpronett")
    yield "noise: int; expected a spec", of(noise=4)
    yield "unknown field `key_frame`", of(config={"window": {"key_frame": 3}})
    yield "config: int; expected a TOML file or a dictionary", of(config=4)
    yield "seed: -1; expected an integer from 0", of(seed=-1)
    yield "start: ", of(start=-1)
    yield "end: nan; expected seconds from 0", of(end=float("nan"))
    yield "progress: str; expected a function", of(progress="bar")
    yield "log: int; expected a dpn.Recording, a path or the name of a flight", (3, {})
    yield "camera: ", ("room-medium", {"camera": "film"})
    yield "tracks: tuple; expected a path", ("room-medium", {"tracks": (t, ids, px)})
    yield "there is no folder `hovr`, and no flight", ("hovr", {})
    yield "a flight has no folder of images", ("hover", {"camera": "images"})


def test_what_is_wrong_is_named_with_what_was_expected(flight):
    for words, (log, given) in wrong(flight):
        with pytest.raises(dpn.Error) as raised:
            dpn.run(log, **{"noise": "x1", **given})
        assert words in str(raised.value), f"{raised.value} has no `{words}`"
