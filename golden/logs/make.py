# requirements: numpy, rosbags, zstandard, pyulog, pymavlink (versions used stand in the file it writes)
"""Writes logs as people have them, and expected.json: what every one of them holds, in rad/s, m/s^2 and ns.

One motion for all: every axis has a mean and a swing of its own, so that no two axes, signs or units can be taken for each other. README.md
says where each format is described. Run in this folder: python3 make.py
"""
import gzip
import io
import json
import lzma
import math
import shutil
import struct
import sys
import zipfile
from importlib.metadata import version
from pathlib import Path

import numpy as np
import zstandard
from rosbags.rosbag1 import Writer as Bag1
from rosbags.rosbag2 import StoragePlugin, Writer as Bag2
from rosbags.typesys import Stores, get_typestore

from motion import DEG, EXPECTED, G, HERE, T0, accel, comma, expect, gyro, motion, save, write
import dialects


# Phones -----------------------------------------------------------------------------------------------------------------------------

def sensor_logger():
    """Two files at two rates; columns z, y, x; gravity apart from the rest of the acceleration."""
    rows = motion(100, 120)
    lines = [f"{T0 + round(t * 1e9)},{t:.4f},{g[2]},{g[1]},{g[0]}" for t, g, _ in rows]
    write("sensor_logger/Gyroscope.csv", "time,seconds_elapsed,z,y,x\n" + "\n".join(lines) + "\n")
    for name, share in [("Accelerometer", 0.25), ("Gravity", 0.75), ("TotalAcceleration", 1.0)]:
        lines = []
        for i in range(-1, 62):
            t = i / 50 + 0.003
            a = [round(share * v, 6) for v in accel(t)]
            lines.append(f"{T0 + round(t * 1e9)},{t:.4f},{a[2]},{a[1]},{a[0]}")
        if name != "TotalAcceleration":
            write(f"sensor_logger/{name}.csv", "time,seconds_elapsed,z,y,x\n" + "\n".join(lines) + "\n")
    write("sensor_logger/Metadata.csv", "version,device name\n3,phone\n")
    # A straight line between neighbours 20 ms apart: off by at most w^2 h^2 / 8 of the swing.
    expect("sensor_logger", "two_files", 100.0, rows, T0, 2e-3, ["Gravity.csv"])


def phyphox():
    rows = motion(200, 120)
    head = '"Time (s)","X (rad/s)","Y (rad/s)","Z (rad/s)"\n'
    write("phyphox/Gyroscope.csv", head + "".join(f"{t:.9E},{g[0]:.9E},{g[1]:.9E},{g[2]:.9E}\n" for t, g, _ in rows))
    head = '"Time (s)","X (m/s^2)","Y (m/s^2)","Z (m/s^2)"\n'
    lines = []
    for i in range(-1, 63):
        t = i / 100
        lines.append(",".join(f"{v:.9E}" for v in [t, *accel(t)]) + "\n")
    write("phyphox/Accelerometer.csv", head + "".join(lines))
    (HERE / "phyphox/meta").mkdir(exist_ok=True)
    write("phyphox/meta/device.csv", '"property","value"\n"deviceModel","phone"\n')
    expect("phyphox", "two_files", 200.0, rows, 0, 1e-3, ["Accelerometer.csv"])


def androsensor():
    rows = motion(50, 90)
    names = [f"{s} {a} ({u})" for s, u in [("ACCELEROMETER", "m/s²"), ("GRAVITY", "m/s²"), ("LINEAR ACCELERATION", "m/s²"),
                                           ("GYROSCOPE", "rad/s"), ("MAGNETIC FIELD", "μT")] for a in "XYZ"]
    head = ";".join(names + ["ORIENTATION Z (azimuth °)", "Time since start in ms ", "YYYY-MO-DD HH-MI-SS_SSS"])
    lines = [head]
    for t, g, a in rows:
        gravity = [0.3, -1.0, 9.7]
        linear = [round(u - v, 6) for u, v in zip(a, gravity)]
        ms = round(t * 1e3)
        stamp = f"2024-05-04 10-11-{12 + ms // 1000}_{ms % 1000}"
        lines.append(";".join(map(str, [*a, *gravity, *linear, *g, 21.5, -3.25, 40.0, 181.5, 37 + ms, stamp])))
    write("androsensor.csv", "\n".join(lines) + "\n")
    expect("androsensor.csv", "csv", 50.0, rows, 37_000_000)


