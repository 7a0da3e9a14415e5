"""Networks fed sample by sample and trained."""

import os
import signal

import numpy as np
import pytest
from conftest import EXCERPT
from conftest import run_command as command

import dpn

TINY = {
    "fit": {"epochs": 2, "validate_every": 1},
    "network": {
        "channels": [4, 4, 8], "kernels": [5, 3, 3], "strides": [1, 4, 2], "paddings": [2, 1, 1], "hidden": [8, 8, 4],
    },
}


def test_a_stream_says_what_the_track_of_the_same_samples_says():
    log = dpn.read(EXCERPT)
    track, stream, answers = dpn.noise(log, "dualpronet"), dpn.Stream(), {}
    for t, gyro, accel in zip(log.t_ns, log.gyro, log.accel):
        stream.feed(t, gyro, accel)
        answers[int(t)] = stream.sigma()
    assert not answers[int(log.t_ns[198])].known and answers[int(log.t_ns[199])].known
    known = [(row, answers[int(t)]) for t, row in zip(track.t_ns, track.sigma) if answers[int(t)].known]
    assert len(known) > 50
    assert all((row == [*sigma.accel, *sigma.gyro]).all() for row, sigma in known)
    assert answers[int(log.t_ns[-1])].rate_fits


def test_a_stream_at_another_rate_says_what_the_track_says():
    log = dpn.read(EXCERPT)
    # Twice the rate: each sample twice, half a step apart.
    t = np.sort(np.concatenate([log.t_ns, log.t_ns + 2_500_000]))
    fast = dpn.recording(t, np.repeat(log.gyro, 2, axis=0), np.repeat(log.accel, 2, axis=0))
    for rate, of, model in ((400.0, fast, None), (400.0, fast, "dualpronet"), (200.0, log, "diff2")):
        track, stream, answers = dpn.noise(of, model), dpn.Stream(rate=rate, model=model), {}
        for stamp, gyro, accel in zip(of.t_ns, of.gyro, of.accel):
            stream.feed(stamp, gyro, accel)
            answers[int(stamp)] = stream.sigma()
        known = [(row, answers[int(at)]) for at, row in zip(track.t_ns, track.sigma) if answers[int(at)].known]
        assert len(known) > 50 and all((row == [*sigma.accel, *sigma.gyro]).all() for row, sigma in known)
        assert stream.sigma().rate_fits and not answers[int(of.t_ns[50])].known
        with pytest.raises(dpn.Error, match="after"):
            stream.feed(of.t_ns[0], of.gyro[0], of.accel[0])
    for given in ({"rate": 0}, {"rate": 400, "accel": dpn.Network.default("accel")}, {"model": "x1"}, {"rate": 20, "model": "dualpronet"}):
        with pytest.raises(dpn.Error):
            dpn.Stream(**given)


def test_a_stream_refuses_what_is_no_sample_and_is_as_it_was():
    stream = dpn.Stream()
    stream.feed(1.0, [0, 0, 0], (0, 0, 9.81))
    for words, sample in [
        ("`t_ns` is 1000000000 after 1000000000", (1.0, [0, 0, 0], [0, 0, 9.81])),
        ("t: nan at [0]", (float("nan"), [0, 0, 0], [0, 0, 9.81])),
        ("t: shape", ([1, 2], [0, 0, 0], [0, 0, 9.81])),
        ("gyro: [0, 0]; expected three finite numbers", (2, [0, 0], [0, 0, 9.81])),
        ("accel: ", (2, [0, 0, 0], np.array([0, np.nan, 0]))),
    ]:
        with pytest.raises(dpn.Error) as raised:
            stream.feed(*sample)
        assert words in str(raised.value)
    for i in range(220):
        stream.feed(1.005 + i * 0.01, [0, 0, 0.01 * (i % 2)], [0, 0, 9.81])
    assert stream.sigma().known and not stream.sigma().rate_fits
    gyro = dpn.Network.default("gyro")
    for given in ({"accel": gyro}, {"accel": "sg11-s0"}, {"every": 0}):
        with pytest.raises(dpn.Error):
            dpn.Stream(**given)


