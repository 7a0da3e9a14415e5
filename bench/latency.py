#!/usr/bin/env python3
"""From an image's arrival to its pose: VENV/bin/python bench/latency.py DPN LIBDPN_C.so [--times N] [--first]

The pack `motion` (752 x 480 at 20 Hz, looked for in $DPN_DATA, then in data/) is played at its own speed to `dpn run -` through a pipe, to `dpn ros2` by Cyclone DDS
over loopback and to the C library by ctypes, alone and beside a process that keeps one core busy. A time begins where the image is handed over and ends where its pose
is in the player's hands; every pose counts, those of the start too. VENV as src/ros2/tests/install.sh makes it, DPN with the feature ros2. --first puts player, program and
the busy process before everything else on the machine (nice -19, as root): for a machine that is not at rest.
"""

import ctypes
import json
import os
import subprocess
import sys
import threading
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "src/ros2/tests"))
from messages import *
from peer import *


def text(words):
    return len(words).to_bytes(4, "little") + words.encode()


def record(kind, body):
    return bytes([kind]) + len(body).to_bytes(8, "little") + body


def pipe(dpn, recording, events):
    """An MCAP stream without chunks, each message flushed as it comes."""
    begin = b"\x89MCAP0\r\n" + record(1, text("ros2") + text("latency.py"))
    for number, kind in ((1, "Imu"), (2, "Image")):
        number = number.to_bytes(2, "little")
        begin += record(3, number + text(f"sensor_msgs/msg/{kind}") + text("ros2msg") + text(""))
        begin += record(4, number + number + text("/" + kind.lower()) + text("cdr") + bytes(4))
    lines = []
    line = [dpn, "run", "-", "--calib", recording.calibration]
    with subprocess.Popen(line, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, bufsize=0) as process:
        def read():
            for line in process.stdout:
                lines.append((time.monotonic(), line))

        reader = threading.Thread(target=read)
        reader.start()
        process.stdin.write(begin)
        # The program starts in peace.
        time.sleep(0.5)

        def send(topic, t, message):
            stamp = t.to_bytes(8, "little")
            channel = 1 if topic == "/imu" else 2
            data = record(5, channel.to_bytes(2, "little") + bytes(4) + stamp + stamp + message.serialize())
            while data:
                data = data[process.stdin.write(data) :]

        sent = paced(events, send)
        process.stdin.close()
        reader.join(30)
    took = []
    for came, line in lines:
        seconds, nanos = line.split()[0].decode().split(".")
        took.append(came - sent[int(seconds) * 10**9 + int(nanos.ljust(9, "0"))])
    return took


def dds(dpn, recording, events):
    peer = Peer()
    odometry = peer.reader("/odometry", Odometry)
    peer.writer("/imu", Imu)
    peer.writer("/image", Image)
    node = Node(dpn, "--calib", recording.calibration, "--image", "image", "--reliable")
    peer.matched("/imu", "/image")
    sent = paced(events, lambda topic, t, message: peer.writers[topic].write(message))
    time.sleep(1)
    node.end()
    peer.close()
    return [came - sent[message.header.stamp.ns()] for came, message in odometry]


class Update(ctypes.Structure):
    _fields_ = [("t_ns", ctypes.c_int64), ("phase", ctypes.c_int), ("known", ctypes.c_uint8), ("tracked", ctypes.c_uint32), ("landmarks", ctypes.c_uint32)]
    # The rest of dpn_update, which is not looked at.
    _fields_ += [("numbers", ctypes.c_double * (3 + 4 + 3 + 3 + 3 + 36 + 1 + 9))]


def c(library, recording, events):
    dpn = ctypes.CDLL(library)
    handle = ctypes.c_uint64()
    dpn.dpn_last_error.restype = ctypes.c_char_p

    def well(status):
        assert status == 0, dpn.dpn_last_error()

    well(dpn.dpn_odometry_new(f'calibration = "{recording.calibration}"'.encode(), ctypes.byref(handle)))
    width, height = (int(v) for v in recording.numbers("resolution"))
    update, came = Update(), []

    def send(topic, t, message):
        if topic == "/imu":
            of = lambda v: (ctypes.c_double * 3)(v.x, v.y, v.z)
            well(dpn.dpn_odometry_imu(handle, ctypes.c_int64(t), of(message.angular_velocity), of(message.linear_acceleration)))
        else:
            well(dpn.dpn_odometry_image(handle, ctypes.c_int64(t), message.serialize()[-width * height :], *map(ctypes.c_size_t, (width, height, width))))
        while dpn.dpn_odometry_update(handle, ctypes.byref(update)) == 0:
            if update.known:
                came.append((time.monotonic(), update.t_ns))

    sent = paced(events, send)
    well(dpn.dpn_odometry_free(handle))
    return [at - sent[t] for at, t in came]


def paced(events, send):
    """Sends (due [ns], topic, message) at their own speed; when each image was sent, by its stamp."""
    begin, first, sent = time.monotonic(), events[0][0], {}
    for due, topic, message in events:
        ahead = begin + (due - first) * 1e-9 - time.monotonic()
        if ahead > 0:
            time.sleep(ahead)
        if topic == "/image":
            sent[due] = time.monotonic()
        send(topic, due, message)
    return sent


def quantile(values, share):
    values = sorted(values)
    return round(1e3 * values[min(len(values) - 1, int(share * len(values)))], 1)


if __name__ == "__main__":
    dpn, library, *more = sys.argv[1:]
    times = int(more[more.index("--times") + 1]) if "--times" in more else 1
    if "--first" in more:
        os.nice(-19)
    data = Path(os.environ.get("DPN_DATA", "data")) / "motion" / "MH_01_easy_start"
    recording = Recording(data.resolve(), compressed=False)
    # A sample of an image's own instant is sent right behind it.
    events = sorted([(t, "/image", m) for t, m in recording.images] + [(t, "/imu", m) for t, m in recording.samples], key=lambda event: event[0])
    for busy in (False, True):
        spin = subprocess.Popen([sys.executable, "-c", "while True: pass"]) if busy else None
        for name, way, program in (("pipe", pipe, dpn), ("ROS 2", dds, dpn), ("C", c, library)):
            load = os.getloadavg()[0]
            took = [one for _ in range(times) for one in way(str(Path(program).resolve()), recording, events)]
            figures = {"way": name, "one core busy": busy, "poses": len(took), "median_ms": quantile(took, 0.5), "p99_ms": quantile(took, 0.99), "load": load}
            print(json.dumps(figures), flush=True)
        if spin:
            spin.kill()
            spin.wait()