def physics_toolbox():
    rows = motion(100, 120)
    lines = ["time,gFx,gFy,gFz,ax,ay,az,wx,wy,wz,p,Bx,By,Bz,Azimuth,Pitch,Roll,"]
    for t, g, a in rows:
        force = [f"{v / G:.7f}" for v in a]
        linear = ["0.1", "0.2", "-0.05"]
        lines.append(",".join([f"{t:.4f}", *force, *linear, *map(str, g), "1013.2", "12", "-3", "40", "180", "2", "3", ""]))
    write("physics_toolbox.csv", "\n".join(lines) + "\n")
    expect("physics_toolbox.csv", "csv", 100.0, rows, 0, 2e-6, ["gFx"])


# Autopilots -------------------------------------------------------------------------------------------------------------------------

ULOG_MAGIC = b"ULog\x01\x12\x35"


def ulog_message(kind, payload):
    return struct.pack("<HB", len(payload), ord(kind)) + payload


def ulog(formats, data):
    """`formats`: name to fields; `data`: (topic, bytes) in order."""
    out = ULOG_MAGIC + struct.pack("<BQ", 1, 1_000_000)
    out += ulog_message("B", bytes(40))
    key = b"char[4] sys_name"
    out += ulog_message("I", bytes([len(key)]) + key + b"PX4 ")
    for name, fields in formats.items():
        out += ulog_message("F", f"{name}:{fields}".encode())
    for number, name in enumerate(formats):
        out += ulog_message("A", struct.pack("<BH", 0, number) + name.encode())
    for topic, payload in data:
        out += ulog_message("D", struct.pack("<H", list(formats).index(topic)) + payload)
    out += ulog_message("L", struct.pack("<BQ", ord("6"), 5) + b"end")
    return out


COMBINED = ("uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;int32_t accelerometer_timestamp_relative;"
            "float[3] accelerometer_m_s2;uint32_t accelerometer_integral_dt;uint8_t accelerometer_clipping;uint8_t[3] _padding0;")
VEHICLE = ("uint64_t timestamp;uint64_t timestamp_sample;uint32_t accel_device_id;uint32_t gyro_device_id;float[3] delta_angle;"
           "float[3] delta_velocity;uint32_t delta_angle_dt;uint32_t delta_velocity_dt;uint8_t delta_velocity_clipping;uint8_t[7] _padding0;")
BAROMETER = "uint64_t timestamp;float pressure;uint8_t[4] _padding0;"


def px4():
    rows = motion(250, 100, down=True)
    start = 12_345_000
    data, table = [], []
    for i, (t, g, a) in enumerate(rows):
        us = start + round(t * 1e6)
        data.append(("sensor_combined", struct.pack("<Q3fIi3fIB", us, *g, 4000, 0, *a, 4000, 0)))
        table.append([us, *g, 4000, 0, *a, 4000, 0])
        if i % 10 == 0:
            data.append(("sensor_baro", struct.pack("<Qf", us, 950.0)))
    write("px4.ulg", ulog({"sensor_combined": COMBINED, "sensor_baro": BAROMETER}, data))
    expect("px4.ulg", "ulog", 250.0, rows, start * 1000, 1e-5)
    head = ["timestamp", *(f"gyro_rad[{i}]" for i in range(3)), "gyro_integral_dt", "accelerometer_timestamp_relative",
            *(f"accelerometer_m_s2[{i}]" for i in range(3)), "accelerometer_integral_dt", "accelerometer_clipping"]
    write("px4_sensor_combined_0.csv", "".join(",".join(map(str, row)) + "\n" for row in [head, *table]))
    expect("px4_sensor_combined_0.csv", "csv", 250.0, rows, start * 1000)
    data, table = [], []
    for t, g, a in rows:
        us = start + round(t * 1e6)
        dt = 5000
        angle, velocity = ([round(v * dt * 1e-6, 9) for v in values] for values in (g, a))
        data.append(("vehicle_imu", struct.pack("<QQII3f3fIIB", us + 310, us, 7, 8, *angle, *velocity, dt, dt, 0)))
        table.append([us + 310, us, 7, 8, *angle, *velocity, dt, dt, 0])
    write("px4_integrals.ulg", ulog({"vehicle_imu": VEHICLE}, data))
    expect("px4_integrals.ulg", "ulog", 250.0, rows, start * 1000, 1e-5)
    head = ["timestamp", "timestamp_sample", "accel_device_id", "gyro_device_id", *(f"delta_angle[{i}]" for i in range(3)),
            *(f"delta_velocity[{i}]" for i in range(3)), "delta_angle_dt", "delta_velocity_dt", "delta_velocity_clipping"]
    write("px4_vehicle_imu_0.csv", "".join(",".join(map(str, row)) + "\n" for row in [head, *table]))
    expect("px4_vehicle_imu_0.csv", "csv", 250.0, rows, start * 1000, 1e-5, ["increments"])


