"""Logs of apps and drivers that need Python alone to be written: make.py makes them with the rest, and run by itself this script makes these anew
and leaves the others in expected.json as they are. Run in this folder: python3 dialects.py
"""
import json
import math

from motion import DEG, EXPECTED, G, HERE, accel, expect, motion, save, write


def table(name, head, rows, kind="csv", **expected):
    write(name, "\n".join([*head, *(",".join(map(str, row)) for row in rows)]) + "\n")


def upside_down(rows):
    """What an iPhone reads: -1 g upwards."""
    return [(t, g, [-v for v in a]) for t, g, a in rows]


def iphones():
    rows = motion(100, 120)
    apple = upside_down(rows)
    head = ("loggingTime(txt),loggingSample(N),accelerometerTimestamp_sinceReboot(s),accelerometerAccelerationX(G),accelerometerAccelerationY(G),"
            "accelerometerAccelerationZ(G),motionTimestamp_sinceReboot(s),motionYaw(rad),motionRotationRateX(rad/s),motionRotationRateY(rad/s),"
            "motionRotationRateZ(rad/s),motionUserAccelerationX(G),motionUserAccelerationY(G),motionUserAccelerationZ(G)")
    start = 405121.25
    table("sensorlog_ios.csv", [head], [
        [f"2023-11-07T09:06:03.{i:03}+02:00", i, f"{start + t + 0.001:.6f}", *(f"{v / G:.8f}" for v in a), f"{start + t:.6f}", 0, *g, 0, 0, 0]
        for i, (t, g, a) in enumerate(apple)])
    expect("sensorlog_ios.csv", "csv", 100.0, apple, round(start * 1e9), 2e-6, ["motionTimestamp_sinceReboot", "-1 g upwards"])
    table("stray_scanner.csv", ["timestamp, a_x, a_y, a_z, alpha_x, alpha_y, alpha_z"], [
        [f"{65575.5 + t:.6f}", *(f" {v / G:.9f}" for v in a), *(f" {v}" for v in g)] for t, g, a in apple])
    expect("stray_scanner.csv", "csv", 100.0, apple, 65575_500_000_000, 1e-6, ["-1 g upwards", "accelerometer in g"])


def core_motion():
    """What Core Motion hands out: gravity apart, in g."""
    rows = upside_down(motion(100, 120))
    lines = []
    for t, g, a in rows:
        up = math.sqrt(sum(v * v for v in a))
        gravity = [round(v / up, 6) for v in a]
        lines.append([f"{500000.25 + t:.6f}", *g, *(f"{v / G - u:.8f}" for v, u in zip(a, gravity)), *gravity])
    names = [f"{name}.{axis}" for name in ["rotationRate", "userAcceleration", "gravity"] for axis in "xyz"]
    table("core_motion.csv", [",".join(["timestamp", *names])], lines)
    expect("core_motion.csv", "csv", 100.0, rows, 500000_250_000_000, 2e-6, ["-1 g upwards", "`gravity.x` added to `userAcceleration.x`", "accelerometer in g"])


def metawear():
    """MbientLab's: a file a sensor, the time of day beside the epoch."""
    rows = motion(100, 120)
    for name, unit, at, one in [("Gyroscope", "deg/s", 1, DEG), ("Accelerometer", "g", 2, G)]:
        head = "epoch (ms),time (-13:00),elapsed (s)," + ",".join(f"{axis}-axis ({unit})" for axis in "xyz")
        table(f"metawear/MetaWear_C8D9_{name}_100.000Hz_1.5.0.csv", [head], [
            [1600000000250 + round(row[0] * 1e3), f"2020-09-13T05.26.{40.25 + row[0]:06.3f}", f"{row[0]:.3f}", *(f"{v / one:.6f}" for v in row[at])] for row in rows])
    expect("metawear", "two_files", 100.0, rows, 1600000000_250_000_000, 1e-5, ["not `time (-13:00)`"])


