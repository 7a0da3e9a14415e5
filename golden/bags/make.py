# requirements: numpy, rosbags, mcap-ros2-support, lz4, zstandard (versions used stand in the file it writes)
"""Writes the bags of the readers' tests, and expected.json: what every one of them holds.

A bag has 12 messages of sensor_msgs/Imu at 100 Hz on /imu0, interleaved with 4 of std_msgs/String on /talk; `two_imus` has a second IMU on
/imu1. Values are exact in binary. Run in this folder: python3 make.py
"""
import json
import shutil
import sqlite3
import sys
from importlib.metadata import version
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType
from mcap_ros2.writer import Writer as McapRos2Writer
from rosbags.rosbag1 import Writer as Bag1
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer as Bag2
from rosbags.typesys import Stores, get_typestore

HERE = Path(__file__).parent
T0 = 1_600_000_000_250_000_000
COUNT = 12


def values(i, shift=0.0):
    gyro = [0.25 * i + shift, -0.125 * i, 2.0**-10 * i]
    accel = [0.5 - 2.0**-8 * i, shift, 9.8125]
    return gyro, accel


def stamp(i):
    return T0 + 10_000_000 * i


def messages(store, ros1, shift=0.0):
    types = store.types
    header, time = types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"]
    vector, quaternion = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
    imu = types["sensor_msgs/msg/Imu"]
    zeros = np.zeros(9)
    for i in range(COUNT):
        t = stamp(i)
        when = time(sec=t // 10**9, nanosec=t % 10**9)
        # A frame of a length that needs padding in CDR.
        head = header(seq=i, stamp=when, frame_id="imu_link") if ros1 else header(stamp=when, frame_id="imu_link")
        gyro, accel = values(i, shift)
        yield t + 300_000, imu(
            header=head, orientation=quaternion(x=0.0, y=0.0, z=0.0, w=1.0), orientation_covariance=zeros,
            angular_velocity=vector(*gyro), angular_velocity_covariance=zeros,
            linear_acceleration=vector(*accel), linear_acceleration_covariance=zeros)


def words(store):
    string = store.types["std_msgs/msg/String"]
    return [(stamp(3 * i) + 1_000_000, string(data=f"word {i}")) for i in range(4)]


def bag1(name, compression, two=False, imu=True):
    store = get_typestore(Stores.ROS1_NOETIC)
    path = HERE / f"{name}.bag"
    path.unlink(missing_ok=True)
    writer = Bag1(path)
    if compression is not None:
        writer.set_compression(compression)
    writer.chunk_threshold = 4 * 1024
    with writer:
        todo = []
        talk = writer.add_connection("/talk", "std_msgs/msg/String", typestore=store)
        todo += [(t, talk, store.serialize_ros1(m, "std_msgs/msg/String")) for t, m in words(store)]
        topics = ["/imu0", "/imu1"] if two else ["/imu0"]
        for k, topic in enumerate(topics if imu else []):
            connection = writer.add_connection(topic, "sensor_msgs/msg/Imu", typestore=store)
            todo += [(t, connection, store.serialize_ros1(m, "sensor_msgs/msg/Imu")) for t, m in messages(store, True, float(k))]
        for t, connection, data in sorted(todo, key=lambda item: item[0]):
            writer.write(connection, t, data)


def bag2(name, plugin):
    store = get_typestore(Stores.ROS2_HUMBLE)
    path = HERE / name
    shutil.rmtree(path, ignore_errors=True)
    with Bag2(path, version=8, storage_plugin=plugin) as writer:
        talk = writer.add_connection("/talk", "std_msgs/msg/String", typestore=store)
        imu = writer.add_connection("/imu0", "sensor_msgs/msg/Imu", typestore=store)
        todo = [(t, talk, store.serialize_cdr(m, "std_msgs/msg/String")) for t, m in words(store)]
        todo += [(t, imu, store.serialize_cdr(m, "sensor_msgs/msg/Imu")) for t, m in messages(store, False)]
        for t, connection, data in sorted(todo, key=lambda item: item[0]):
            writer.write(connection, t, data)


DEFINITION = """std_msgs/Header header
geometry_msgs/Quaternion orientation
float64[9] orientation_covariance
geometry_msgs/Vector3 angular_velocity
float64[9] angular_velocity_covariance
geometry_msgs/Vector3 linear_acceleration
float64[9] linear_acceleration_covariance
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


def mcap(name, compression):
    with open(HERE / f"{name}.mcap", "wb") as file:
        writer = McapRos2Writer(file, chunk_size=1024, compression=compression)
        schema = writer.register_msgdef("sensor_msgs/msg/Imu", DEFINITION)
        for i in range(COUNT):
            t = stamp(i)
            gyro, accel = values(i)
            xyz = lambda v: dict(zip("xyz", v))
            writer.write_message("/imu0", schema, {
                "header": {"stamp": {"sec": t // 10**9, "nanosec": t % 10**9}, "frame_id": "imu_link"},
                "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}, "orientation_covariance": [0.0] * 9,
                "angular_velocity": xyz(gyro), "angular_velocity_covariance": [0.0] * 9,
                "linear_acceleration": xyz(accel), "linear_acceleration_covariance": [0.0] * 9,
            }, log_time=t + 300_000, publish_time=t, sequence=i)
        writer.finish()


def raw_mcap(name, encoding, schema_encoding, kind, serialise):
    """Messages as `serialise` writes them, zstd in chunks."""
    with open(HERE / f"{name}.mcap", "wb") as file:
        writer = McapWriter(file, chunk_size=4096, compression=CompressionType.ZSTD)
        writer.start("", "golden/bags/make.py")
        schema = writer.register_schema(kind, schema_encoding, b"")
        channel = writer.register_channel("/imu0", encoding, schema)
        for i, (t, data) in enumerate(serialise()):
            writer.add_message(channel, log_time=t, data=bytes(data), publish_time=t, sequence=i)
        writer.finish()


def ros1_messages():
    store = get_typestore(Stores.ROS1_NOETIC)
    return [(t, store.serialize_ros1(m, "sensor_msgs/msg/Imu")) for t, m in messages(store, True)]


def big_endian_messages():
    store = get_typestore(Stores.ROS2_HUMBLE)
    return [(t, store.serialize_cdr(m, "sensor_msgs/msg/Imu", little_endian=False)) for t, m in messages(store, False)]


def packed_sqlite():
    """Messages compressed one by one, as `ros2 bag record --compression-mode message` does; small pages."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    path = HERE / "packed_messages"
    shutil.rmtree(path, ignore_errors=True)
    writer = Bag2(path, version=8, storage_plugin=StoragePlugin.SQLITE3)
    writer.set_compression(CompressionMode.MESSAGE, CompressionFormat.ZSTD)
    with writer:
        imu = writer.add_connection("/imu0", "sensor_msgs/msg/Imu", typestore=store)
        for t, m in messages(store, False):
            writer.write(imu, t, store.serialize_cdr(m, "sensor_msgs/msg/Imu"))
    base = sqlite3.connect(path / "packed_messages.db3", isolation_level=None)
    # The definitions of all types are the larger part of the file, and nobody reads them here.
    base.execute("DELETE FROM message_definitions")
    base.execute("PRAGMA page_size=512")
    base.execute("VACUUM")
    base.close()


bag1("plain", None)
bag1("lz4", Bag1.CompressionFormat.LZ4)
bag1("bz2", Bag1.CompressionFormat.BZ2)
bag1("two_imus", Bag1.CompressionFormat.BZ2, two=True)
bag1("no_imu", Bag1.CompressionFormat.BZ2, imu=False)
bag2("sqlite", StoragePlugin.SQLITE3)
bag2("mcap", StoragePlugin.MCAP)
mcap("plain", CompressionType.NONE)
mcap("lz4", CompressionType.LZ4)
mcap("zstd", CompressionType.ZSTD)
raw_mcap("ros1", "ros1", "ros1msg", "sensor_msgs/Imu", ros1_messages)
raw_mcap("big_endian", "cdr", "ros2msg", "sensor_msgs/msg/Imu", big_endian_messages)
raw_mcap("json", "json", "jsonschema", "sensor_msgs/msg/Imu", lambda: [(stamp(0), b"{}")])
packed_sqlite()
expected = {
    "versions": {"python": sys.version.split()[0], **{p: version(p) for p in ["numpy", "rosbags", "mcap", "mcap-ros2-support", "lz4", "zstandard"]}},
    "stamps_ns": [stamp(i) for i in range(COUNT)],
    "gyro": [values(i)[0] for i in range(COUNT)],
    "accel": [values(i)[1] for i in range(COUNT)],
}
with open(HERE / "expected.json", "w") as file:
    json.dump(expected, file)
    file.write("\n")
