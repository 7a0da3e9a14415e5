"""Cuts the few seconds of real recordings in this folder out of the unpacked data sets: make.py DATA, with the standard library alone.

Bytes are copied line by line, line ends included; nothing is converted.
"""
import pathlib
import sys

DATA = pathlib.Path(sys.argv[1])
HERE = pathlib.Path(__file__).parent
SECOND = 1_000_000_000


def stamp(line):
    return int(line.split(b",")[0])


def cut(source, target, begin_ns, seconds):
    lines = (DATA / source).read_bytes().splitlines(keepends=True)
    rows = [line for line in lines[1:] if 0 <= stamp(line) - begin_ns < seconds * SECOND]
    path = HERE / target
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(lines[0] + b"".join(rows))
    print(f"{target}: {len(rows)} rows, {path.stat().st_size} bytes")


def first(source):
    return stamp((DATA / source).read_bytes().splitlines()[1])


euroc = "euroc/V1_01_easy/mav0"
begin = first(f"{euroc}/imu0/data.csv") + 30 * SECOND
for part in ("imu0", "cam0", "state_groundtruth_estimate0"):
    cut(f"{euroc}/{part}/data.csv", f"{euroc}/{part}/data.csv", begin, 4)
for part in ("imu0", "cam0"):
    (HERE / f"{euroc}/{part}/sensor.yaml").write_bytes((DATA / f"{euroc}/{part}/sensor.yaml").read_bytes())

euroc = "euroc/MH_01_easy/mav0"
begin = first(f"{euroc}/state_groundtruth_estimate0/data.csv") + 40 * SECOND
for part in ("imu0", "state_groundtruth_estimate0"):
    cut(f"{euroc}/{part}/data.csv", f"{euroc}/{part}/data.csv", begin, 1)

tumvi = "tumvi/dataset-room1_512_16/mav0"
begin = first(f"{tumvi}/mocap0/data.csv") + 20 * SECOND
for part in ("imu0", "mocap0"):
    cut(f"{tumvi}/{part}/data.csv", f"{tumvi}/{part}/data.csv", begin, 2)
