"""What ONNX Runtime makes of the models that `dpn export onnx` writes, on the committed seconds of real recordings: golden.json.

In the repository's root, with a dpn on the path: python golden/onnx/make.py. Needs numpy, onnx, onnxruntime.
"""

import hashlib
import json
import pathlib
import subprocess
import tempfile

import numpy as np
import onnx
import onnxruntime

WINDOW = 200
COLUMNS = {"gyro": (1, 2, 3), "accel": (4, 5, 6)}
NETWORKS = {"accel": ["sg11-s0", "wide-s0", "paper-s0"], "gyro": ["sg11-s0", "wide-s0", "paper-s0"]}


def windows(sensor):
    """[count, 200]: every axis of every whole window, sequence after sequence."""
    found = []
    for sequence in ["euroc/V1_01_easy", "tumvi/dataset-room1_512_16"]:
        rows = np.loadtxt(f"tests/data/{sequence}/mav0/imu0/data.csv", delimiter=",", comments="#")
        for start in range(0, len(rows) - WINDOW + 1, WINDOW):
            found += [rows[start : start + WINDOW, column] for column in COLUMNS[sensor]]
    return np.array(found, dtype=np.float32)


def main():
    cases = []
    with tempfile.TemporaryDirectory() as folder:
        names = ",".join(sorted({name for names in NETWORKS.values() for name in names}))
        subprocess.run(["dpn", "export", "onnx", "--network", names, "--out", folder], check=True)
        for sensor, networks in NETWORKS.items():
            for network in networks:
                file = pathlib.Path(folder) / sensor / f"{network}.onnx"
                onnx.checker.check_model(str(file), full_check=True)
                session = onnxruntime.InferenceSession(str(file), providers=["CPUExecutionProvider"])
                (sigma,) = session.run(["sigma"], {"window": windows(sensor)})
                said = session.get_modelmeta().custom_metadata_map
                assert said["sensor"] == sensor and float(said["rate_hz"]) == 200, said
                cases.append(
                    {
                        "sensor": sensor,
                        "network": network,
                        "model": hashlib.sha256(file.read_bytes()).hexdigest(),
                        "sigma": [float(f"{s:.9g}") for s in sigma],
                    }
                )
    versions = {"onnx": onnx.__version__, "onnxruntime": onnxruntime.__version__}
    path = pathlib.Path("golden/onnx/golden.json")
    path.write_text("[\n" + ",\n".join(json.dumps(case) for case in cases) + "\n]\n")
    print(versions)


if __name__ == "__main__":
    main()
