"""``dpn.Odometry`` against ``dpn.run``, and with all that must not be fed to it."""

import struct
import threading

import numpy as np
import pytest
from conftest import CAMERA, ROOT, run_command
from test_run import observations

import dpn

MOTION = ROOT / "data/motion/MH_01_easy_start"


def frames(tracks):
    t, ids, px = observations(tracks)
    starts = np.flatnonzero(np.diff(t, prepend=t[0] - 1))
    return list(zip(t[starts], np.split(ids, starts[1:]), np.split(px, starts[1:])))


def fed(odometry, log, seen, feed, until):
    """What comes out where frames come as soon as the samples after them have."""
    updates, before = [], 0
    for frame in seen:
        if frame[0] > until:
            break
        after = np.searchsorted(log.t_ns, frame[0]) + 1
        odometry.feed_imu(log.t_ns[before:after], log.gyro[before:after], log.accel[before:after])
        feed(*frame)
        before = after
        updates += odometry.updates()
    return updates


def held(updates, run):
    """The updates have the run's bits."""
    assert [update.t_ns for update in updates] == list(run.t_ns[: len(updates)]) and len(run.t_ns) - len(updates) < 2
    for name in ("position", "orientation", "velocity", "accel_bias", "gyro_bias", "covariance", "levels"):
        rows = getattr(run, name)
        for k, update in enumerate(updates):
            value = getattr(update, name)
            assert (np.isnan(rows[k]).all() if value is None else np.array_equal(value, rows[k])), (name, k)
    assert sum(update.known for update in updates) > 40


def test_tracks_fed_live_give_the_run(flight):
    folder, tracks = flight
    log, seen = dpn.read(folder), frames(tracks)
    until = seen[0][0] + 30 * 10**9
    config = {"covariance": True, "fed_tracks": "followed"}
    odometry = dpn.Odometry(CAMERA, camera="tracks", config=config)
    assert odometry.waiting == "no IMU sample has come" and odometry.learned is None
    updates = fed(odometry, log, seen, odometry.feed_tracks, until)
    run = dpn.run(folder, tracks=tracks, calibration=CAMERA, config=config, end=30.0)
    held(updates, run)
    noise = odometry.learned
    assert np.allclose(noise.accel, 0.08 * updates[-1].levels[:3]) and abs(noise.rate - 200) < 0.1
    assert np.allclose(noise.accel_density, noise.accel / np.sqrt(noise.rate)) and noise.unsure.shape == (8,)
    assert odometry.waiting is None and updates[0].waits_for and updates[0].phase == "initialising"


@pytest.mark.skipif(not MOTION.exists(), reason="the pack of images is not unpacked")
def test_images_fed_live_give_the_run():
    image = pytest.importorskip("matplotlib.image")
    folder = MOTION / "mav0/cam0"
    seen = [line.split(",") for line in (folder / "data.csv").read_text().splitlines() if line[0] != "#"]
    odometry = dpn.Odometry(folder / "sensor.yaml", "x1")
    feed = lambda t, name: odometry.feed_image(t, np.round(255 * image.imread(folder / "data" / name.strip())).astype(np.uint8))
    seen = [(int(t), name) for t, name in seen]
    updates = fed(odometry, dpn.read(MOTION), seen, feed, seen[0][0] + 10 * 10**9)
    held_to = dpn.run(MOTION, "x1", end=10)
    assert held_to.covariance is None and held_to.levels is None
    positions = np.array([update.position for update in updates if update.known])
    assert np.array_equal(positions, held_to.position[held_to.known][: len(positions)]) and len(positions) > 50


def wrong():
    image, t = np.zeros((480, 752), np.uint8), 10**9
    yield "image: dtype float64, shape (480, 752); expected uint8", lambda o: o.feed_image(t, image * 1.0)
    yield "image: dtype uint8, shape (480, 752, 3); expected uint8 (height, width)", lambda o: o.feed_image(t, np.zeros((480, 752, 3), np.uint8))
    yield "480 x 752", lambda o: o.feed_image(t, image.T)
    yield "t: nan", lambda o: o.feed_image(float("nan"), image)
    yield "made for images", lambda o: o.feed_tracks(t, [1], [[1.0, 2.0]])
    yield "gyro: shape (2, 3); expected (1, 3)", lambda o: o.feed_imu([t], np.zeros((2, 3)), np.zeros((1, 3)))
    yield "accel: nan at [0, 1]", lambda o: o.feed_imu(t, [0, 0, 0], [0, np.nan, 0])
    yield "t: 2 to 1 ns", lambda o: o.feed_imu([2, 1], np.zeros((2, 3)), np.zeros((2, 3)))
    yield "increasing time", lambda o: (o.feed_imu(t, [0, 0, 0], [0, 0, 9.81]), o.feed_imu(t, [0, 0, 0], [0, 0, 9.81]))
    yield "take the updates between images", lambda o: (
        # Six values that do not even flicker would be no sensor's.
        o.feed_imu(np.arange(1, 1000) * 5_000_000, 1e-6 * np.arange(2997).reshape(999, 3), np.ones((999, 3))), [o.feed_image(t + k, image) for k in range(60)]
    )