def ardupilot():
    rows = motion(50, 64, down=True, digits=5)
    formats = [
        (128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"),
        (100, 3 + 51, "IMU", "QBffffffIIfBBHH", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz"),
        (101, 3 + 8 + 12, "BARO", "Qfff", "TimeUS,Alt,Press,Temp"),
    ]
    start = 98_765_432
    text = ["".join(f"FMT, {n}, {length}, {name}, {kinds}, {names}\n" for n, length, name, kinds, names in formats),
            "PARM, 98700000, INS_ACCEL_FILTER, 20, 20\n"]
    binary = b""
    for number, length, name, kinds, names in formats:
        pad = lambda s, n: s.encode().ljust(n, b"\0")
        binary += b"\xa3\x95\x80" + struct.pack("<BB", number, length) + pad(name, 4) + pad(kinds, 16) + pad(names, 64)
    for i, (t, g, a) in enumerate(rows):
        us = start + round(t * 1e6)
        for instance, shift in [(0, 0.0), (1, 0.5)]:
            row = [*(v + shift for v in g), *(v + shift for v in a)]
            binary += b"\xa3\x95\x64" + struct.pack("<QB6fIIfBBHH", us, instance, *row, 0, 0, 41.5, 1, 1, 1000, 1000)
            numbers = ", ".join(f"{v:.5f}" for v in row)
            text.append(f"IMU, {us}, {instance}, {numbers}, 0, 0, 41.5, 1, 1, 1000, 1000\n")
        if i % 5 == 0:
            binary += b"\xa3\x95\x65" + struct.pack("<Qfff", us, 1.0, 95000.0, 30.0)
            text.append(f"BARO, {us}, 1.0, 95000.0, 30.0\n")
    write("ardupilot.bin", binary)
    expect("ardupilot.bin", "ardupilot", 50.0, rows, start * 1000, 1e-5, ["instance 0"])
    write("ardupilot.log", "".join(text))
    expect("ardupilot.log", "ardupilot_text", 50.0, rows, start * 1000, 1e-5, ["instance 0"])
    # As mavlogdump --format csv --types IMU writes one instance.
    lines = ["timestamp,TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz"]
    for t, g, a in rows:
        us = start + round(t * 1e6)
        lines.append(",".join(map(str, [f"{T0 * 1e-9 + t:.8f}", us, *g, *a, 0, 0, 41.5, 1, 1, 1000, 1000])))
    write("ardupilot_imu.csv", "\n".join(lines) + "\n")
    expect("ardupilot_imu.csv", "csv", 50.0, rows, start * 1000, 1e-6, ["TimeUS"])


# ROS --------------------------------------------------------------------------------------------------------------------------------

def rostopic():
    rows = motion(200, 64)
    fields = ["time", "field.header.seq", "field.header.stamp", "field.header.frame_id"]
    fields += [f"field.orientation.{a}" for a in "xyzw"] + [f"field.orientation_covariance{i}" for i in range(9)]
    fields += [f"field.angular_velocity.{a}" for a in "xyz"] + [f"field.angular_velocity_covariance{i}" for i in range(9)]
    fields += [f"field.linear_acceleration.{a}" for a in "xyz"] + [f"field.linear_acceleration_covariance{i}" for i in range(9)]
    zeros = ["0.0"] * 9
    lines = ["%" + ",".join(fields)]
    for i, (t, g, a) in enumerate(rows):
        ns = T0 + round(t * 1e9)
        late = 300_000 + 40_000 * (i % 7)
        lines.append(",".join(map(str, [ns + late, i, ns, "imu_link", 0.0, 0.0, 0.0, 1.0, *zeros, *g, *zeros, *a, *zeros])))
    write("rostopic.csv", "\n".join(lines) + "\n")
    expect("rostopic.csv", "csv", 200.0, rows, T0, 1e-6, ["field.header.stamp"])
    lines = []
    for t, g, a in rows:
        ns = T0 + round(t * 1e9)
        lines.append(",".join(map(str, [ns // 10**9, ns % 10**9, "imu_link", 0.0, 0.0, 0.0, 1.0, *zeros, *g, *zeros, *a, *zeros])))
    write("ros2_echo.csv", "\n".join(lines) + "\n")
    expect("ros2_echo.csv", "csv", 200.0, rows, T0, 1e-6, ["ros2 topic echo"])


def realsense():
    """Accelerometer at 63 Hz and gyroscope at 200 Hz on topics of their own."""
    rows = motion(200, 48)
    halves = []
    for t, g, _ in rows:
        halves.append((T0 + round(t * 1e9), "gyro", g, [0.0] * 3))
    for i in range(-1, 17):
        t = i / 62.5
        halves.append((T0 + round(t * 1e9), "accel", [0.0] * 3, [round(v, 6) for v in accel(t)]))
    halves.sort(key=lambda half: half[:2])

    def serialised(store, ros1):
        types = store.types
        header, time = types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"]
        vector, quaternion = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
        imu = types["sensor_msgs/msg/Imu"]
        zeros, unknown = np.zeros(9), np.array([-1.0] + [0.0] * 8)
        for i, (ns, half, g, a) in enumerate(halves):
            when = time(sec=ns // 10**9, nanosec=ns % 10**9)
            frame = f"camera_{half}_optical_frame"
            head = header(seq=i, stamp=when, frame_id=frame) if ros1 else header(stamp=when, frame_id=frame)
            message = imu(header=head, orientation=quaternion(x=0.0, y=0.0, z=0.0, w=0.0), orientation_covariance=unknown,
                          angular_velocity=vector(*g), angular_velocity_covariance=zeros,
                          linear_acceleration=vector(*a), linear_acceleration_covariance=zeros)
            yield ns + 250_000, half, (store.serialize_ros1 if ros1 else store.serialize_cdr)(message, "sensor_msgs/msg/Imu")

    topics = {half: f"/camera/{half}/sample" for half in ["gyro", "accel"]}
    store = get_typestore(Stores.ROS1_NOETIC)
    path = HERE / "realsense.bag"
    path.unlink(missing_ok=True)
    writer = Bag1(path)
    writer.set_compression(Bag1.CompressionFormat.BZ2)
    with writer:
        connections = {half: writer.add_connection(topic, "sensor_msgs/msg/Imu", typestore=store) for half, topic in topics.items()}
        for t, half, data in serialised(store, True):
            writer.write(connections[half], t, data)
    store = get_typestore(Stores.ROS2_HUMBLE)
    for name, plugin in [("realsense_ros2", StoragePlugin.SQLITE3), ("realsense_mcap", StoragePlugin.MCAP)]:
        path = HERE / name
        shutil.rmtree(path, ignore_errors=True)
        with Bag2(path, version=8, storage_plugin=plugin) as writer:
            connections = {half: writer.add_connection(topic, "sensor_msgs/msg/Imu", typestore=store)
                           for half, topic in topics.items()}
            for t, half, data in serialised(store, False):
                writer.write(connections[half], t, data)
    import sqlite3
    base = sqlite3.connect(HERE / "realsense_ros2/realsense_ros2.db3", isolation_level=None)
    base.execute("DELETE FROM message_definitions")
    base.execute("PRAGMA page_size=512")
    base.execute("VACUUM")
    base.close()
    # MCAP as one file, packed as a whole.
    packed = zstandard.ZstdCompressor(level=19).compress((HERE / "realsense_mcap/realsense_mcap.mcap").read_bytes())
    write("realsense.mcap.zst", packed)
    shutil.rmtree(HERE / "realsense_mcap")
    for name, kind in [("realsense.bag", "rosbag1"), ("realsense_ros2", "rosbag2"), ("realsense.mcap.zst", "mcap")]:
        expect(name, kind, 200.0, rows, T0, 2e-3, ["/camera/accel/sample"])


# Sensors' own programs --------------------------------------------------------------------------------------------------------------

def xsens():
    rows = motion(100, 120)
    head = ["PacketCounter", "SampleTimeFine", "Year", "Month", "Day", "Second", "Acc_X", "Acc_Y", "Acc_Z", "FreeAcc_E",
            "FreeAcc_N", "FreeAcc_U", "Gyr_X", "Gyr_Y", "Gyr_Z", "Mag_X", "Mag_Y", "Mag_Z"]
    lines = ["// Start Time: Unknown", "// Update Rate: 100.0Hz", "// Filter Profile: human (46.1)", "// Firmware Version: 4.0.2",
             ";".join(head)]
    for i, (t, g, a) in enumerate(rows):
        lines.append(";".join(map(str, [4000 + i, 2_000_000 + round(t * 1e4), "", "", "", "", *a, 0.1, 0.2, 0.3, *g, 0.5, 0.4, 0.3, ""])))
    write("xsens.csv", "\r\n".join(lines) + "\r\n")
    expect("xsens.csv", "csv", 100.0, rows, 200_000_000_000, 1e-6, ["100us"])


def vectornav():
    rows = motion(400, 90)
    lines = ["TimeStartup,TimeGps,UncompAccelX,UncompAccelY,UncompAccelZ,UncompGyroX,UncompGyroY,UncompGyroZ,AccelX,AccelY,AccelZ,"
             "AngularRateX,AngularRateY,AngularRateZ,Temp"]
    for t, g, a in rows:
        raw = [round(v + 0.25, 6) for v in [*a, *g]]
        lines.append(",".join(map(str, [5_000_000_000 + round(t * 1e9), 0, *raw, *a, *g, 31.5])))
    write("vectornav.csv", "\n".join(lines) + "\n")
    expect("vectornav.csv", "csv", 400.0, rows, 5_000_000_000)


# Tables of one's own ----------------------------------------------------------------------------------------------------------------

def tables():
    rows = motion(200, 120)
    line = lambda t, g, a: [f"{t:.3f}", *map(str, g), *map(str, a)]
    # Decimal commas between semicolons, degrees, g, a byte order mark.
    head = "Nr;Time (s);Gyro X (°/s);Gyro Y (°/s);Gyro Z (°/s);Acc X (g);Acc Y (g);Acc Z (g)"
    text = [head]
    for i, (t, g, a) in enumerate(rows):
        text.append(";".join([str(i), *map(comma, [f"{t:.3f}", *(f"{v / DEG:.7f}" for v in g), *(f"{v / G:.8f}" for v in a)])]))
    write("decimal_commas.csv", "\ufeff" + "\r\n".join(text) + "\r\n")
    expect("decimal_commas.csv", "csv", 200.0, rows)
    # Tabs and decimal commas under comments of other styles.
    text = ["! written by hand", "; second comment", "t [ms]\tax [m/s^2]\tay [m/s^2]\taz [m/s^2]\tgx [rad/s]\tgy [rad/s]\tgz [rad/s]"]
    text += ["\t".join(map(comma, [f"{t * 1e3:.0f}", *a, *g])) for t, g, a in rows]
    write("tabs.tsv", "\n".join(text) + "\n")
    expect("tabs.tsv", "csv", 200.0, rows)
    # Names, then units, under a preamble with numbers in it; written by a spreadsheet in Latin-1.
    text = ["Logger 2000,serial,1234", "Sample rate,200", "", "Timestamp,Gyro_X,Gyro_Y,Gyro_Z,Accel_X,Accel_Y,Accel_Z",
            "ms,°/s,°/s,°/s,m/s²,m/s²,m/s²"]
    text += [",".join(map(str, [f"{t * 1e3:.1f}", *(f"{v / DEG:.7f}" for v in g), *a])) for t, g, a in rows]
    write("two_line_header.csv", "\n".join(text) + "\n", "latin-1")
    expect("two_line_header.csv", "csv", 200.0, rows)
    # Sensors above axes.
    text = [",Accelerometer,,,Gyroscope,,", "Time (us),X,Y,Z,X,Y,Z"]
    text += [",".join(map(str, [round(t * 1e6), *a, *g])) for t, g, a in rows]
    write("grouped_header.csv", "\n".join(text) + "\n")
    expect("grouped_header.csv", "csv", 200.0, rows)
    # Packed as a whole.
    plain = "timestamp [ns],wx [rad/s],wy,wz,ax [m/s^2],ay,az\n" + "".join(
        ",".join(map(str, [T0 + round(t * 1e9), *g, *a])) + "\n" for t, g, a in rows)
    buffer = io.BytesIO()
    with gzip.GzipFile(fileobj=buffer, mode="wb", mtime=0) as file:
        file.write(plain.encode())
    write("packed.csv.gz", buffer.getvalue())
    write("packed.csv.xz", lzma.compress(plain.encode(), preset=6))
    write("packed.csv.zst", zstandard.ZstdCompressor().compress(plain.encode()))
    for end in ["gz", "xz", "zst"]:
        expect(f"packed.csv.{end}", "csv", 200.0, rows, T0)


def archives():
    """The apps share a zip of the folder."""
    for name, folder in [("phyphox.zip", "phyphox"), ("sensor_logger.zip", "sensor_logger")]:
        buffer = io.BytesIO()
        with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
            for file in sorted((HERE / folder).rglob("*.csv")):
                archive.writestr(zipfile.ZipInfo(str(file.relative_to(HERE / folder))), file.read_bytes(), zipfile.ZIP_DEFLATED)
        write(name, buffer.getvalue())
        EXPECTED[name] = EXPECTED[folder]


def counts():
    """A driver's registers: MPU6050 at its power-on ranges."""
    rows = motion(200, 120)
    text, read = ["micros,ax,ay,az,gx,gy,gz"], []
    for t, g, a in rows:
        force = [round(v / G * 16384) for v in a]
        turn = [round(v / DEG * 131) for v in g]
        text.append(",".join(map(str, [round(t * 1e6), *force, *turn])))
        read.append((t, [v / 131 * DEG for v in turn], [v / 16384 * G for v in force]))
    write("counts.csv", "\n".join(text) + "\n")
    expect("counts.csv", "csv", 200.0, read, 0, 1e-9, [], ["--sensor-scale", "mpu6050-2g-250dps"])


for make in [sensor_logger, phyphox, androsensor, physics_toolbox, px4, ardupilot, rostopic, realsense, xsens, vectornav, tables, archives, counts]:
    make()


def check_by_others():
    """The writers of binary logs above are held to the readers that their projects publish."""
    from pymavlink import DFReader
    from pyulog import ULog
    for name in ["px4.ulg", "px4_integrals.ulg"]:
        data = ULog(str(HERE / name)).data_list[0].data
        first = EXPECTED[name]["samples"][0]
        stamps = data.get("timestamp_sample", data["timestamp"])
        assert stamps[0] * 1000 == first["t_ns"], name
    log = DFReader.DFReader_binary(str(HERE / "ardupilot.bin"))
    message = log.recv_match(type="IMU")
    assert message.TimeUS * 1000 == EXPECTED["ardupilot.bin"]["samples"][0]["t_ns"]
    assert abs(message.GyrX - EXPECTED["ardupilot.bin"]["samples"][0]["gyro"][0]) < 1e-6


check_by_others()
packages = ["numpy", "rosbags", "zstandard", "pyulog", "pymavlink"]
dialects.make()
save({"python": sys.version.split()[0], **{p: version(p) for p in packages}})
