"""The package against the command line it came with, and against arguments that are wrong."""

import json
import re
import subprocess
import sys

import numpy as np
import pytest
from conftest import CAMERA, ROOT
from conftest import run_command as command

import dpn

SEED = 3


def arrays(n=40_000, seed=SEED):
    rng = np.random.default_rng(seed)
    t = np.arange(n, dtype=np.int64) * 5_000_000
    return t, 1e-3 * rng.standard_normal((n, 3)), 1e-2 * rng.standard_normal((n, 3)) + [0, 0, 9.81]


@pytest.fixture(scope="session")
def log(tmp_path_factory):
    t, gyro, accel = arrays()
    path = tmp_path_factory.mktemp("log") / "rest.csv"
    rows = "\n".join(",".join([str(s), *map(repr, map(float, [*g, *a]))]) for s, g, a in zip(t, gyro, accel))
    path.write_text("t [ns],gx [rad/s],gy [rad/s],gz [rad/s],ax [m/s^2],ay [m/s^2],az [m/s^2]\n" + rows + "\n")
    return path


def test_a_log_gives_back_the_arrays_it_was_made_of(log):
    read = dpn.read(log)
    t, gyro, accel = arrays()
    assert (read.t_ns == t).all() and (read.gyro == gyro).all() and (read.accel == accel).all()
    assert abs(read.rate - 200) < 1e-9 and len(read) == len(t) and read.t[-1] == (t[-1] - t[0]) * 1e-9
    assert read.gyro is read.gyro and not read.gyro.flags.writeable


def test_the_noise_is_the_command_lines(log, tmp_path):
    for model in ["dualpronet", "diff2"]:
        said = json.loads(command("noise", log, "--noise", model, "--json", "--out", tmp_path).stdout)
        track = dpn.noise(log, model)
        assert track.summary["summary"] == said["summary"] and track.summary["effective"] == said["effective"]
        written = np.loadtxt(tmp_path / "noise.csv", delimiter=",", skiprows=1)
        assert np.abs(track.sigma / written[:, 1:7] - 1).max() < 1e-6
        assert (track.t_ns == written[:, 0]).all()


def test_allan_and_check_are_the_command_lines(log, tmp_path):
    said = json.loads(command("allan", log, "--json", "--out", tmp_path).stdout)
    found = dpn.allan(log)
    assert found.report["log"] == said["log"] and found.report["figures"] == said["figures"]
    assert [axis.axis for axis in found.axes] == list("xyzxyz") and found.axes[0].tau[0] == 1 / found.figures.rate
    assert all(axis.low[0] < axis.deviation[0] < axis.high[0] and len(axis.coefficients) == 5 for axis in found.axes)
    checked = dpn.check(log)
    assert checked.report == json.loads(command("check", log, "--json", "--out", tmp_path).stdout)
    assert checked.findings and all(found.text and found.weight for found in checked.findings) and checked.samples == len(dpn.read(log))


def test_arrays_and_file_give_the_same_track(log):
    assert (dpn.noise(dpn.recording(*arrays())).sigma == dpn.noise(log).sigma).all()


def test_other_orders_are_taken_by_copy():
    t, gyro, accel = arrays(1000)
    other = dpn.recording(t, np.asfortranarray(gyro), accel[::1].astype(np.float64)[:, [0, 1, 2]])
    assert (other.gyro == gyro).all()


def wrong():
    t, gyro, accel = arrays(100)
    nan = accel.copy()
    nan[7, 1] = np.nan
    yield "gyro: shape (3, 100); expected (100, 3); transpose it", (t, gyro.T, accel)
    yield "gyro: shape (100,)", (t, gyro[:, 0], accel)
    yield "accel: shape (99, 3); expected (100, 3)", (t, gyro, accel[1:])
    yield "gyro: no array", (t, [[1, 2, 3], [4]], accel)
    yield "gyro: dtype complex128", (t, gyro.astype(complex), accel)
    yield "accel: dtype object", (t, gyro, accel.astype(object))
    yield "accel: nan at [7, 1]", (t, gyro, nan)
    yield "t: 495000000 to 490000000 ns at [1]", (t[::-1], gyro, accel)
    yield "t: dtype bool", (t > 3, gyro, accel)
    yield "t: nan at [0]", (np.full(100, np.nan), gyro, accel)
    yield "t: 9223372037349775808 at [99]; expected nanoseconds that int64 holds", (t.astype(np.uint64) + np.uint64(2**63), gyro, accel)
    yield "gyro: masked entries", (t, np.ma.array(gyro, mask=gyro > 0), accel)
    yield "2", (t[:1], gyro[:1], accel[:1])