def ticks():
    """.NET's stamps: 100 ns since the year 1."""
    rows = motion(100, 120)
    start, until_1970 = 638_500_000_002_500_000, 621_355_968_000_000_000
    table("ticks.csv", ["Timestamp,AccelX,AccelY,AccelZ,GyroX,GyroY,GyroZ"], [[start + round(t * 1e7), *a, *g] for t, g, a in rows])
    expect("ticks.csv", "csv", 100.0, rows, (start - until_1970) * 100, 1e-6, ["stamps in 100ns"])


def oxiod():
    rows = motion(100, 120)
    lines = []
    for t, g, a in upside_down(rows):
        up = math.sqrt(sum(v * v for v in a))
        gravity = [round(v / up, 6) for v in a]
        lines.append([f"{500000.25 + t:.6f}", 0.1, 0.2, 0.3, *g, *gravity, *(f"{v / G - u:.8f}" for v, u in zip(a, gravity)), 20.5, 1.5, -40.25])
    table("oxiod.csv", [], lines)
    expect("oxiod.csv", "csv", 100.0, upside_down(rows), 500000_250_000_000, 2e-6, ["-1 g upwards", "OxIOD"])


def ridi():
    """RIDI's: a file a sensor, stamps in ns since the phone was started."""
    rows = motion(200, 120)
    start = 54321_250_000_000
    for name, of in [("gyro", lambda g, a: g), ("acce", lambda g, a: a), ("gravity", lambda g, a: [0.0, 0.0, 9.81])]:
        write(f"ridi/{name}.txt", "# Created at 2017-07-21 15:32:10\n" + "".join(
            f"{start + round(t * 1e9)} {' '.join(f'{v:.6f}' for v in of(g, a))}\n" for t, g, a in rows))
    expect("ridi", "two_files", 200.0, rows, start, 2e-6, ["accelerometer from acce.txt", "stamps in ns"])


def nclt():
    """NCLT's ms25.csv, without a header: stamps in us, magnetometer, accelerometer, turning. What could mean several things is told."""
    rows = motion(50, 120)
    start = 1326030975_250000
    table("nclt_ms25.csv", [], [[start + round(t * 1e6), 0.12, -0.25, 0.4, *a, *g] for t, g, a in rows])
    expect("nclt_ms25.csv", "csv", 50.0, rows, start * 1000, 1e-6, ["stamps in us"], ["--columns", "1,8,9,10,5,6,7"])


def tum_rgbd():
    """TUM RGB-D's accelerometer.txt: one sensor, blanks."""
    rows = [(t, [0.0, 0.0, 0.0], a) for t, _, a in motion(500, 120)]
    write("tum_rgbd_accelerometer.txt", "# accelerometer data\n# file: 'rgbd_dataset_freiburg1_xyz.bag'\n# timestamp ax ay az\n" + "".join(
        f"{1305031098 + t:.6f} {' '.join(f'{v:.6f}' for v in a)}\n" for t, _, a in rows))
    expect("tum_rgbd_accelerometer.txt", "csv", 500.0, rows, 1305031098_000_000_000, 1e-6, ["stamps in s"])


