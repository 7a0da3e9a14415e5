"""The notebook and its source run on another log, and the notebook is that source's."""

import json
import os
import subprocess
import sys

import pytest
from conftest import ROOT

EXAMPLES = ROOT / "python/examples"


def run_on(log):
    environment = {**os.environ, "DPN_LOG": str(log), "MPLBACKEND": "Agg"}
    done = subprocess.run([sys.executable, EXAMPLES / "noise_of_a_log.py"], capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_source_runs_on_any_log(flight):
    pytest.importorskip("matplotlib")
    said = run_on(flight[0])
    assert "moving" in said and "accelerometer_noise_density" in said


def test_the_source_runs_where_no_network_answers(flight, tmp_path):
    """At a rate that is not the networks', so that nothing is known of what they were trained on."""
    pytest.importorskip("matplotlib")
    header, *rows = (flight[0] / "mav0/imu0/data.csv").read_text().splitlines()
    (tmp_path / "slow.csv").write_text("\n".join([header, *rows[::5]]) + "\n")
    phases = [line.split() for line in run_on(tmp_path / "slow.csv").splitlines() if line.startswith(("all ", "rest ", "moving "))]
    assert len(phases) > 1 and all(phase[-1] == "-" for phase in phases)


def test_the_notebook_runs_in_a_kernel(flight, monkeypatch):
    """As a person who opens it runs it: cell by cell, and no cell ends in an error."""
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    monkeypatch.setenv("DPN_LOG", str(flight[0]))
    notebook = nbformat.read(EXAMPLES / "noise_of_a_log.ipynb", as_version=4)
    nbclient.NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(EXAMPLES)}}).execute()
    said = "".join(out.get("text", "") for cell in notebook.cells for out in cell.get("outputs", []))
    assert "moving" in said and "accelerometer_noise_density" in said


def test_the_notebook_is_the_sources_executed_small_and_without_a_fault():
    pytest.importorskip("nbformat")
    sys.path.insert(0, str(EXAMPLES))
    from make_notebook import cells

    path = EXAMPLES / "noise_of_a_log.ipynb"
    notebook = json.loads(path.read_text())
    assert path.stat().st_size < 300_000
    source = cells((EXAMPLES / "noise_of_a_log.py").read_text())
    assert ["".join(cell["source"]) for cell in notebook["cells"]] == [cell["source"] for cell in source]
    outputs = [out for cell in notebook["cells"] for out in cell.get("outputs", [])]
    assert any("image/svg+xml" in out.get("data", {}) for out in outputs)
    assert not any(out["output_type"] == "error" or out.get("name") == "stderr" for out in outputs)