@pytest.mark.parametrize("words, call", list(wrong()), ids=lambda v: v if isinstance(v, str) else "")
def test_what_cannot_be_taken_is_named(words, call):
    odometry = dpn.Odometry(CAMERA, "x1")
    with pytest.raises(dpn.Error) as raised:
        call(odometry)
    assert words in str(raised.value)
    # Another order or a part of a larger array is taken by copy.
    odometry = dpn.Odometry(CAMERA, "x1")
    odometry.feed_image(1, np.zeros((480, 800), np.uint8)[:, :752])
    odometry.feed_image(2, np.zeros((752, 480), np.uint8).T)


def test_settings_that_are_none_are_named():
    for words, given in [
        ("calibration: None", {"calibration": None}), ("none.yaml", {"calibration": "none.yaml"}), ("noise: ", {"noise": "x"}),
        ("camera: 'film'", {"camera": "film"}), ("unknown field", {"config": {"window": {"key_frame": 3}}}), ("seed: -1", {"seed": -1}),
    ]:
        with pytest.raises(dpn.Error, match=words):
            dpn.Odometry(**{"calibration": CAMERA, **given})
    tracks = dpn.Odometry(CAMERA, camera="tracks")
    with pytest.raises(dpn.Error, match="id 7 twice"):
        tracks.feed_tracks(1, [7, 7], [[1.0, 2.0], [3.0, 4.0]])
    with pytest.raises(dpn.Error, match="that the lens can show"):
        tracks.feed_tracks(1, [7], [[1e300, 0.0]], normalised=True)
    tracks.feed_tracks(1, [], np.empty((0, 2)))


def test_four_threads_take_turns():
    odometry, faults = dpn.Odometry(CAMERA, "x1"), []
    image = np.random.default_rng(0).integers(0, 255, (480, 752), dtype=np.uint8)

    def work(k):
        for i in range(100):
            try:
                t = 5_000_000 * (4 * i + k + 1)
                odometry.feed_imu(t, np.zeros(3), [0, 0, 9.81])
                if i % 10 == 0:
                    odometry.feed_image(t, image)
                list(odometry.updates())
            except dpn.Error as error:
                if "increasing time" not in str(error):
                    faults.append(error)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert not faults and odometry.waiting is not None
    # An exception in whoever takes the updates leaves it as it was.
    with pytest.raises(ZeroDivisionError):
        odometry.feed_imu(10**10, np.zeros(3), [0, 0, 9.81])
        for _ in [*odometry.updates(), None]:
            1 / 0
    odometry.end()
    assert isinstance(odometry.warnings(), list)


def test_five_pictures(flight, tmp_path):
    pytest.importorskip("matplotlib")
    folder, tracks = flight
    run = dpn.run(folder, "self", tracks=tracks, calibration=CAMERA, start=50.0, end=60.0)
    flown = dpn.simulate("room-medium", seed=1)
    log = dpn.read(folder)
    truth = (flown.recording.t_ns, flown.position, flown.orientation)
    pictures = {
        "trajectory": dpn.plot.trajectory(run), "truth": dpn.plot.trajectory(run, truth), "noise": dpn.plot.noise(dpn.noise(log)),
        "spectrum": dpn.plot.spectrum(log), "allan": dpn.plot.allan(dpn.allan(log, all=True)), "states": dpn.plot.states(run),
    }
    for name, figure in pictures.items():
        figure.savefig(tmp_path / f"{name}.svg")
        drawn = [line for axis in figure.axes for line in axis.get_lines()]
        assert all(np.isfinite(line.get_ydata()).any() for line in drawn) and len(drawn) > 1, name
    # Laid on its truth the path is the truth's within decimetres.
    true, estimate = (line.get_xydata() for line in pictures["truth"].axes[0].get_lines()[:2])
    apart = np.linalg.norm(true[:, None, :] - estimate[None, ::10, :], axis=2).min(axis=0)
    assert apart.max() < 0.5
    for call, words in [
        (lambda: dpn.plot.trajectory(3), "run: int; expected a dpn.Run"), (lambda: dpn.plot.allan({}), "found: dict; expected a dpn.Allan"),
        (lambda: dpn.plot.noise(run), "as dpn.noise gives it"), (lambda: dpn.plot.spectrum(None), "a dpn.Recording or a path"),
    ]:
        with pytest.raises(dpn.Error, match=words):
            call()