@pytest.mark.parametrize("words, args", list(wrong()), ids=lambda v: v if isinstance(v, str) else "")
def test_a_wrong_array_is_named_with_what_was_expected(words, args):
    with pytest.raises(dpn.Error) as raised:
        dpn.recording(*args)
    assert words in str(raised.value) and isinstance(raised.value, ValueError)


def test_bad_logs_and_specs_are_exceptions(tmp_path, log):
    (tmp_path / "empty.csv").write_text("")
    for call in [
        lambda: dpn.read(tmp_path / "none.csv"), lambda: dpn.read(tmp_path / "empty.csv"),
        lambda: dpn.read(log, gyro_unit="turns"), lambda: dpn.noise(log, "dualpronett"), lambda: dpn.noise(log, every=0),
        lambda: dpn.noise(7), lambda: dpn.simulate("f99"), lambda: dpn.Network.load(log), lambda: dpn.convert(log, "kalibr"),
    ]:
        with pytest.raises(dpn.Error):
            call()


def test_a_network_answers_each_window_by_itself():
    network = dpn.Network.shipped()[0]
    windows = np.random.default_rng(SEED).standard_normal((5, network.window)).astype(np.float32)
    together = network.predict(windows)
    assert together.shape == (5,) and (together > 0).all()
    assert np.allclose(together[2:3], network.predict(windows[2:3]), rtol=1e-6)
    with pytest.raises(dpn.Error, match=r"windows: shape \(5, 7\)"):
        network.predict(windows[:, :7])


def test_a_flight_has_the_noise_it_says():
    flight = dpn.simulate("f07-room-medium", seed=1)
    again = dpn.simulate("f07-room-medium", seed=1)
    n = len(flight.recording)
    assert flight.sigma.shape == (n, 6) and flight.position.shape == (n, 3)
    assert (flight.recording.accel == again.recording.accel).all()
    pose = (flight.recording.t_ns[::20], flight.position[::20], flight.orientation[::20])
    moved = (pose[0], pose[1] + [1, 2, 3], pose[2])
    assert dpn.metrics.ate(pose, moved)["translation_m"]["rmse"] < 1e-9
    assert dpn.metrics.rpe(pose, moved, seconds=1.0)["translation_m"]["rmse"] < 1e-9


def test_the_command_ends_as_the_binary_does(tmp_path):
    assert "Usage" in command("--help").stdout
    assert dpn.__version__ in command("--version").stdout
    assert "none.csv" in command("check", tmp_path / "none.csv", code=2).stderr
    command("no-such-command", code=2)


def test_the_readmes_example_runs(flight, log, tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    (code,) = re.findall(r"```python\n(.*?)```", (ROOT / "python/README.md").read_text(), re.S)
    for named, there in [("flight.bag", flight[0]), ("rest.csv", log), ("V1_02_medium", "f09-hover"), ("cam0/sensor.yaml", CAMERA)]:
        assert f'"{named}"' in code
        code = code.replace(f'"{named}"', repr(str(there)))
    left = {"t": 0.0, "gyro": [0, 0, 0], "accel": [0, 0, 9.81]}
    exec(code, left)
    assert left["run"].known.any()


def test_import_takes_a_moment():
    code = "import time; t = time.process_time(); import dpn; print(time.process_time() - t)"
    # Of the processor: what else the machine does is not the import's.
    took = min(float(subprocess.check_output([sys.executable, "-c", code])) for _ in range(3))
    assert took < 0.3


def test_every_public_name_says_what_it_is():
    for module in (dpn, dpn.metrics, dpn.plot):
        for name, thing in vars(module).items():
            ours = getattr(thing, "__module__", "").startswith("dpn")
            if not name.startswith("_") and callable(thing) and ours:
                assert thing.__doc__ and len(thing.__doc__) > 20, f"{module.__name__}.{name} has no docstring"
    assert set(dpn.__all__) <= set(dir(dpn))
