"""How noisy an IMU is, from Python: logs into arrays, noise tracks, Allan deviations, findings.

SI units and radians; stamps are integer nanoseconds (``t_ns``) beside seconds since the first sample (``t``). Arrays are
numpy's, C order; what comes in in another order or as another real type is copied once. Accelerometer first where six
columns hold both sensors. Every fault of what was given is a :class:`Error` that names the argument and what was expected.

>>> import dpn
>>> log = dpn.read("flight.bag")            # doctest: +SKIP
>>> track = dpn.noise(log)                  # doctest: +SKIP
>>> track.accel[-1]                         # m/s^2, standard deviation per sample    # doctest: +SKIP
"""

import json
import os
from dataclasses import dataclass

import numpy as np

from . import _dpn, metrics
from ._arrays import matrix, stamps, whole
from ._dpn import Error, Recording, __version__, read
from ._run import Run, run

__all__ = [
    "Error", "Flight", "Network", "NoiseTrack", "Recording", "Run", "__version__",
    "allan", "check", "convert", "metrics", "noise", "read", "recording", "run", "simulate",
]


def recording(t, gyro, accel) -> Recording:
    """A recording of arrays.

    Shapes: ``t`` (n,), int64 nanoseconds or float seconds; ``gyro`` (n, 3) rad/s; ``accel`` (n, 3) m/s^2, body frame,
    +9.81 on the axis that points up at rest. n is at least 2. The samples are copied.

    Raises :class:`Error`: another shape or type, NaN or infinity, stamps that do not increase.
    """
    t_ns = stamps("t", t)
    return _dpn.from_arrays(t_ns, matrix("gyro", gyro, 3, len(t_ns)), matrix("accel", accel, 3, len(t_ns)))


def _recording(log) -> Recording:
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

    t_ns: np.ndarray
    sigma: np.ndarray
    windows: np.ndarray
    outside: np.ndarray
    summary: dict

    @property
    def t(self) -> np.ndarray:
        """(n,) seconds since the first row."""
        return (self.t_ns - self.t_ns[0]) * 1e-9

    @property
    def accel(self) -> np.ndarray:
        """(n, 3) accelerometer [m/s^2], a view."""
        return self.sigma[:, :3]

    @property
    def gyro(self) -> np.ndarray:
        """(n, 3) gyroscope [rad/s], a view."""
        return self.sigma[:, 3:]

    @property
    def in_range(self) -> np.ndarray:
        """(n,) whether no window since the row before was outside the training."""
        return ~self.outside.any(axis=1)


def noise(log, model=None, *, every=10, weights=None) -> NoiseTrack:
    """The noise along ``log`` (a :class:`Recording` or a path), as ``dpn noise`` finds it.

    ``model``: a spec as on the command line (``"dualpronet"``, ``"diff2"``, ``"sg(11,2)"``, ``"x2"``); without it the shipped
    networks, or ``diff2`` where the log's rate is not theirs (``summary["noise"]`` says which). ``every``: samples from one
    answer to the next. ``weights``: folder of networks of your own. The GIL is released.

    Raises :class:`Error`: an unknown or non-causal spec, a rate the networks do not know, a log shorter than a window.
    """
    t_ns, sigma, windows, outside, summary = _dpn.noise(_recording(log), model, whole("every", every, 1, 1_000_000), weights)
    return NoiseTrack(t_ns, sigma, windows, outside, json.loads(summary))


def allan(log, *, all=False) -> dict:
    """Allan deviation of ``log``'s longest stretch at rest, or with ``all`` of the whole, as ``dpn allan --json``.

    Keys: ``log`` (axes with deviations, their intervals and fitted coefficients), ``figures`` (densities and walks, SI).
    The GIL is released.

    Raises :class:`Error`: not at rest, too short.
    """
    return json.loads(_dpn.allan(_recording(log), all))


def check(log) -> dict:
    """What is wrong with ``log``, as ``dpn check --json``: ``findings`` with ``weight``, ``about``, ``text``, ``remedy``, and more."""
    return json.loads(_dpn.check(_recording(log)))


def convert(path, to, *, from_format=None, rate=None, to_rate=None) -> dict:
    """One program's noise figures as another's, as ``dpn noise convert --json``.

    ``path``: YAML or JSON; ``to``, ``from_format``: kalibr, openvins, orbslam3, okvis2, basalt, vins, ros, variances, ...;
    ``rate``, ``to_rate``: Hz. ``text`` of the result is what to paste, ``steps`` the arithmetic.

    Raises :class:`Error`: a file or format that is not known, a rate that is needed and not given.
    """
    return json.loads(_dpn.convert(path, to, from_format, rate, to_rate))


@dataclass(frozen=True)
class Flight:
    """A simulated flight.

    ``recording``; ``sigma`` (n, 6) the deviation each sample's white noise was drawn with, accelerometer [m/s^2] then
    gyroscope [rad/s]; ``position`` (n, 3) of the body in the world [m], z up; ``orientation`` (n, 4) world from body,
    Hamilton quaternion w x y z.
    """

    recording: Recording
    sigma: np.ndarray
    position: np.ndarray
    orientation: np.ndarray


def simulate(flight, *, seed=0) -> Flight:
    """Flies ``flight`` (a name of ``dpn simulate flight --list``); the same seed gives the same bits.

    Raises :class:`Error`: a flight that is not known.
    """
    return Flight(*_dpn.simulate(flight, seed))


class Network:
    """A trained network of one sensor: ``sensor`` ("accel" or "gyro"), ``tag``, ``rate`` [Hz], ``window`` [samples]."""

    def __init__(self, inner):
        self._inner = inner
        self.sensor, self.tag, self.rate, self.window = inner.sensor, inner.tag, inner.rate, inner.window

    @classmethod
    def load(cls, path) -> "Network":
        """Of a ``.safetensors`` file. Raises :class:`Error` where it is no network."""
        return cls(_dpn.Network.load(path))

    @classmethod
    def shipped(cls) -> "list[Network]":
        """Those that come with the package."""
        return [cls(inner) for inner in _dpn.Network.shipped()]

    def predict(self, windows) -> np.ndarray:
        """The deviation of each window.

        Shapes: ``windows`` (b, window) of one axis, m/s^2 or rad/s, taken as float32; result (b,) float32, the same unit.
        The GIL is released. Raises :class:`Error`: another shape or type, NaN or infinity.
        """
        return self._inner.predict(matrix("windows", windows, self.window, dtype=np.float32))

    def __repr__(self):
        return repr(self._inner)