def test_a_training_is_the_command_lines_and_its_network_answers(flight, tmp_path):
    log, told = dpn.read(flight[0]), []
    trained = dpn.train(
        {flight[0].name: log}, "accel", tmp_path / "run", config=TINY, progress=lambda *step: told.append(step)
    )
    assert trained.summary["sensor"] == "accel" and trained.network.sensor == "accel"
    assert told[-1][0] == told[-1][1] == trained.summary["updates"] == len(told)
    assert trained.network.predict(np.zeros((1, 200))).shape == (1,)
    dpn.Stream(accel=trained.network)
    text = (tmp_path / "run/config.toml").read_text()
    (tmp_path / "config.toml").write_text(text)
    command("train", "--sensor", "accel", "--data", flight[0], "--config", tmp_path / "config.toml", "--out", tmp_path / "cli")
    of_folder = dpn.train(flight[0], "accel", tmp_path / "same", config=tmp_path / "config.toml")
    ours, theirs = (dpn.Network.load(tmp_path / name / "accel.safetensors") for name in ("run", "cli"))
    windows = log.accel[:200].T.copy()
    assert (ours.predict(windows) == theirs.predict(windows)).all()
    assert (of_folder.network.predict(windows) == theirs.predict(windows)).all()


def test_a_gyroscopes_bias_is_asked_beside_samples(flight, tmp_path):
    folder = flight[0]
    config = f'name = "own"\nsteps = 2\nbatch = 2\nwindow = 512\naverage_s = 1\ntrain = ["{folder.name}"]\n'
    (tmp_path / "own.toml").write_text(config)
    command("train", "--model", "inertial", "--config", tmp_path / "own.toml", "--data", folder.parent, "--out", tmp_path / "own")
    network, log = tmp_path / "own/network.safetensors", dpn.read(folder)
    bias = dpn.GyroBias(network)
    for i in range(600):
        bias.feed(int(log.t_ns[i]), log.gyro[i], log.accel[i])
        found = bias.correction()
        assert found.known == (i >= 510) and found.rate_fits
    assert found.matrix.shape == (3, 3) and found.bias.shape == (3,) and (found.deviation > 0).all() and 0 < np.abs(found.bias).max() < 0.1
    with pytest.raises(dpn.Error, match="stamps must increase"):
        bias.feed(int(log.t_ns[0]), log.gyro[0], log.accel[0])
    for none, words in ((tmp_path / "own.toml", "no whole safetensors file"), (3, "network: int"), (tmp_path / "none", "cannot be read")):
        with pytest.raises(dpn.Error, match=words):
            dpn.GyroBias(none)


def test_a_training_may_be_ended_and_gone_on_with(flight, tmp_path):
    log = dpn.read(flight[0])
    whole = dpn.train(log, "accel", tmp_path / "whole", config=TINY)

    def interrupt(done, total):
        if done > total / 2:
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        dpn.train(log, "accel", tmp_path / "run", config=TINY, progress=interrupt)
    resumed = dpn.train(log, "accel", tmp_path / "run", config=TINY, resume=True)
    assert resumed.summary == whole.summary


def test_a_training_that_cannot_be_is_refused(flight, tmp_path):
    log = dpn.read(flight[0])
    dpn.train(log, "gyro", tmp_path / "done", config=TINY)
    for words, (data, sensor, out), more in [
        ("sensor: \"baro\"; known are accel, gyro", (log, "baro", tmp_path / "a"), {}),
        ("unknown field `epoch`", (log, "accel", tmp_path / "a"), {"config": {"fit": {"epoch": 3}}}),
        ("`fit.epochs` is 0", (log, "accel", tmp_path / "a"), {"config": {"fit.epochs": 0}}),
        ("a run stands there already", (log, "gyro", tmp_path / "done"), {"config": TINY}),
        ("data: int; expected a folder, a dpn.Recording or a dictionary", (3, "accel", tmp_path / "a"), {}),
        ("data['a']: int; expected a dpn.Recording", ({"a": 3}, "accel", tmp_path / "a"), {}),
        ("none", (tmp_path / "none", "accel", tmp_path / "a"), {}),
        ("data: expected a recording or more", ({}, "accel", tmp_path / "a"), {}),
    ]:
        with pytest.raises(dpn.Error) as raised:
            dpn.train(data, sensor, out, **more)
        assert words in str(raised.value)