def androids():
    rows = motion(100, 120)
    start = 65972053803181
    ns = lambda t: start + round(t * 1e9)
    table("mars_logger.csv", ["Timestamp[nanosec], gx[rad/s], gy[rad/s], gz[rad/s], ax[m/s^2], ay[m/s^2], az[m/s^2], Unix time[nanosec]"], [
        [ns(t), *(f" {v}" for v in g), *(f" {v}" for v in a), f" {1663164669189000000 + round(t * 1e9)}"] for t, g, a in rows])
    expect("mars_logger.csv", "csv", 100.0, rows, start, 1e-6, ["Timestamp[nanosec]"])
    table("hyperimu.csv", ["HIMU 3.1.4, sampling rate 10 ms", "Timestamp," + ",".join(f"LSM6DSO {s}.{a}" for s in ["Accelerometer", "Gyroscope"] for a in "xyz")], [
        [1663164669189 + round(t * 1e3), *a, *g] for t, g, a in rows])
    expect("hyperimu.csv", "csv", 100.0, rows, 1663164669189000000, 1e-6)
    # A row a sensor, the accelerometer's between the gyroscope's.
    long, gnss, objects = [], [], []
    for i in range(-1, 121):
        t, later = i / 100, i / 100 + 0.004
        g, a = motion(100, 121)[max(i, 0)][1], [round(v, 6) for v in accel(later)]
        ms = 1663164669189 + round(t * 1e3)
        if i >= 0 and i < 120:
            long.append(["UncalGyro", ms, ns(t), *g, -0.009, 0.0, -0.008])
            gnss.append(["UncalGyro", ms, ns(t), *g, -0.009, 0.0, -0.008, 3])
            objects.append({"accuracy": 3, "sensorType": 4, "timestamp": ns(t), "values": g})
        long.append(["UncalAccel", ms + 4, ns(later), *a, 0.0, 0.0, 0.0])
        gnss.append(["UncalAccel", ms + 4, ns(later), *a, 0.0, 0.0, 0.0, 3])
        objects.append({"accuracy": 3, "sensorType": 1, "timestamp": ns(later), "values": a})
        gnss.append(["Status", ms, "", "", 3])
    head = "MessageType,utcTimeMillis,elapsedRealtimeNanos,MeasurementX,MeasurementY,MeasurementZ,BiasX,BiasY,BiasZ"
    table("device_imu.csv", [head], long)
    comments = ["# Version: v3.0.5.6", "#", "# Status,UnixTimeMillis,SignalCount", "#",
                "# UncalAccel,utcTimeMillis,elapsedRealtimeNanos,UncalAccelXMps2,UncalAccelYMps2,UncalAccelZMps2,BiasXMps2,BiasYMps2,BiasZMps2,Accuracy",
                "# UncalGyro,utcTimeMillis,elapsedRealtimeNanos,UncalGyroXRadPerSec,UncalGyroYRadPerSec,UncalGyroZRadPerSec,DriftXRadPerSec,"
                "DriftYRadPerSec,DriftZRadPerSec,Accuracy"]
    table("gnss_logger.txt", comments, gnss)
    # A straight line between neighbours 10 ms apart: off by at most w^2 h^2 / 8 of the swing.
    for name in ["device_imu.csv", "gnss_logger.txt"]:
        expect(name, "csv", 100.0, rows, start, 1e-3, ["accelerometer from UncalAccel"])
    write("slam_logger.jsonl", "\n".join(json.dumps(one, indent=2) for one in objects) + "\n")
    expect("slam_logger.jsonl", "json", 100.0, rows, start, 1e-3, ["accelerometer from accelerometer"])
    # A phone's clock that has run for eight days: no us since 1970; without a header.
    rows = motion(500, 120)
    start = 672705976809250
    table("uptime.csv", [], [[start + round(t * 1e9), *a, *g] for t, g, a in rows])
    expect("uptime.csv", "csv", 500.0, rows, start, 1e-6, ["stamps in ns", "accelerometer, gyroscope"])


def objects():
    rows = motion(100, 120)
    us = lambda t: 690212403769 + round(t * 1e6)
    xyz = lambda v: dict(zip("xyz", v))
    write("pilotguru/rotations.json", json.dumps({"rotations": [{**xyz(g), "time_usec": us(t)} for t, g, _ in rows]}, indent=1))
    write("pilotguru/accelerations.json", json.dumps({"accelerations": [{**xyz(a), "time_usec": us(t)} for t, _, a in rows]}, indent=1))
    expect("pilotguru", "two_files", 100.0, rows, 690212403769000, 1e-6, ["accelerometer from accelerations.json"])
    both = [{"sensor": name, "time": str(1_600_000_000_250_000_000 + round(t * 1e9)), "seconds_elapsed": f"{t:.3f}",
             **{k: str(v) for k, v in xyz(values).items()}}
            for t, g, a in rows for name, values in [("Gyroscope", g), ("TotalAcceleration", a)]]
    write("sensor_logger.json", json.dumps(both))
    expect("sensor_logger.json", "json", 100.0, rows, 1_600_000_000_250_000_000, 1e-6, ["TotalAcceleration"])
    lines = [json.dumps({"t": round(100 + t, 6), "imu": {"gyro": xyz(g), "accel": xyz(a)}}) for t, g, a in rows]
    write("objects.jsonl", "\n".join(lines) + "\n")
    expect("objects.jsonl", "json", 100.0, rows, 100_000_000_000, 1e-6)


