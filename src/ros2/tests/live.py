"""`dpn ros2` against independent DDS (Cyclone, Fast DDS) over loopback: live.py DPN FOLDER [CASE...]; FOLDER/fastdds is fastdds.cpp. The pack `motion` is looked for in $DPN_DATA, then in data/."""

import json
import os
import random
import subprocess
import sys
import threading
import time
import traceback
from functools import partial
from pathlib import Path

from messages import *
from peer import *

DPN = str(Path(sys.argv[1]).resolve())
WORK = Path(sys.argv[2])
NOISE = ["--noise", "sg(11,2)", "--seed", "3"]


def flown(resolution=[376, 240], intrinsics=[229.3, 228.6, 183.4, 123.9], seconds=6):
    """Seconds of a flight's images, made once."""
    folder = WORK / f"live-{resolution[0]}"
    if not folder.exists():
        camera = WORK / "camera.toml"
        camera.write_text(f"[camera]\nresolution = {resolution}\nintrinsics = {intrinsics}\n")
        line = [DPN, "simulate", "images", "room-medium", "--from", "12", "--to", str(12 + seconds), "--config", camera, "--out", folder]
        subprocess.run(line, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return folder


def expected(folder, *args):
    """Stamp [ns] to the seven numbers of the trajectory that `dpn run` has of the same folder, run once."""
    out = WORK / f"run-{folder.name}"
    line = [DPN, "run", folder, "--camera", "images", "--out", out, *args]
    if not out.exists():
        subprocess.run(line, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    poses = {}
    for line in (out / "trajectory.tum").read_text().splitlines()[1:]:
        t, *numbers = line.split(" ")
        seconds, nanos = t.split(".")
        poses[int(seconds) * 1_000_000_000 + int(nanos.ljust(9, "0"))] = [float(v) for v in numbers]
    return poses


def pose_of(message):
    p, q = message.pose.pose.position, message.pose.pose.orientation
    return [p.x, p.y, p.z, q.x, q.y, q.z, q.w]


def poses_of(came):
    return {message.header.stamp.ns(): pose_of(message) for _, message in came}


def wait(condition, seconds, words):
    until = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < until, words()
        time.sleep(0.05)


def wait_for_poses(came, count, node):
    wait(lambda: len(came) >= count, 30, lambda: f"{len(came)} poses of {count}:\n{node.said()}")


def held_to(came, poses, most_missing):
    """Bit by bit, but for the last ones, whose samples had not come."""
    found = poses_of(came)
    wrong = [t for t in found if found[t] != poses.get(t)]
    assert not wrong, f"{len(wrong)} of {len(found)} poses are others: {found[wrong[0]]}, not {poses.get(wrong[0])}"
    missing = sorted(set(poses) - set(found))
    assert len(missing) <= most_missing and all(t > max(found) for t in missing), f"missing: {missing} of {len(poses)}, the first at {min(poses)}"


def events_of(recording, imu, image):
    return [(t, imu, m) for t, m in recording.samples] + [(t, image, m) for t, m in recording.images]


def camera_info(recording):
    width, height = (int(v) for v in recording.numbers("resolution"))
    fu, fv, cu, cv = recording.numbers("intrinsics")
    d = recording.numbers("distortion_coefficients")
    k = [fu, 0.0, cu, 0.0, fv, cv, 0.0, 0.0, 1.0]
    roi = RegionOfInterest(0, 0, 0, 0, False)
    return CameraInfo(Header(Time.at(1), "cam"), height, width, "plumb_bob" if d else "", d, k, [0.0] * 9, [0.0] * 12, 0, 0, roi)


def transform_of(recording):
    """Where the camera stands, by way of a frame between the two."""
    m = recording.numbers("data")
    r = [m[0:3], m[4:7], m[8:11]]
    w = (1 + r[0][0] + r[1][1] + r[2][2]) ** 0.5 / 2
    q = Quaternion((r[2][1] - r[1][2]) / (4 * w), (r[0][2] - r[2][0]) / (4 * w), (r[1][0] - r[0][1]) / (4 * w), w)
    at = lambda parent, child, v, q: TransformStamped(Header(Time.at(1), parent), child, Transform(Vector3(*v), q))
    unit = Quaternion(0.0, 0.0, 0.0, 1.0)
    return TFMessage([at("imu", "mount", [m[3], m[7], 0.0], unit), at("mount", "cam", [0.0, 0.0, m[11]], q)])


def quantile(values, share):
    return sorted(values)[min(len(values) - 1, int(share * len(values)))]


def motion(kind_of_peer=Peer, seconds=60):
    """The pack played at its own speed: the bits of `dpn run`, covariances, transforms, the IMU again, latency."""
    data = Path(os.environ.get("DPN_DATA", "data")) / "motion" / "MH_01_easy_start"
    if not data.exists():
        assert "DPN_DATA" not in os.environ, f"there is no {data}"
        print("   skipped: no data (motion)")
        return
    # The node always says covariances, whose linear system changes the last digits of `self`.
    poses = expected(data, "--set", "covariance=true")
    recording = Recording(data, compressed=False)
    end = recording.samples[0][0] + round(seconds * 1e9)
    poses = {t: pose for t, pose in poses.items() if t < end}
    recording.samples, recording.images = ([(t, m) for t, m in part if t < end] for part in (recording.samples, recording.images))
    peer = kind_of_peer()
    odometry, tf = peer.reader("/odometry", Odometry), peer.reader("/tf", TFMessage)
    imu, told = peer.reader("/imu/with_covariance", Imu), peer.reader("/diagnostics", DiagnosticArray)
    peer.writer("/imu", Imu)
    peer.writer("/image_raw", Image)
    node = Node(DPN, "--calib", recording.calibration, "--reliable")
    peer.matched("/imu", "/image_raw")
    sent = play(peer, events_of(recording, "/imu", "/image_raw"))
    wait_for_poses(odometry, len(poses) - 2, node)
    held_to(odometry, poses, 2)
    message = odometry[-1][1]
    assert (message.header.frame_id, message.child_frame_id) == ("odom", "imu")
    covariance = message.pose.covariance
    assert all(0 < covariance[7 * k] < 1 for k in range(6)), covariance
    assert all(abs(covariance[6 * r + c] - covariance[6 * c + r]) < 1e-12 for r in range(6) for c in range(6))
    moved = [message.twist.twist.linear.x, message.twist.twist.linear.y, message.twist.twist.linear.z]
    assert 0.001 < sum(v * v for v in moved) ** 0.5 < 5, moved
    assert len(tf) >= len(odometry) - 1 and tf[-1][1].transforms[0].header.frame_id == "odom"
    # Handed on at once, with the noise in force: none before the rate is known.
    assert len(imu) >= len(recording.samples) - 150, len(imu)
    last = imu[-1][1]
    gyro, accel = last.angular_velocity_covariance, last.linear_acceleration_covariance
    assert all(1e-10 < gyro[4 * k] < 1e-2 and 1e-6 < accel[4 * k] < 1 for k in range(3)), (gyro, accel)
    samples = dict(recording.samples)
    assert last.linear_acceleration == samples[last.header.stamp.ns()].linear_acceleration
    keys = lambda: {value.key: value.value for value in told[-1][1].status[0].values}
    wait(lambda: int(keys()["poses"]) >= len(poses) - 2, 5, lambda: str(keys()))
    values = keys()
    assert told[-1][1].status[0].name == "dpn: odometry", told[-1]
    assert values["/imu: lost"] == values["/image_raw: lost"] == "0" and {"level gyro x", "messages that could not be sent"} <= set(values), values
    assert node.end() == 0
    peer.close()

    # A sample of the image's own instant is sent right behind it.
    took = [1e3 * (came - sent[("/image_raw", message.header.stamp.ns())]) for came, message in odometry]
    print("  ", json.dumps({"image_to_pose_ms": {"median": quantile(took, 0.5), "99 %": quantile(took, 0.99)}, "poses": len(took)}))


def two_namespaces():
    """Two nodes: one with a file for its camera, one that takes it from ROS; one kind of images each."""
    folder = flown()
    poses = expected(folder, *NOISE)
    raw, compressed = Recording(folder, compressed=False), Recording(folder, compressed=True)
    peer = Peer()
    first, second = peer.reader("/a/odometry", Odometry), peer.reader("/b/odometry", Odometry)
    peer.writer("/imu0", Imu)
    peer.writer("/a/image_raw", Image)
    peer.writer("/b/cam/compressed", CompressedImage)
    peer.writer("/b/camera_info", CameraInfo)
    latched = (RELIABLE, Policy.History.KeepAll, Policy.Durability.TransientLocal)
    peer.writer("/tf_static", TFMessage, *latched).write(transform_of(raw))
    a = Node(DPN, "--calib", raw.calibration, "--imu", "/imu0", "--reliable", *NOISE, "--ros-args", "-r", "__ns:=/a")
    params = ["-p", "image_transport:=compressed", "-p", "noise:=sg(11,2)", "-p", "seed:=3", "-p", "odom_frame:=map", "-p", "publish_tf:=false"]
    b = Node(DPN, "--reliable", "--ros-args", "-r", "__ns:=/b", "-r", "imu:=/imu0", "-r", "image_raw/compressed:=cam/compressed", *params)
    peer.matched("/imu0", "/a/image_raw", "/b/cam/compressed", "/b/camera_info", "/tf_static")
    # The camera's place needs the IMU's frame: a sample from long before, which is no other's.
    info = camera_info(raw)
    for k in range(3):
        peer.writers["/b/camera_info"].write(info)
        peer.writers["/imu0"].write(imu_message(raw.samples[0][0] - (3 - k) * 5_000_000, [0.0] * 3, [0.0, 0.0, 9.81]))
    b.wait_for("calibration: ROS CameraInfo: 376 x 240 px")
    a.wait_for("calibration: ")
    events = [(t, "/imu0", m) for t, m in raw.samples] + [(t, "/a/image_raw", m) for t, m in raw.images] + [(t, "/b/cam/compressed", m) for t, m in compressed.images]
    play(peer, events)
    for node, came in ((a, first), (b, second)):
        wait_for_poses(came, len(poses) - 3, node)
    # Three samples before the first make another rate's first hundred; the odometry begins with the first image all the same.
    for came, most in ((first, 0.02), (second, 0.05)):
        found = poses_of(came)
        apart = max(abs(x - y) for t in found if t in poses for x, y in zip(found[t][:3], poses[t][:3]))
        assert apart < most, f"{apart} m"
    assert second[-1][1].header.frame_id == "map" and first[-1][1].header.frame_id == "odom"
    assert a.end() == 0 and b.end() == 0
    peer.close()


def on_the_flight(*more):
    """The small flight, the poses expected of it, a peer that plays it compressed, and a node that waits for it."""
    folder = flown()
    poses = expected(folder, *NOISE)
    recording = Recording(folder, compressed=True)
    peer = Peer()
    odometry = peer.reader("/odometry", Odometry)
    peer.writer("/imu", Imu)
    peer.writer("/image_raw/compressed", CompressedImage)
    node = Node(DPN, "--calib", recording.calibration, "--reliable", "--compressed", *more, *NOISE)
    return poses, recording, peer, odometry, node


def bits():
    """A small flight, samples late and images early: the bits of `dpn run`."""
    poses, recording, peer, odometry, node = on_the_flight()
    peer.matched("/imu", "/image_raw/compressed")
    late = [(t + 30_000_000, "/imu", m) for t, m in recording.samples]
    play(peer, late + [(t, "/image_raw/compressed", m) for t, m in recording.images])
    wait_for_poses(odometry, len(poses) - 2, node)
    held_to(odometry, poses, 2)
    assert node.end() == 0
    peer.close()


def faults():
    """Messages lost, twice, late, out of order; silence; a node that is killed and begun again."""
    poses = len(expected(flown(), *NOISE))
    recording = Recording(flown(), compressed=True)
    chance = random.Random(1)
    events, image = [], "/image_raw/compressed"
    for t, topic, message in events_of(recording, "/imu", image):
        late = 12_000_000 if chance.random() < 0.01 else 0
        if chance.random() < 0.01:
            continue
        events.append((t + late, topic, message))
        if chance.random() < 0.01:
            events.append((t + 1_000_000, topic, message))
    peer = Peer()
    odometry, told = peer.reader("/odometry", Odometry), peer.reader("/diagnostics", DiagnosticArray)
    peer.writer("/imu", Imu)
    peer.writer(image, CompressedImage)
    arguments = ["--calib", recording.calibration, "--reliable", "--compressed", *NOISE]
    node = Node(DPN, *arguments)
    peer.matched("/imu", image)
    play(peer, events)
    wait(lambda: len(odometry) > 0.8 * poses, 20, lambda: f"{len(odometry)} poses\n{node.said()}")
    assert "restarts" not in node.said() and "initialising again" not in node.said(), node.said()
    # Nothing comes: both are named, with how long.
    node.wait_for("waits for IMU on /imu (sensor_msgs/msg/Imu), whose publisher is silent, for ", 8)
    assert f"images on {image} (sensor_msgs/msg/CompressedImage), whose publisher is silent" in node.said(), node.said()
    wait(lambda: told and told[-1][1].status[0].level == 3, 5, lambda: str(told[-1:]))
    assert node.said().count("note: the stamps of /imu are ") == 1 and "behind this machine's clock" in node.said(), node.said()
    lines = [line for line in node.lines if line.startswith("waits for ")]
    assert len(lines) <= 5, lines
    node.kill()
    before = len(odometry)
    node = Node(DPN, *arguments)
    node.wait_for("calibration: ")
    peer.matched("/imu", image)
    hour = 3_600_000_000_000
    # The same flight an hour later.
    play(peer, [(t + hour, topic, moved(message, t + hour)) for t, topic, message in events_of(recording, "/imu", image)])
    wait(lambda: len(odometry) > before + 0.9 * poses, 20, lambda: f"{len(odometry) - before} poses\n{node.said()}")
    assert node.end() == 0, node.said()
    peer.close()


def unfit():
    """Nobody sends, somebody sends what does not fit, parameters that are none."""
    recording = Recording(flown(), compressed=True)
    peer = Peer()
    node = Node(DPN, "--calib", recording.calibration, "--reliable")
    node.wait_for("waits for IMU on /imu (sensor_msgs/msg/Imu), which nobody sends, for ", 8)
    peer.writer("/imu", Imu, BEST_EFFORT, Policy.History.KeepLast(10), Policy.Durability.Volatile)
    peer.writer("/image_raw", CompressedImage)
    node.wait_for("warning: a publisher of /imu does not fit: it is best effort, and reliable is asked for", 10)
    node.wait_for("warning: a publisher of /image_raw sends sensor_msgs/msg/CompressedImage, not sensor_msgs/msg/Image", 10)
    assert node.end() == 3 and "no image had samples on both sides of it" in node.said(), node.said()
    # Without a file, and without a place for the camera.
    node = Node(DPN, "--image", "/cam/image_raw")
    node.wait_for("camera's calibration on /camera_info (sensor_msgs/msg/CameraInfo), which nobody sends, for ", 8)
    assert "camera's place on /tf_static" in node.said(), node.said()
    info = peer.writer("/camera_info", CameraInfo)
    peer.writer("/tf_static", TFMessage, RELIABLE, Policy.History.KeepAll, Policy.Durability.TransientLocal)
    peer.matched("/camera_info")
    node.wait_for("waits for IMU on /imu", 8)
    for k in range(20):
        info.write(camera_info(recording))
        peer.writers["/imu"].write(imu_message(10**9 + k * 5_000_000, [0.0] * 3, [0.0, 0.0, 9.81]))
        time.sleep(0.1)
    node.wait_for("no transforms on /tf_static lead from the camera's frame `cam` to the IMU's `imu`; --calib names a file", 8)
    assert node.end() == 0
    peer.close()
    for arguments, words in (
        (["-p", "nonsense:=1"], "there is no parameter `nonsense`"),
        (["-r", "imu"], "`imu` is not NAME:=VALUE"),
        (["-r", "imu:=a b"], "is no name of a topic in ROS"),
        (["-p", "use_sim_time:=maybe"], "`maybe` is neither true nor false"),
    ):
        done = subprocess.run([DPN, "ros2", "--ros-args", *arguments], capture_output=True, text=True, timeout=20)
        assert done.returncode == 2 and words in done.stderr, done


def view():
    """`--view` by another WebSocket: every topic comes; a viewer that takes nothing changes no pose."""
    from websockets.sync.client import connect

    poses, recording, peer, odometry, node = on_the_flight("--view=127.0.0.1:0")
    node.wait_for("view: ws://")
    address = next(line.split()[1].rstrip(",") for line in node.lines if line.startswith("view: "))
    protocol, seen = "foxglove.sdk.v1", {}
    with connect(address, subprotocols=[protocol], max_size=None) as viewer, connect(address, subprotocols=["foxglove.websocket.v1"], close_timeout=1) as deaf:
        assert viewer.subprotocol == protocol and json.loads(viewer.recv(5))["op"] == "serverInfo"
        channels = {c["id"]: c for c in json.loads(viewer.recv(5))["channels"]}
        assert all(json.loads(c["schema"])["type"] == "object" and c["encoding"] == "json" for c in channels.values())
        everything = json.dumps({"op": "subscribe", "subscriptions": [{"id": c + 7, "channelId": c} for c in channels]})
        viewer.send(everything)
        deaf.send(everything)

        def look():
            for message in viewer:
                topic = channels[int.from_bytes(message[1:5], "little") - 7]["topic"]
                seen.setdefault(topic, []).append((int.from_bytes(message[5:13], "little"), json.loads(message[13:])))

        looker = threading.Thread(target=look, daemon=True)
        looker.start()
        peer.matched("/imu", "/image_raw/compressed")
        play(peer, events_of(recording, "/imu", "/image_raw/compressed"))
        wait_for_poses(odometry, len(poses) - 2, node)
        held_to(odometry, poses, 2)
        assert node.end() == 0
        looker.join(5)
    assert set(seen) == {c["topic"] for c in channels.values()}, set(seen)
    # The same poses, and images with their own stamps.
    found = poses_of(odometry)
    shown = {t: [pose["pose"]["position"][axis] for axis in "xyz"] for t, pose in seen["/estimate"]}
    assert len(shown) >= len(found) - 2 and all(at == found[t][:3] for t, at in shown.items() if t in found), len(shown)
    assert {t for t, _ in seen["/camera/image"]} <= {t for t, _ in recording.images}
    assert all(0 < state["latency_ms"] < 5000 for _, state in seen["/state"][-10:])
    peer.close()


def launched():
    """The launch file's command, with stand-ins for ROS's package: its arguments are the node's."""
    from types import ModuleType, SimpleNamespace

    class Said(str):
        pass

    modules = {name: ModuleType(name) for name in ("launch", "launch.actions", "launch.substitutions")}
    modules["launch"].LaunchDescription = list
    modules["launch.actions"].DeclareLaunchArgument = lambda name, default_value, description: (name, default_value)
    modules["launch.actions"].ExecuteProcess = lambda cmd, **how: SimpleNamespace(cmd=cmd)
    modules["launch.substitutions"].LaunchConfiguration = Said
    sys.modules.update(modules)
    scope = {}
    exec((Path(__file__).resolve().parents[3] / "examples/ros2/dpn.launch.py").read_text(), scope)
    *arguments, process = scope["generate_launch_description"]()
    given = {**dict(arguments), "calib": str(Recording(flown(), compressed=True).calibration), "namespace": "/robot", "image_transport": "compressed"}
    word = lambda part: given[part] if isinstance(part, Said) else part
    program, verb, *command = ["".join(map(word, part)) if isinstance(part, list) else word(part) for part in process.cmd]
    assert (program, verb) == ("dpn", "ros2"), process.cmd
    node = Node(DPN, *command)
    node.wait_for("node /robot/dpn in domain ")
    node.wait_for("images: /robot/image_raw/compressed (sensor_msgs/msg/CompressedImage)")
    node.wait_for("calibration: ")
    assert node.end() == 3 and "nan" not in node.said(), node.said()


def noise(seconds=8.0, rate=1000, kind_of_peer=Peer):
    """The noise alone at 1 kHz, on simulated time; memory."""
    chance = random.Random(2)
    step = 1_000_000_000 // rate
    peer = kind_of_peer()
    imu, told = peer.reader("/imu/with_covariance", Imu), peer.reader("/diagnostics", DiagnosticArray)
    writer = peer.writer("/imu", Imu, BEST_EFFORT, Policy.History.KeepLast(100), Policy.Durability.Volatile)
    clock = peer.writer("/clock", Clock, BEST_EFFORT, Policy.History.KeepLast(10), Policy.Durability.Volatile)
    node = Node(DPN, "noise", "--ros-args", "-p", "use_sim_time:=true")
    peer.matched("/imu", "/clock")
    messages = []
    for k in range(1000):
        gyro, accel = [chance.gauss(0, 0.01) for _ in range(3)], [chance.gauss(0, 0.1) for _ in range(2)]
        messages.append(imu_message(0, gyro, [*accel, 9.81 + chance.gauss(0, 0.1)]))
    begin, k, memory, kept = time.monotonic(), 0, [], 0
    while k < seconds * rate:
        due = begin + k / rate
        ahead = due - time.monotonic()
        if ahead > 0:
            time.sleep(ahead)
        t = 5_000_000_000 + k * step
        writer.write(moved(messages[k % 1000], t))
        if k % 100 == 0:
            clock.write(Clock(Time.at(t)))
        k += 1
        if k % (10 * rate) == 0:
            memory.append(node.memory_mb())
            kept += len(imu) - 1
            del imu[:-1]
    time.sleep(1.5)
    last = imu[-1][1]
    gyro, accel = last.angular_velocity_covariance, last.linear_acceleration_covariance
    for found, sigma in ((gyro, 0.01), (accel, 0.1)):
        assert all(0.5 < found[4 * i] ** 0.5 / sigma < 2 for i in range(3)), (found, sigma)
    assert kept + len(imu) > 0.9 * (k - 200), (kept, len(imu), k)
    array = told[-1][1]
    assert abs(array.header.stamp.ns() - t) < 3_000_000_000, array.header
    assert array.status[0].name == "dpn: noise" and array.status[0].message == "noise is told", array.status[0]
    assert node.end() == 0, node.said()
    peer.close()
    if memory:
        print("  ", json.dumps({"rate_hz": rate, "seconds": seconds, "memory_mb": memory}))


def soak(seconds):
    """The odometry for minutes: the same flight again and again, 1 kHz samples and 20 Hz images, 1 % lost, 1 % late, 1 % twice; memory, restarts."""
    recording = Recording(flown(), compressed=True)
    chance = random.Random(3)
    peer = Peer()
    odometry = peer.reader("/odometry", Odometry)
    peer.writer("/imu", Imu)
    image = "/image_raw/compressed"
    peer.writer(image, CompressedImage)
    node = Node(DPN, "--calib", recording.calibration, "--reliable", "--compressed", *NOISE)
    peer.matched("/imu", image)
    # Each sample five times, a millisecond apart.
    samples = [(t + k * 1_000_000, "/imu", m) for t, m in recording.samples for k in range(5)]
    flight = samples + [(t, image, m) for t, m in recording.images]
    length = samples[-1][0] - samples[0][0] + 1_000_000
    poses, memory, behind = 0, [], 0.0
    begun = time.monotonic()
    for turn in range(int(seconds * 1e9 / length)):
        events = []
        for t, topic, message in flight:
            t += turn * length
            if chance.random() < 0.01:
                continue
            again = moved(message, t)
            late = 12_000_000 if chance.random() < 0.01 else 0
            events += [(t + late, topic, again)] * (2 if chance.random() < 0.01 else 1)
        play(peer, events, begun + turn * length * 1e-9)
        behind = max(behind, time.monotonic() - begun - (turn + 1) * length * 1e-9)
        poses += len(odometry)
        odometry.clear()
        memory.append(round(node.memory_mb(), 1))
    assert node.end() == 0, node.said()
    said = node.lines[-3:]
    print("  ", json.dumps({"seconds": seconds, "poses": poses, "memory_mb": memory[:: max(1, len(memory) // 12)], "behind_s": round(behind, 2), "end": said}))
    # From a fifth of the time on.
    settled = memory[len(memory) // 5 :]
    assert max(settled) < 1.1 * settled[0], memory
    peer.close()


def fastdds():
    """Fast DDS in place of Cyclone: some of the pack from one that has shared memory too; best effort; large images from one that comes after the node."""
    program = WORK / "fastdds"
    if not program.exists():
        print("   skipped: no Fast DDS (libfastrtps-dev)")
        return
    motion(partial(FastPeer, program, "shm"), 8)
    noise(2.5, 500, partial(FastPeer, program, "udp"))
    folder = flown([1280, 720], [780.0, 780.0, 639.5, 359.5], 2)
    poses = expected(folder, *NOISE)
    recording = Recording(folder, compressed=False)
    node = Node(DPN, "--calib", recording.calibration, "--reliable", *NOISE)
    node.wait_for("waits for IMU on /imu (sensor_msgs/msg/Imu), which nobody sends")
    peer = FastPeer(program, "udp")
    odometry = peer.reader("/odometry", Odometry)
    peer.writer("/imu", Imu)
    peer.writer("/image_raw", Image)
    peer.matched("/imu", "/image_raw")
    play(peer, events_of(recording, "/imu", "/image_raw"))
    wait_for_poses(odometry, len(poses) - 2, node)
    held_to(odometry, poses, 2)
    assert node.end() == 0
    peer.close()


CASES = [bits, view, launched, unfit, faults, two_namespaces, noise, motion, fastdds]

if __name__ == "__main__":
    WORK.mkdir(parents=True, exist_ok=True)
    # For minutes: live.py DPN FOLDER noise 300, or soak 600
    chosen = sys.argv[3:4]
    if len(sys.argv) == 5 and sys.argv[4].isdigit():
        {"noise": noise, "soak": soak}[chosen[0]](float(sys.argv[4]))
        sys.exit()
    failed = 0
    cases = [case for case in CASES if not chosen or case.__name__ in sys.argv[3:]]
    for case in cases:
        begun = time.monotonic()
        try:
            case()
            print(f"ok {case.__name__}: {case.__doc__} ({time.monotonic() - begun:.0f} s)", flush=True)
        except Exception:
            failed += 1
            traceback.print_exc()
            print(f"FAILED {case.__name__}", flush=True)
    print(f"{len(cases) - failed} passed, {failed} failed")
    sys.exit(failed > 0)
