"""How noisy an IMU is, from Python: logs into arrays, noise tracks, Allan deviations, findings, networks, the odometry.

SI units and radians; stamps are integer nanoseconds (``t_ns``) beside seconds since the first sample (``t``). Arrays are
numpy's, C order; what comes in in another order or as another real type is copied once. Accelerometer first where six
columns hold both sensors. Every fault of what was given is a :class:`Error` that names the argument and what was expected.

>>> import dpn
>>> log = dpn.read("flight.bag")            # doctest: +SKIP
>>> track = dpn.noise(log)                  # doctest: +SKIP
>>> track.accel[-1]                         # m/s^2, standard deviation per sample    # doctest: +SKIP
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _dpn, metrics, plot
from ._arrays import matrix, stamps, whole
from ._dpn import Error, Recording, __version__, read
from ._frames import frame
from ._networks import Correction, GyroBias, Network, Sigma, Stream, Training, train
from ._odometry import Image, Noise, Odometry, Sample, Update, sensors
from ._results import Allan, AllanAxis, Check, Coefficient, Converted, Figures, Finding, Phase
from ._run import Run, run

_dpn.code_is_in(_dpn.__file__)

__all__ = [
    "Allan", "AllanAxis", "Check", "Coefficient", "Converted", "Correction", "Error", "Figures", "Finding", "Flight", "GyroBias", "Image", "Network", "Noise",
    "NoiseTrack", "Odometry", "Phase", "Recording", "Run", "Sample", "Sigma", "Stream", "Training", "Update", "__version__", "allan", "check", "convert",
    "frame", "metrics", "noise", "plot", "read", "recording", "run", "sensors", "simulate", "train",
]


def recording(t: ArrayLike, gyro: ArrayLike, accel: ArrayLike) -> Recording:
    """A recording of arrays.

    Shapes: ``t`` (n,), int64 nanoseconds or float seconds; ``gyro`` (n, 3) rad/s; ``accel`` (n, 3) m/s^2, body frame,
    +9.81 on the axis that points up at rest. n is at least 2. The samples are copied.

    Raises :class:`Error`: another shape or type, NaN or infinity, stamps that do not increase.
    """
    t_ns = stamps("t", t)
    return _dpn.from_arrays(t_ns, matrix("gyro", gyro, 3, len(t_ns)), matrix("accel", accel, 3, len(t_ns)))


def _recording(log: Recording | str | os.PathLike[str]) -> Recording:
    if isinstance(log, Recording):
        return log
    if isinstance(log, (str, os.PathLike)):
        return read(log)
    raise Error(f"log: {type(log).__name__}; expected a dpn.Recording or a path")


@dataclass(frozen=True)
class NoiseTrack:
    """The noise along a log, one row an answer.

    ``t_ns`` (n,) int64 stamps [ns]; ``sigma`` (n, 6) standard deviations per sample: accelerometer x y z [m/s^2],
    gyroscope x y z [rad/s]; ``windows`` and ``outside`` (n, 2) counts for accelerometer and gyroscope since the row before:
    windows the networks judged, and those of them unlike all of the training (zeros for simple estimators);
    ``summary`` the figures of ``dpn noise --json``.
    """

    t_ns: NDArray[np.int64]
    sigma: NDArray[np.float64]
    windows: NDArray[np.uint64]
    outside: NDArray[np.uint64]
    summary: dict[str, Any]

    @property
    def t(self) -> NDArray[np.float64]:
        """(n,) seconds since the first row."""
        seconds: NDArray[np.float64] = (self.t_ns - self.t_ns[0]) * 1e-9
        return seconds

    @property
    def accel(self) -> NDArray[np.float64]:
        """(n, 3) accelerometer [m/s^2], a view."""
        return self.sigma[:, :3]

    @property
    def gyro(self) -> NDArray[np.float64]:
        """(n, 3) gyroscope [rad/s], a view."""
        return self.sigma[:, 3:]

    @property
    def in_range(self) -> NDArray[np.bool_]:
        """(n,) whether no window since the row before was outside the training."""
        inside: NDArray[np.bool_] = np.logical_not(self.outside.any(axis=1))
        return inside

    @property
    def model(self) -> str:
        """Who was asked, as a spec."""
        return str(self.summary["noise"])

    @property
    def phases(self) -> list[Phase]:
        """At rest, moving, and altogether; those that there are."""
        found = []
        for part in self.summary["summary"]["phases"]:
            middle = np.array([axis["sigma"]["middle"] for axis in part["axes"]])
            found.append(Phase(part["phase"] or "all", part["seconds"], middle[:3], middle[3:]))
        return found


def noise(
    log: Recording | str | os.PathLike[str],
    model: str | None = None,
    *,
    every: int = 10,
    weights: str | os.PathLike[str] | None = None,
) -> NoiseTrack:
    """The noise along ``log`` (a :class:`Recording` or a path), as ``dpn noise`` finds it.

    ``model``: a spec as on the command line (``"dualpronet"``, ``"diff2"``, ``"sg(11,2)"``, ``"x2"``); without it the shipped
    networks, or ``diff2`` where the log's rate is not theirs (``summary["noise"]`` says which). ``every``: samples from one
    answer to the next. ``weights``: folder of networks of your own. The GIL is released.

    Raises :class:`Error`: an unknown or non-causal spec, a rate the networks do not know, a log shorter than a window.
    """
    t_ns, sigma, windows, outside, summary = _dpn.noise(_recording(log), model, whole("every", every, 1, 1_000_000), weights)
    return NoiseTrack(t_ns, sigma, windows, outside, json.loads(summary))


def allan(log: Recording | str | os.PathLike[str], *, all: bool = False) -> Allan:
    """Allan deviation of ``log``'s longest stretch at rest, or with ``all`` of the whole, as ``dpn allan``. The GIL is released.

    Raises :class:`Error`: not at rest, too short.
    """
    return Allan.of(json.loads(_dpn.allan(_recording(log), all)))


def check(log: Recording | str | os.PathLike[str]) -> Check:
    """What is wrong with ``log``, as ``dpn check`` finds it."""
    return Check.of(json.loads(_dpn.check(_recording(log))))


def convert(
    path: str | os.PathLike[str],
    to: str,
    *,
    from_format: str | None = None,
    rate: float | None = None,
    to_rate: float | None = None,
) -> Converted:
    """One program's noise figures as another's, as ``dpn noise convert``.

    ``path``: YAML or JSON; ``to``, ``from_format``: kalibr, openvins, orbslam3, okvis2, basalt, vins, ros, variances, ...;
    ``rate``, ``to_rate``: Hz.

    Raises :class:`Error`: a file or format that is not known, a rate that is needed and not given.
    """
    found = json.loads(_dpn.convert(path, to, from_format, rate, to_rate))
    return Converted(found["text"], Figures.of(found["figures"]), found["remarks"], found["warnings"], found)


@dataclass(frozen=True)
class Flight:
    """A simulated flight.

    ``recording``; ``sigma`` (n, 6) the deviation each sample's white noise was drawn with, accelerometer [m/s^2] then
    gyroscope [rad/s]; ``position`` (n, 3) of the body in the world [m], z up; ``orientation`` (n, 4) world from body,
    Hamilton quaternion w x y z.
    """

    recording: Recording
    sigma: NDArray[np.float64]
    position: NDArray[np.float64]
    orientation: NDArray[np.float64]


def simulate(flight: str, *, seed: int = 0) -> Flight:
    """Flies ``flight`` (a name of ``dpn simulate flight --list``); the same seed gives the same bits.

    Raises :class:`Error`: a flight that is not known.
    """
    return Flight(*_dpn.simulate(flight, whole("seed", seed, 0, 2**64 - 1)))