def without_stamps():
    rows = motion(256, 120)
    head = ",".join(["Packet number", *(f"Gyroscope {a} (deg/s)" for a in "XYZ"), *(f"Accelerometer {a} (g)" for a in "XYZ"), *(f"Magnetometer {a} (G)" for a in "XYZ")])
    table("xio.csv", [head], [
        [i, *(f"{v / DEG:.7f}" for v in g), *(f"{v / G:.8f}" for v in a), 0.2, 0.1, -0.4] for i, (t, g, a) in enumerate(rows)])
    expect("xio.csv", "csv", 256.0, rows, 0, 1e-6, [], ["--rate", "256"])
    rows = motion(100, 120)
    write("three_files/time.csv", "time (sec)\n" + "".join(f"{t:.18e}\n" for t, _, _ in rows))
    for name, pick, unit, one in [("gyro-0", 1, "deg/s", DEG), ("accel-0", 2, "m/s^2", 1)]:
        sensor = name.split("-")[0]
        lines = [",".join(f"{v / one:.18e}" for v in row[pick]) for row in rows]
        write(f"three_files/{name}.csv", ",".join(f"{sensor}_{a} ({unit})" for a in "xyz") + "\n" + "\n".join(lines) + "\n")
    expect("three_files", "two_files", 100.0, rows)


def others():
    rows = motion(200, 120)
    start = 1_600_000_000_250_000_000
    table("kalibr_bagcreater.csv", ["timestamp,omega_x,omega_y,omega_z,alpha_x,alpha_y,alpha_z"],
          [[start + round(t * 1e9), *g, *a] for t, g, a in rows])
    expect("kalibr_bagcreater.csv", "csv", 200.0, rows, start)
    rows = motion(1000, 120)
    head = "loopIteration,time,axisP[0],gyroADC[0],gyroADC[1],gyroADC[2],accSmooth[0],accSmooth[1],accSmooth[2],motor[0]"
    table("blackbox_decode.csv", [head], [
        [i, 5_000_000 + round(t * 1e6), 0, *(f"{v / DEG:.6f}" for v in g), *(f"{v / G:.8f}" for v in a), 1000] for i, (t, g, a) in enumerate(rows)])
    expect("blackbox_decode.csv", "csv", 1000.0, rows, 5_000_000_000, 2e-6, ["accelerometer in g"])


def unsigned(value):
    """A number of the blackbox: seven bits a byte, the lowest first."""
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    return bytes(out + bytes([value]))


def signed(value):
    return unsigned(2 * value if value >= 0 else -2 * value - 1)


def blackbox(name, finer=1):
    """Betaflight's own log: a whole frame (I), then some of differences (P), whose time is foreseen along a line from the second on. `finer`: what
    `blackbox_high_resolution` multiplies the gyroscope's counts by, beside the same scale."""
    rows = motion(500, 120)
    gyro_scale, acc_1g = 0.0625, 2048
    names = "loopIteration,time,gyroADC[0],gyroADC[1],gyroADC[2],accSmooth[0],accSmooth[1],accSmooth[2],motor[0],motor[1]"
    head = ["Product:Blackbox flight data recorder by Nicholas Sherlock", "Data version:2", f"Field I name:{names}", "Field I signed:0,0,1,1,1,1,1,1,0,0",
            "Field I predictor:0,0,0,0,0,0,0,0,0,0", "Field I encoding:1,1,0,0,0,0,0,0,1,1", "Field P predictor:6,2,1,1,1,1,1,1,1,1",
            "Field P encoding:9,0,0,0,0,0,0,0,0,0", "Field S name:flightModeFlags", "Field S signed:0", "Field S predictor:0", "Field S encoding:1",
            "Firmware type:Cleanflight", "Firmware revision:Betaflight 4.4.2 (23d066d08) STM32F7X2", "gyro_scale:0x3d800000", f"acc_1G:{acc_1g}",
            "minthrottle:1070", "motorOutput:158,2047", "motor_pwm_protocol:6"] + ["blackbox_high_resolution:1"] * (finer > 1)
    data = "".join(f"H {line}\n" for line in head).encode()
    for i, (t, g, a) in enumerate(rows):
        counts = [round(v / DEG / gyro_scale * finer) for v in g] + [round(v / G * acc_1g) for v in a]
        now = [33_000_000 + round(t * 1e6), *counts, 200 + i, 300 + i]
        if i % 32 == 0:
            data += b"I" + unsigned(i) + unsigned(now[0]) + b"".join(map(signed, now[1:7])) + b"".join(map(unsigned, now[7:]))
        else:
            foreseen = before[0] if i % 32 == 1 else 2 * before[0] - older[0]
            data += b"P" + signed(now[0] - foreseen) + b"".join(signed(a - b) for a, b in zip(now[1:], before[1:]))
        older, before = before if i else now, now
    write(name, data + b"E\xffEnd of log\0")
    # Off by half a count.
    expect(name, "blackbox", 500.0, rows, 33_000_000_000, 2.5e-3)


