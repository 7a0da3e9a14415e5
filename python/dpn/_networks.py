"""Networks: to ask, to feed sample by sample, to train."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _dpn
from ._arrays import file_or_keys, listener, matrix, path, seconds, stamp, vector, whole
from ._dpn import Error, Recording


class Network:
    """A trained network of one sensor: ``sensor`` ("accel" or "gyro"), ``tag``, ``rate`` [Hz], ``window`` [samples]."""

    def __init__(self, inner: _dpn.Network) -> None:
        self._inner = inner
        self.sensor, self.tag, self.rate, self.window = inner.sensor, inner.tag, inner.rate, inner.window

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Network:
        """Of a ``.safetensors`` file. Raises :class:`Error` where it is no network."""
        return cls(_dpn.Network.load(path))

    @classmethod
    def shipped(cls) -> list[Network]:
        """Those that come with the package."""
        return [cls(inner) for inner in _dpn.Network.shipped()]

    @classmethod
    def default(cls, sensor: str) -> Network:
        """The shipped one that ``"dualpronet"`` asks of ``sensor``."""
        for network in cls.shipped():
            if (network.sensor, network.tag) == (sensor, _dpn.DEFAULT_TAG):
                return network
        raise Error(f"sensor: {sensor!r}; known are accel, gyro")

    def predict(self, windows: ArrayLike) -> NDArray[np.float32]:
        """The deviation of each window.

        Shapes: ``windows`` (b, window) of one axis, m/s^2 or rad/s, taken as float32; result (b,) float32, the same unit.
        The GIL is released. Raises :class:`Error`: another shape or type, NaN or infinity.
        """
        return self._inner.predict(matrix("windows", windows, self.window, dtype=np.float32))

    def __repr__(self) -> str:
        return repr(self._inner)


class Sigma(NamedTuple):
    """How noisy the IMU is at the newest sample.

    ``accel`` (3,) [m/s^2] and ``gyro`` (3,) [rad/s]: standard deviations of one sample, x y z. ``known``: False until the
    first full window, the deviations are VINS-Mono's constants then. ``accel_in_range``, ``gyro_in_range``: False where the
    last window was unlike all of the training, the deviations are extrapolated then. ``rate_fits``: False while samples come
    at a rate more than 5 % off the networks'; nothing is resampled. ``accel_agrees``, ``gyro_agrees``: False where the spectrum
    of the last half to whole minute says another noise, as behind a low pass: what is said is then not known to be the noise.
    """

    accel: NDArray[np.float64]
    gyro: NDArray[np.float64]
    known: bool
    accel_in_range: bool
    gyro_in_range: bool
    rate_fits: bool
    accel_agrees: bool
    gyro_agrees: bool


class Stream:
    """The noise beside running samples: feed each, ask when the answer is needed.

    ``accel``, ``gyro``: networks, without them the shipped ones, at their own rate; ``every``: samples from one question to the next (10: a
    camera's frame at 20 Hz). With ``rate`` [Hz] samples may come at any: ``model`` is asked, a spec as for :func:`dpn.noise`, without one what
    :func:`dpn.noise` asks at that rate (networks see averages over blocks). The same samples give the answers of :func:`dpn.noise`.

    Raises :class:`Error`: two networks that are no pair; a model that is none, or that the rate is too low for.
    """

    def __init__(
        self, accel: Network | None = None, gyro: Network | None = None, *, every: int = 10, rate: float | None = None, model: str | None = None
    ) -> None:
        every = whole("every", every, 1, 1_000_000)
        if rate is not None:
            if accel is not None or gyro is not None:
                raise Error("rate: with networks; expected a `model` beside it, as \"dualpronet\"")
            if not seconds("rate", rate) > 0:
                raise Error("rate: 0; expected more, in Hz")
            self._inner = _dpn.Stream.at_rate(model, float(rate), every)
            return
        if model is not None:
            raise Error("model: without a rate; expected `rate` beside it, in Hz")
        pair = []
        for sensor, given in (("accel", accel), ("gyro", gyro)):
            if given is not None and not isinstance(given, Network):
                raise Error(f"{sensor}: {type(given).__name__}; expected a dpn.Network")
            pair.append((given or Network.default(sensor))._inner)
        self._inner = _dpn.Stream.of_networks(pair[0], pair[1], every)

    def feed(self, t: float, gyro: ArrayLike, accel: ArrayLike) -> None:
        """Takes a sample: ``t`` int ns or float s, later than the last; ``gyro`` (3,) rad/s; ``accel`` (3,) m/s^2.

        Raises :class:`Error` where it is not taken; nothing has changed then.
        """
        self._inner.feed(stamp("t", t), vector("gyro", gyro), vector("accel", accel))

    def sigma(self) -> Sigma:
        """How noisy the IMU is at the newest sample."""
        accel, gyro, known, (accel_out, gyro_out), wrong_rate, (accel_against, gyro_against) = self._inner.sigma()
        ranges = (not accel_out, not gyro_out, not wrong_rate)
        return Sigma(np.array(accel), np.array(gyro), known, *ranges, not accel_against, not gyro_against)


class Correction(NamedTuple):
    """What takes a reading of the gyroscope to a rate: ``matrix @ reading + bias``, as it holds at the newest sample.

    ``matrix`` (3, 3), ``bias`` (3,) [rad/s]: slow; give it to an estimator as its bias, with its ``deviation`` (3,) [rad/s], and correct no
    sample by anything quicker.
    ``known``: False until the network has seen as much past as it looks at, the bias is the calibration's then. ``rate_fits``: False
    while samples come at a rate more than 5 % off the network's; nothing is resampled.
    """

    matrix: NDArray[np.float64]
    bias: NDArray[np.float64]
    deviation: NDArray[np.float64]
    known: bool
    rate_fits: bool


class GyroBias:
    """A gyroscope's bias beside running samples, by a network of ``dpn train --model inertial`` of this very IMU (``network.safetensors``).

    Raises :class:`Error` where the file is none.
    """

    def __init__(self, network: str | os.PathLike[str]) -> None:
        self._inner = _dpn.GyroBias(path("network", network, "a file"))

    def feed(self, t: float, gyro: ArrayLike, accel: ArrayLike) -> None:
        """Takes a sample, as :meth:`Stream.feed` does."""
        self._inner.feed(stamp("t", t), vector("gyro", gyro), vector("accel", accel))

    def correction(self) -> Correction:
        """What holds at the newest sample."""
        matrix, bias, deviation, known, rate_fits = self._inner.correction()
        return Correction(np.array(matrix), np.array(bias), np.array(deviation), known, rate_fits)


class Training(NamedTuple):
    """A finished training: the network, its file, and the summary of ``dpn train --json``."""

    network: Network
    path: str
    summary: dict[str, Any]


def train(
    data: Recording | Mapping[str, Recording] | str | os.PathLike[str],
    sensor: str,
    out: str | os.PathLike[str],
    *,
    config: Mapping[str, Any] | str | os.PathLike[str] | None = None,
    resume: bool = False,
    progress: Callable[[float, float], object] | None = None,
) -> Training:
    """Trains the network of ``sensor`` ("accel" or "gyro"), as ``dpn train`` does.

    ``data``: a folder of sequences as for ``dpn train --data``; or a recording, or a dictionary of them by name, all learned
    from, the last 15 % of each to validate on; 200 Hz. ``out``: the run's folder (checkpoint, history, weights).
    ``config``: a TOML file or a dictionary (``{"fit": {"epochs": 20}, "seed": 1}``); the rest is the sensor's default.
    ``resume``: goes on with the run that stands in ``out``. ``progress(done, total)`` is called after every step; an exception
    in it ends the training, as Ctrl-C does, and the epochs before are kept. The GIL is released.

    Raises :class:`Error`: data that do not serve, a configuration that is none, a run that stands in ``out`` already.
    """
    listener(progress)
    file, keys = file_or_keys("config", config)
    folder, named = None, []
    if isinstance(data, Recording):
        named = [("log", data)]
    elif isinstance(data, Mapping):
        if not data:
            raise Error("data: expected a recording or more, found none")
        for name, entry in data.items():
            if not isinstance(entry, Recording):
                raise Error(f"data[{name!r}]: {type(entry).__name__}; expected a dpn.Recording")
            named.append((str(name), entry))
    else:
        folder = path("data", data, "a folder, a dpn.Recording or a dictionary of them")
    text = "\n".join(f"{key} = {value}" for key, value in keys)
    weights, summary = _dpn.train(folder, named, sensor, path("out", out), file, text, bool(resume), progress)
    return Training(Network.load(weights), os.fspath(weights), json.loads(summary))
