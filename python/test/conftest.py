"""The command line that came with the package, and the repository's small recordings."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

# A shell starts what runs in the background with SIGINT ignored, and Python leaves it so: here Ctrl-C is to be Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)

ROOT = Path(__file__).resolve().parents[2]
EXCERPT = ROOT / "tests/data/euroc/V1_01_easy"
CAMERA = EXCERPT / "mav0/cam0/sensor.yaml"


def run_command(*args, code=0, cwd=None):
    program = os.path.join(os.path.dirname(sys.executable), "dpn")
    done = subprocess.run([program, *map(str, args)], capture_output=True, text=True, cwd=cwd)
    assert done.returncode == code, done.stderr
    return done


@pytest.fixture(scope="session")
def flight(tmp_path_factory):
    """A flight of known noise on disk: its folder and a file of tracks."""
    root = tmp_path_factory.mktemp("flight")
    run_command("simulate", "flight", "room-medium", "--seed", 1, "--out", root)
    folder, tracks = root / "f07-room-medium", root / "tracks.txt"
    run_command("simulate", "tracks", folder, "--out", tracks)
    return folder, tracks


def said_by_run(out, *args):
    """The report of ``dpn run --json``, which wrote into ``out``."""
    return json.loads(run_command("run", *args, "--json", "--out", out).stdout)