def test_frames_of_pandas(flight):
    pandas = pytest.importorskip("pandas")
    log = dpn.read(flight[0])
    frame, noise = dpn.frame(log), dpn.frame(dpn.noise(log))
    assert isinstance(frame, pandas.DataFrame) and list(frame) == [f"{s}_{k}" for s in ("accel", "gyro") for k in "xyz"]
    assert (frame["gyro_z"].to_numpy() == log.gyro[:, 2]).all() and (frame.index.astype("int64") == log.t_ns).all()
    assert "in_range" in noise and len(dpn.frame(dpn.run(flight[0], "x4", tracks=flight[1], calibration=CAMERA, end=5.0))) > 20
    with pytest.raises(dpn.Error, match="of: int"):
        dpn.frame(3)


def test_a_bag_one_by_one_gives_the_poses_of_its_folder(tmp_path):
    """An MCAP file without chunks of a rendered flight: samples in order, images whose pixels are the files'."""
    plt = pytest.importorskip("matplotlib.image")
    camera = tmp_path / "camera.toml"
    camera.write_text("[camera]\nresolution = [188, 120]\nintrinsics = [114.6, 114.3, 91.7, 61.9]\n")
    run_command("simulate", "images", "room-medium", "--from", 12, "--to", 13, "--config", camera, "--out", tmp_path / "flight")
    folder = tmp_path / "flight"
    log, calibration = dpn.read(folder), folder / "mav0/cam0/sensor.yaml"
    rows = [row.split(",") for row in (folder / "mav0/cam0/data.csv").read_text().splitlines()[1:]]
    files = [(int(t), folder / "mav0/cam0/data" / name.strip()) for t, name in rows]
    bag = tmp_path / "flight.mcap"
    bag.write_bytes(mcap(log, files))
    said = list(dpn.sensors(bag, calibration))
    samples = [one for one in said if isinstance(one, dpn.Sample)]
    images = [one for one in said if isinstance(one, dpn.Image)]
    assert [one.t_ns for one in samples] == list(log.t_ns) and (samples[7].accel == log.accel[7]).all()
    assert [one.t_ns for one in images] == [t for t, _ in files]
    assert (images[3].pixels == np.round(255 * plt.imread(files[3][1])).astype(np.uint8)).all()
    assert len(list(dpn.sensors(bag, size=(188, 120)))) == len(said)
    # Whoever stops early leaves nobody waiting.
    assert next(dpn.sensors(bag, calibration)) is not None
    with pytest.warns(UserWarning, match="1 x 1"):
        assert not any(isinstance(one, dpn.Image) for one in dpn.sensors(bag, size=(1, 1)))
    for words, call in [
        ("size: expected", lambda: dpn.sensors(bag)), ("bag: int", lambda: dpn.sensors(3, size=(1, 1))), ("none.bag", lambda: list(dpn.sensors(tmp_path / "none.bag", size=(1, 1)))),
        ("size", lambda: dpn.sensors(bag, calibration, size=(1, 1))), ("none.yaml", lambda: dpn.sensors(bag, tmp_path / "none.yaml")),
    ]:
        with pytest.raises(dpn.Error, match=words):
            call()


def mcap(log, files):
    """A recording and PNG files as a recorder writes them, in ROS 2's words."""
    text = lambda words: struct.pack("<I", len(words)) + words.encode()
    record = lambda kind, body: struct.pack("<BQ", kind, len(body)) + body
    of_cdr = lambda words: struct.pack("<I", len(words) + 1) + words.encode() + b"\0"
    header = lambda t: b"\0\1\0\0" + struct.pack("<II", t // 10**9, t % 10**9) + of_cdr("imu")
    whole = b"\x89MCAP0\r\n" + record(1, text("ros2") + text("a test"))
    for number, kind in ((1, "Imu"), (2, "CompressedImage")):
        number = struct.pack("<H", number)
        whole += record(3, number + text(f"sensor_msgs/msg/{kind}") + text("ros2msg") + text(""))
        whole += record(4, number + number + text("/" + kind.lower()) + text("cdr") + struct.pack("<I", 0))
    messages = []
    for t, gyro, accel in zip(log.t_ns.tolist(), log.gyro, log.accel):
        # Orientation, its covariance, rate, its, force, its; `imu` and its zero end where doubles may begin.
        values = [0.0, 0.0, 0.0, 1.0] + [0.0] * 9 + [*gyro] + [0.0] * 9 + [*accel] + [0.0] * 9
        messages.append((t, 1, header(t) + struct.pack("<37d", *values)))
    for t, file in files:
        data = file.read_bytes()
        messages.append((t, 2, header(t) + of_cdr("png") + struct.pack("<I", len(data)) + data))
    for t, channel, data in sorted(messages, key=lambda message: message[:2]):
        whole += record(5, struct.pack("<HIQQ", channel, 0, t, t) + data)
    return whole + record(15, struct.pack("<I", 0)) + b"\x89MCAP0\r\n"


def test_without_matplotlib_it_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "matplotlib.figure", None)
    with pytest.raises(dpn.Error, match="pip install matplotlib"):
        dpn.plot.spectrum(dpn.simulate("hover").recording)
