# requirements: numpy, opencv-python-headless, pillow, rosbags, lz4, zstandard (versions used stand in the file it writes)
"""Writes small files of every kind in which images come with an IMU, and what OpenCV makes of them: expected/*.pgm, expected.json.

Two images of 64 x 48 px at 10 Hz, 40 samples of an IMU at 200 Hz around them. `encodings.bag` and `encodings.mcap` hold the images once in every
encoding, a topic each; `sqlite` in two; `folder_png` and `folder_jpeg` are a camera's folder with times.txt and imu.txt. Run in this folder:
python3 make.py
"""
import json
import shutil
import sys
from importlib.metadata import version
from pathlib import Path

import cv2
import numpy as np
from PIL import Image
from rosbags.rosbag1 import Writer as Bag1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer as Bag2
from rosbags.typesys import Stores, get_typestore

HERE = Path(__file__).parent
T0 = 1_600_000_000_250_000_000
W, H = 64, 48
STAMPS = [T0 + 50_000_000, T0 + 150_000_000]


def scene(i):
    y, x = np.mgrid[0:H, 0:W]
    red = 120 + 90 * np.sin(x / 7.0 + i) * np.cos(y / 9.0)
    green = 128 + 100 * np.sin((x + 2 * y) / 11.0 - i)
    blue = 90 + 80 * ((x // 8 + y // 8 + i) % 2)
    # In steps, so that the files are small.
    return (np.clip(np.stack([red, green, blue], axis=2), 0, 250) // 9 * 9).astype(np.uint8)


RGB = [scene(i) for i in range(2)]
GREY = [cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY) for rgb in RGB]
# OpenCV names a filter by the second row's second and third pixel.
FILTERS = {
    "rggb": ([[0, 1], [1, 2]], cv2.COLOR_BayerBG2GRAY), "bggr": ([[2, 1], [1, 0]], cv2.COLOR_BayerRG2GRAY),
    "gbrg": ([[1, 2], [0, 1]], cv2.COLOR_BayerGR2GRAY), "grbg": ([[1, 0], [2, 1]], cv2.COLOR_BayerGB2GRAY),
}


def filtered(rgb, places):
    raw = np.zeros((H, W), np.uint8)
    for dy in range(2):
        for dx in range(2):
            raw[dy::2, dx::2] = rgb[dy::2, dx::2, places[dy][dx]]
    return raw


def wide(pixels):
    return pixels.astype(np.uint16) * 256 + 37


def yuv(grey, first):
    pair = np.full((H, W, 2), 128, np.uint8)
    pair[:, :, first] = grey
    return pair


def encodings(i):
    """Name of the topic to encoding, pixels, name of what is expected, bytes of padding behind a row."""
    rgb, grey = RGB[i], GREY[i]
    alpha = np.full((H, W, 1), 200, np.uint8)
    found = {
        "mono8": ("mono8", grey, "colour", 0), "padded": ("mono8", grey, "colour", 5), "mono16": ("mono16", wide(grey), "colour", 0),
        "mono16_big": ("mono16", wide(grey).astype(">u2"), "colour", 0),
        "rgb8": ("rgb8", rgb, "colour", 0), "bgr8": ("bgr8", rgb[:, :, ::-1], "colour", 0),
        "rgba8": ("rgba8", np.concatenate([rgb, alpha], 2), "colour", 0),
        "bgra8": ("bgra8", np.concatenate([rgb[:, :, ::-1], alpha], 2), "colour", 0),
        "yuv422": ("yuv422", yuv(grey, 1), "colour", 0), "yuy2": ("yuv422_yuy2", yuv(grey, 0), "colour", 0),
    }
    for name, (places, _) in FILTERS.items():
        found[name] = (f"bayer_{name}8", filtered(rgb, places), name, 0)
    found["rggb16"] = ("bayer_rggb16", wide(filtered(rgb, FILTERS["rggb"][0])), "rggb", 0)
    return found


def packed(i, end):
    # The second is progressive.
    args = [cv2.IMWRITE_JPEG_QUALITY, 95, cv2.IMWRITE_JPEG_PROGRESSIVE, i] if end == ".jpg" else []
    return cv2.imencode(end, RGB[i][:, :, ::-1], args)[1]


def header(store, ros1, t, frame):
    types = store.types
    head, time = types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"]
    when = time(sec=t // 10**9, nanosec=t % 10**9)
    return head(seq=0, stamp=when, frame_id=frame) if ros1 else head(stamp=when, frame_id=frame)


def samples():
    for i in range(40):
        yield T0 + 5_000_000 * i, [0.25 * i, -0.125 * i, 2.0**-10 * i], [0.5 - 2.0**-8 * i, 0.0, 9.8125]


def messages(store, ros1, wanted=None):
    types = store.types
    imu, image, small = types["sensor_msgs/msg/Imu"], types["sensor_msgs/msg/Image"], types["sensor_msgs/msg/CompressedImage"]
    vector, quaternion, zeros = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"], np.zeros(9)
    for t, gyro, accel in samples():
        yield t + 300_000, "/imu0", "sensor_msgs/msg/Imu", imu(
            header=header(store, ros1, t, "imu"), orientation=quaternion(x=0.0, y=0.0, z=0.0, w=1.0), orientation_covariance=zeros,
            angular_velocity=vector(*gyro), angular_velocity_covariance=zeros, linear_acceleration=vector(*accel),
            linear_acceleration_covariance=zeros)
    for i, t in enumerate(STAMPS):
        for name, (encoding, pixels, _, padding) in encodings(i).items():
            rows = np.ascontiguousarray(pixels).reshape(H, -1).view(np.uint8)
            rows = np.pad(rows, ((0, 0), (0, padding)), constant_values=255)
            if wanted is None or name in wanted:
                # Frames of lengths that need padding in CDR.
                yield t + 2_000_000, f"/{name}/image_raw", "sensor_msgs/msg/Image", image(
                    header=header(store, ros1, t, "c" * (1 + len(name) % 5)), height=H, width=W, encoding=encoding,
                    is_bigendian=int(name == "mono16_big"), step=rows.shape[1], data=rows.reshape(-1))
        for end in [".jpg", ".png"]:
            name = {".jpg": "jpeg", ".png": "png"}[end]
            if wanted is None or name in wanted:
                yield t + 3_000_000, f"/{name}/image_raw/compressed", "sensor_msgs/msg/CompressedImage", small(
                    header=header(store, ros1, t, "cam"), format=f"rgb8; {name} compressed bgr8", data=packed(i, end))


def write(writer, store, ros1, wanted=None):
    connections = {}
    serialize = store.serialize_ros1 if ros1 else store.serialize_cdr
    for t, topic, kind, message in sorted(messages(store, ros1, wanted), key=lambda m: m[0]):
        if topic not in connections:
            connections[topic] = writer.add_connection(topic, kind, typestore=store)
        writer.write(connections[topic], t, serialize(message, kind))


def folder(name, end):
    path = HERE / name
    shutil.rmtree(path, ignore_errors=True)
    (path / "images").mkdir(parents=True)
    lines = []
    for i, t in enumerate(STAMPS):
        (path / "images" / f"{i}{end}").write_bytes(bytes(packed(i, end)))
        lines.append(f"{i} {t // 10**9}.{t % 10**9:09d} 12.5\n")
    (path / "times.txt").write_text("".join(lines))
    rows = [" ".join(map(repr, [t, *gyro, *accel])) + "\n" for t, gyro, accel in samples()]
    (path / "imu.txt").write_text("".join(rows))


def main():
    ros1, ros2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_HUMBLE)
    for name in ["encodings.bag", "encodings.mcap"]:
        (HERE / name).unlink(missing_ok=True)
    bag = Bag1(HERE / "encodings.bag")
    bag.set_compression(Bag1.CompressionFormat.BZ2)
    with bag:
        write(bag, ros1, True)
    for name, plugin, wanted in [("mcap", StoragePlugin.MCAP, None), ("sqlite", StoragePlugin.SQLITE3, ["bgr8", "jpeg"])]:
        shutil.rmtree(HERE / name, ignore_errors=True)
        bag = Bag2(HERE / name, version=8, storage_plugin=plugin)
        if plugin == StoragePlugin.MCAP:
            bag.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        with bag:
            write(bag, ros2, False, wanted)
    shutil.move(HERE / "mcap" / "mcap.mcap", HERE / "encodings.mcap")
    shutil.rmtree(HERE / "mcap")
    folder("folder_png", ".png")
    folder("folder_jpeg", ".jpg")
    expected = HERE / "expected"
    shutil.rmtree(expected, ignore_errors=True)
    expected.mkdir()
    for i, rgb in enumerate(RGB):
        greys = {"colour": GREY[i], "jpeg": cv2.imdecode(packed(i, ".jpg"), cv2.IMREAD_GRAYSCALE)}
        greys |= {name: cv2.cvtColor(filtered(rgb, places), code) for name, (places, code) in FILTERS.items()}
        for name, grey in greys.items():
            Image.fromarray(grey).save(expected / f"{name}_{i}.pgm")
    topics = {f"/{name}/image_raw": kind for name, (_, _, kind, _) in encodings(0).items()}
    topics |= {"/jpeg/image_raw/compressed": "jpeg", "/png/image_raw/compressed": "colour"}
    versions = {name: version(name) for name in ["numpy", "opencv-python-headless", "pillow", "rosbags"]}
    (HERE / "expected.json").write_text(json.dumps({
        "versions": versions | {"python": sys.version.split()[0]}, "stamps_ns": STAMPS, "topics": topics,
        "imu_stamps_ns": [t for t, _, _ in samples()]}, indent=1) + "\n")


main()
