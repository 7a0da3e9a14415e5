"""One motion for all logs of this folder, and what each file holds. Needs Python alone."""
import json
import math
from pathlib import Path

HERE = Path(__file__).parent
T0 = 1_600_000_000_250_000_000
G = 9.80665
DEG = math.pi / 180
EXPECTED = {}


def gyro(t):
    return [0.02 + 0.3 * math.sin(6 * t), -0.05 + 0.2 * math.cos(5 * t), 0.11 - 0.1 * math.sin(4 * t)]


def accel(t, down=False):
    z = -9.72 if down else 9.72
    return [0.4 + 0.2 * math.sin(3 * t), -1.1 + 0.3 * math.cos(7 * t), z + 0.1 * math.sin(9 * t)]


def motion(hz, count, down=False, digits=6):
    """Seconds from the start, rad/s, m/s^2, rounded as they are written."""
    rows = []
    for i in range(count):
        t = i / hz
        rows.append((t, [round(v, digits) for v in gyro(t)], [round(v, digits) for v in accel(t, down)]))
    return rows


def expect(name, kind, hz, rows, start_ns=0, tolerance=1e-6, guesses=(), flags=()):
    """`rows`: seconds from the start, rad/s, m/s^2."""
    pick = [0, len(rows) // 3, len(rows) - 1]
    EXPECTED[name] = {
        "kind": kind, "rate_hz": hz, "count": len(rows), "tolerance": tolerance, "guesses": list(guesses),
        "flags": list(flags),
        "samples": [
            {"at": i, "t_ns": start_ns + round(rows[i][0] * 1e9), "gyro": rows[i][1], "accel": rows[i][2]} for i in pick
        ],
    }


def write(name, text, encoding="utf-8"):
    path = HERE / name
    path.parent.mkdir(exist_ok=True)
    data = text if isinstance(text, bytes) else text.encode(encoding)
    path.write_bytes(data)
    return data


def comma(number):
    return str(number).replace(".", ",")


def save(versions, logs=None):
    """Writes expected.json, a line a log."""
    lines = [json.dumps(name) + ": " + json.dumps(log) for name, log in (logs or EXPECTED).items()]
    with open(HERE / "expected.json", "w") as file:
        file.write('{"versions": ' + json.dumps(versions) + ',\n"logs": {\n' + ",\n".join(lines) + "\n}}\n")