def gyroflow():
    """Counts behind a preamble that says what one is."""
    rows = motion(200, 120)
    gscale, ascale = 0.00122173047, 0.00048828125
    head = ["GYROFLOW IMU LOG", "version,1.3", "id,made_up", "orientation,XYZ", "note,made up", "fwversion,0.1", "timestamp,1644159993", "vendor,nobody",
            "frame_readout_time,15.23", "tscale,0.001", f"gscale,{gscale}", f"ascale,{ascale}", "t,gx,gy,gz,ax,ay,az"]
    table("gyroflow.gcsv", head, [
        [round(t * 1e3), *(round(v / gscale) for v in g), *(round(v / G / ascale) for v in a)] for t, g, a in rows])
    # Off by half a count.
    expect("gyroflow.gcsv", "csv", 200.0, rows, 0, 2.5e-3, ["gscale, ascale, tscale"])


def printed():
    """What a terminal shows: messages of ROS 1 by `rostopic echo`, and a board's lines in Arduino's monitor with the time of day."""
    rows = motion(200, 24)
    start = 1_600_000_000_250_000_000
    xyz = lambda values: "".join(f"  {a}: {v}\n" for a, v in zip("xyz", values))
    covariance = f"[{', '.join(['0.0'] * 9)}]\n"
    text = ""
    for i, (t, g, a) in enumerate(rows):
        seconds, ns = divmod(start + round(t * 1e9), 10**9)
        text += f'header: \n  seq: {i}\n  stamp: \n    secs: {seconds}\n    nsecs: {ns:9d}\n  frame_id: "imu_link"\n'
        text += f"orientation: \n{xyz([0.0] * 3)}  w: 1.0\norientation_covariance: {covariance}"
        text += f"angular_velocity: \n{xyz(g)}angular_velocity_covariance: {covariance}"
        text += f"linear_acceleration: \n{xyz(a)}linear_acceleration_covariance: {covariance}---\n"
    write("rostopic_echo.txt", text)
    expect("rostopic_echo.txt", "echo", 200.0, rows, start)
    rows = motion(100, 120)
    lines = ["09:59:58.000 -> gx,gy,gz,ax,ay,az"] + [f"09:59:59.{round(500 + t * 1e3):03d} -> " + ",".join(map(str, [*g, *a])) for t, g, a in rows[:50]]
    lines += [f"10:00:00.{round(t * 1e3 - 500):03d} -> " + ",".join(map(str, [*g, *a])) for t, g, a in rows[50:]]
    write("serial_monitor.txt", "\n".join(lines) + "\n")
    expect("serial_monitor.txt", "csv", 100.0, rows, (10 * 3600 * 10 - 5) * 10**8)


def make():
    for one in [iphones, core_motion, oxiod, ridi, nclt, tum_rgbd, androids, metawear, ticks, objects, without_stamps, others, gyroflow, printed]:
        one()
    blackbox("betaflight.bbl")
    blackbox("betaflight_fine.bbl", 10)


if __name__ == "__main__":
    before = json.loads((HERE / "expected.json").read_text())
    make()
    save(before["versions"], {**before["logs"], **EXPECTED})
