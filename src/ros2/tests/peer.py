"""What plays a recording to the node over loopback and keeps what comes back."""

import copy
import csv
import os
import re
import subprocess
import threading
import time
from pathlib import Path
from types import SimpleNamespace

DOMAIN = 1 + os.getpid() % 200
# Loopback alone, without multicast: a test sends to nobody else.
os.environ["CYCLONEDDS_URI"] = """<CycloneDDS><Domain Id="any">
<General><Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces><AllowMulticast>false</AllowMulticast></General>
<Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer Address="127.0.0.1"/></Peers></Discovery>
</Domain></CycloneDDS>"""

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from messages import *

NONE = [0.0] * 9
RELIABLE = Policy.Reliability.Reliable(duration(seconds=10))
BEST_EFFORT = Policy.Reliability.BestEffort


class Node:
    """The program, its words as they come."""

    def __init__(self, dpn, *args):
        environment = {**os.environ, "ROS_DOMAIN_ID": str(DOMAIN), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        self.process = subprocess.Popen(
            [dpn, "ros2", *map(str, args)], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=environment
        )
        self.lines = []
        self.reader = threading.Thread(target=lambda: self.lines.extend(self.process.stderr), daemon=True)
        self.reader.start()

    def said(self):
        return "".join(self.lines)

    def wait_for(self, words, seconds=20):
        until = time.monotonic() + seconds
        while words not in self.said():
            assert time.monotonic() < until, f"no `{words}` in {seconds} s:\n{self.said()}"
            assert self.process.poll() is None, f"it ended:\n{self.said()}"
            time.sleep(0.05)

    def end(self):
        """Asked to end; its exit code."""
        self.process.terminate()
        code = self.process.wait(20)
        self.reader.join(5)
        return code

    def kill(self):
        self.process.kill()
        self.process.wait(20)

    def memory_mb(self):
        for line in Path(f"/proc/{self.process.pid}/status").read_text().splitlines():
            if line.startswith("VmRSS"):
                return int(line.split()[1]) / 1024
        return None


class Peer:
    """A participant: writers by topic, and what readers took."""

    def __init__(self):
        self.participant = DomainParticipant(DOMAIN)
        self.writers = {}
        self.readers = []
        self.running = True
        self.thread = threading.Thread(target=self.collect, daemon=True)
        self.thread.start()

    def writer(self, topic, kind, *policies):
        qos = Qos(*(policies or (RELIABLE, Policy.History.KeepLast(4000), Policy.Durability.Volatile)))
        writer = DataWriter(self.participant, Topic(self.participant, f"rt{topic}", kind), qos=qos)
        self.writers[topic] = writer
        return writer

    def reader(self, topic, kind):
        """A list that grows: when a message came, and it."""
        qos = Qos(RELIABLE, Policy.History.KeepLast(1000), Policy.Durability.Volatile)
        came = []
        self.readers.append((DataReader(self.participant, Topic(self.participant, f"rt{topic}", kind), qos=qos), came))
        return came

    def collect(self):
        while self.running:
            for reader, came in list(self.readers):
                # A writer that goes leaves a sample that is none.
                now, taken = time.monotonic(), reader.take(100)
                came.extend((now, message) for message in taken if hasattr(message, "serialize"))
            time.sleep(0.0005)

    def matched(self, *topics, seconds=20):
        until = time.monotonic() + seconds
        for topic in topics:
            while not self.writers[topic].get_matched_subscriptions():
                assert time.monotonic() < until, f"nobody listens to {topic}"
                time.sleep(0.05)
        # Readers that came back have been told of us too.
        time.sleep(0.5)

    def close(self):
        self.running = False
        self.thread.join(5)


class FastPeer(Peer):
    """The same by Fast DDS, in a process of its own (fastdds.cpp)."""

    def __init__(self, program, transport):
        self.process = subprocess.Popen([program, str(DOMAIN), transport], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.writers, self.readers, self.listeners = {}, [], {}
        self.thread = threading.Thread(target=self.collect, daemon=True)
        self.thread.start()

    def frame(self, what, number, payload):
        self.process.stdin.write(what + number.to_bytes(4, "little") + len(payload).to_bytes(4, "little") + payload)
        self.process.stdin.flush()

    def endpoint(self, what, number, topic, kind, reliable, latched):
        self.frame(what, number, f"{reliable:d}{latched:d}1000 rt{topic} {kind.__idl_typename__}".encode())

    def writer(self, topic, kind, *policies):
        number = len(self.writers)
        write = lambda message: self.frame(b"m", number, message.serialize())
        self.writers[topic] = SimpleNamespace(write=write, get_matched_subscriptions=lambda: self.listeners.get(number, 0))
        self.endpoint(b"w", number, topic, kind, BEST_EFFORT not in policies, Policy.Durability.TransientLocal in policies)
        return self.writers[topic]

    def reader(self, topic, kind):
        number, came = len(self.readers), []
        self.readers.append((kind, came))
        self.endpoint(b"r", number, topic, kind, True, False)
        return came

    def collect(self):
        while head := self.process.stdout.read(9):
            what, number = head[:1], int.from_bytes(head[1:5], "little")
            payload = self.process.stdout.read(int.from_bytes(head[5:], "little"))
            if what == b"w":
                self.listeners[number] = int(payload)
            else:
                kind, came = self.readers[number]
                came.append((time.monotonic(), kind.deserialize(payload)))

    def close(self):
        self.process.stdin.close()
        assert self.process.wait(20) == 0
        self.thread.join(5)


def ready(message, octets=None):
    """A message whose bytes are made once, in quick ways; `octets` are what its last field, empty so far, is to hold."""
    blob = message.serialize()
    if octets is not None:
        blob = blob[:-4] + len(octets).to_bytes(4, "little") + octets
    return of_bytes(message, blob)


def of_bytes(message, blob):
    message = copy.copy(message)
    message.serialize = lambda use_version_2=None: blob
    return message


def moved(message, ns):
    """The same with another stamp, which is the first field."""
    blob = message.serialize()
    stamp = (ns // 1_000_000_000).to_bytes(4, "little") + (ns % 1_000_000_000).to_bytes(4, "little")
    return of_bytes(message, blob[:4] + stamp + blob[12:])


def imu_message(ns, gyro, accel, frame="imu"):
    return ready(Imu(Header(Time.at(ns), frame), Quaternion(0.0, 0.0, 0.0, 1.0), NONE, Vector3(*gyro), NONE, Vector3(*accel), NONE))


class Recording:
    """An ASL folder: samples and images as messages, with when they are due [ns]."""

    def __init__(self, folder, compressed):
        self.mav = Path(folder) / "mav0"
        self.calibration = self.mav / "cam0" / "sensor.yaml"
        rows = [row for row in csv.reader(open(self.mav / "imu0" / "data.csv")) if row and not row[0].startswith("#")]
        self.samples = [(int(row[0]), imu_message(int(row[0]), [float(v) for v in row[1:4]], [float(v) for v in row[4:7]])) for row in rows]
        rows = [row for row in csv.reader(open(self.mav / "cam0" / "data.csv")) if row and not row[0].startswith("#")]
        self.images = [(int(row[0]), self.image(int(row[0]), self.mav / "cam0" / "data" / row[1].strip(), compressed)) for row in rows]

    def image(self, ns, path, compressed):
        header = Header(Time.at(ns), "cam")
        if compressed:
            return ready(CompressedImage(header, "mono8; png", []), path.read_bytes())
        from PIL import Image as Picture

        picture = Picture.open(path)
        width, height = picture.size
        return ready(Image(header, height, width, "mono8", 0, width, []), picture.tobytes())

    def numbers(self, key):
        text = self.calibration.read_text()
        found = re.search(rf"{key}:.*?\[(.*?)\]", text, re.DOTALL).group(1)
        return [float(v) for v in found.replace("\n", " ").split(",")]


def play(peer, events, started=None):
    """Sends (due [ns], topic, message) at their own speed; when each was sent, by topic and stamp."""
    events = sorted(events, key=lambda event: event[0])
    begin, first = time.monotonic() if started is None else started, events[0][0]
    sent = {}
    for due, topic, message in events:
        ahead = begin + (due - first) * 1e-9 - time.monotonic()
        if ahead > 0:
            time.sleep(ahead)
        if topic is None:
            message()
            continue
        peer.writers[topic].write(message)
        sent.setdefault((topic, due), time.monotonic())
    return sent
