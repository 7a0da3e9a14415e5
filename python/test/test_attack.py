"""What nobody should hand over, by chance, to every function that takes numbers: an exception that says what was expected, or an answer of numbers."""

import threading

import numpy as np
import pytest
from conftest import CAMERA

import dpn

DTYPES = ["f2", "f4", "f8", ">f8", "g", "i1", "i8", ">i4", "u1", "u8", "?", "c16", "O", "U5", "M8[ns]", "m8[ns]"]
VALUES = [0.0, 1.0, -1.0, np.nan, np.inf, -np.inf, 1e308, -1e308, 1e39, 1e-320, 9.81, 1.4e9]


def strides(draw, found):
    """The same numbers as memory may hold them."""
    kind = draw.integers(7)
    if kind == 1 and found.ndim == 2:
        return np.asfortranarray(found)
    if kind == 2 and found.ndim:
        return found[::-1]
    if kind == 3 and found.ndim:
        return np.repeat(found, 2, axis=0)[::2]
    if kind == 4 and found.ndim == 2:
        return found.T
    if kind == 5 and found.ndim:
        return np.broadcast_to(found[:1], found.shape)
    if kind == 6:
        found.flags.writeable = False
    return found


def nasty(draw, shape):
    """An argument of about this shape."""
    if draw.random() < 0.1:
        return [None, "x", b"x", object(), [], [[]], {}, 3, 1e308, float("nan"), [1, [2]], np.ma.masked_array([1.0], [True]), 2**70][draw.integers(13)]
    if draw.random() < 0.3:
        shape = [(), (0,), (1,), (3,), (0, 3), (3, 0), (2, 3), (3, 2), (2, 3, 4), (1, 1)][draw.integers(10)]
    found = draw.normal(size=shape)
    if draw.random() < 0.5 and found.size:
        found.flat[draw.integers(found.size)] = VALUES[draw.integers(len(VALUES))]
    if draw.random() < 0.5:
        with np.errstate(all="ignore"):
            try:
                found = found.astype(DTYPES[draw.integers(len(DTYPES))])
            except (TypeError, ValueError, OverflowError):
                pass
    return strides(draw, np.array(found))


def finite(value):
    """Whether all numbers of an answer are numbers; NaN is how what is not known is told."""
    return not np.isinf(np.asarray(value, dtype=np.float64)).any()


def attacks():
    odometries = {
        camera: dpn.Odometry(CAMERA, noise, camera=camera) for camera, noise in [("images", "self"), ("tracks", "x1")]
    }
    stream = dpn.Stream(every=1)
    network = dpn.Network.default("accel")

    def fed(draw):
        odometry = odometries[["images", "tracks"][draw.integers(2)]]
        n = draw.integers(4)
        [
            lambda: odometry.feed_imu(nasty(draw, (n,)), nasty(draw, (n, 3)), nasty(draw, (n, 3))),
            lambda: odometry.feed_image(nasty(draw, ()), nasty(draw, (480, 752))),
            lambda: odometry.feed_tracks(nasty(draw, ()), nasty(draw, (n,)), nasty(draw, (n, 2)), normalised=bool(draw.integers(2))),
        ][draw.integers(3)]()
        for update in odometry.updates():
            assert update.position is None or finite(update.position)

    def read(draw):
        n = [3, 400][draw.integers(2)]
        t = 5_000_000 * np.arange(n) if draw.random() < 0.7 else nasty(draw, (n,))
        log = dpn.recording(t, nasty(draw, (n, 3)), nasty(draw, (n, 3)))
        found = dpn.noise(log, ["diff2", "dualpronet"][draw.integers(2)])
        assert finite(found.accel) and finite(found.gyro)

    def streamed(draw):
        stream.feed(nasty(draw, ()), nasty(draw, (3,)), nasty(draw, (3,)))
        assert finite(stream.sigma().accel)

    def predicted(draw):
        network.predict(nasty(draw, (2, 200)))

    def judged(draw):
        n = draw.integers(5)
        pose = lambda: (nasty(draw, (n,)), nasty(draw, (n, 3)), nasty(draw, (n, 4)))
        dpn.metrics.ate(pose(), pose())

    return [fed, read, streamed, predicted, judged]


# Whoever asks for other types than text and numbers has TypeError, as everywhere in Python.
REFUSED = (dpn.Error, TypeError)


def attack(seed, calls, times):
    draw, refused = np.random.default_rng(seed), 0
    for k in range(times):
        try:
            calls[k % len(calls)](draw)
        except REFUSED as error:
            assert str(error), "an exception without a word"
            refused += 1
    return refused


def test_random_arguments_are_refused_or_answered():
    assert attack(1, attacks(), 1500) > 500


def test_four_threads_attack_the_same_objects():
    calls, faults = attacks(), []

    def work(seed):
        try:
            attack(seed, calls, 300)
        except BaseException as error:  # a panic is no Exception
            faults.append(error)

    threads = [threading.Thread(target=work, args=(seed,)) for seed in range(4)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert not faults, faults


@pytest.mark.parametrize("value", [1e308, -1e308, 1e39])
def test_samples_that_no_sensor_gives_leave_poses_of_numbers(value):
    odometry = dpn.Odometry(CAMERA, "x1", camera="tracks")
    ids, points = np.arange(40), np.random.default_rng(0).uniform(50, 400, (40, 2))
    for k in range(2000):
        odometry.feed_imu(5_000_000 * (k + 1), [0, 0, 1e-6 * (k % 7)], [0, 0, value if k % 400 == 399 else 9.81])
        if k % 20 == 10:
            odometry.feed_tracks(5_000_000 * k, ids, points + 0.05 * k)
        for update in odometry.updates():
            for found in (update.position, update.orientation, update.velocity):
                assert found is None or np.isfinite(found).all()
    log = dpn.recording(5_000_000 * np.arange(2000), np.zeros((2000, 3)), np.full((2000, 3), value))
    try:
        found = dpn.noise(log)
    except dpn.Error as error:
        assert str(error)
    else:
        assert finite(found.accel)
