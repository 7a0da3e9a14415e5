"""What ONNX Runtime makes of exported models, on committed seconds of real recordings: golden.json.

In the repository's root: python golden/onnx/make.py. Needs cargo, numpy, onnx, onnxruntime. The models are those of src/onnx/tests/models.rs.
"""

import hashlib
import json
import os
import pathlib
import subprocess
import tempfile

import numpy as np
import onnx
import onnxruntime

WRITE = "cargo test --workspace --locked --test onnx models_are_written -- --ignored"


def main():
    cases = []
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(WRITE.split(), check=True, env=os.environ | {"DPN_ONNX": folder})
        for number, asked in enumerate(json.loads((pathlib.Path(folder) / "models.json").read_text())):
            file = pathlib.Path(folder) / f"{number}.onnx"
            onnx.checker.check_model(str(file), full_check=True)
            session = onnxruntime.InferenceSession(str(file), providers=["CPUExecutionProvider"])
            said = session.get_modelmeta().custom_metadata_map
            sensor = asked["name"].split()[0]
            assert sensor not in ("accel", "gyro") or (said["sensor"], float(said["rate_hz"])) == (sensor, 200), said
            (window,) = session.get_inputs()
            answers = session.run(None, {window.name: np.array(asked["input"], dtype=np.float32).reshape(asked["shape"])})
            cases.append(
                {
                    "name": asked["name"],
                    "model": hashlib.sha256(file.read_bytes()).hexdigest(),
                    "answers": [[float(f"{a:.9g}") for a in answer.ravel()] for answer in answers],
                }
            )
    path = pathlib.Path("golden/onnx/golden.json")
    path.write_text("[\n" + ",\n".join(json.dumps(case) for case in cases) + "\n]\n")
    print(len(cases), "models;", {"onnx": onnx.__version__, "onnxruntime": onnxruntime.__version__})


if __name__ == "__main__":
    main()
