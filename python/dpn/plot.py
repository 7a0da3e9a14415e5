"""Five pictures, by matplotlib (``pip install matplotlib``): each function gives a ``matplotlib.figure.Figure`` and shows nothing.

>>> dpn.plot.noise(dpn.noise(log)).savefig("noise.svg")     # doctest: +SKIP
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._arrays import poses
from ._dpn import Error, Recording, read
from ._results import Allan
from ._run import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from . import NoiseTrack

__all__ = ["allan", "noise", "spectrum", "states", "trajectory"]

_SENSORS = (("accelerometer", "m/s²"), ("gyroscope", "rad/s"))
# No line has more points: an SVG of an hour would be a gigabyte.
_MOST = 4000


def _figure(rows: int, columns: int = 1, **how: Any) -> tuple[Figure, Any]:
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise Error("matplotlib is not there; pip install matplotlib") from None
    figure = Figure(figsize=(9, 2.5 * max(rows, 2)), layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **how)


def _asked(name: str, value: Any, kind: type, expected: str) -> Any:
    if not isinstance(value, kind):
        raise Error(f"{name}: {type(value).__name__}; expected {expected}")
    return value


def _lines(axis: Axes, t: NDArray[Any], rows: NDArray[np.float64], title: str, unit: str) -> None:
    thin = slice(None, None, max(1, len(t) // _MOST))
    for letter, line in zip("xyz", rows.T):
        axis.plot(t[thin], line[thin], lw=0.9, label=letter)
    axis.set_ylabel(f"{title} [{unit}]", fontsize=8)


def trajectory(run: Run, truth: Any = None) -> Figure:
    """The path from above and its height over time. ``truth``: (t, position, orientation) as for :func:`dpn.metrics.ate`, drawn beside
    it; where it begins the estimate is laid on it, position and heading."""
    run = _asked("run", run, Run, "a dpn.Run")
    known = run.known
    t, path = run.t_ns[known], run.position[known]
    if len(t) == 0:
        raise Error("run: has no pose; expected one at least (run.phase says what was waited for)")
    figure, ((above, height),) = _figure(1, 2)
    if truth is not None:
        true_t, true = poses("truth", truth)
        inside = (t >= true_t[0]) & (t <= true_t[-1])
        if inside.sum() < 2:
            raise Error("truth: none at the poses' times; expected both on one clock")
        at = np.stack([np.interp(t[inside], true_t, true[:, k]) for k in range(3)], axis=1)
        middle, true_middle = path[inside].mean(axis=0), at.mean(axis=0)
        # The heading that brings the centred paths nearest to each other.
        own, other = (path[inside] - middle) @ [1, 1j, 0], (at - true_middle) @ [1, 1j, 0]
        turned = np.exp(1j * np.angle(np.vdot(own, other)))
        flat = (path - middle) @ [1, 1j, 0] * turned
        path = np.stack([flat.real, flat.imag, path[:, 2] - middle[2]], axis=1) + true_middle
        shown = (true_t >= t[0]) & (true_t <= t[-1])
        above.plot(*true[shown, :2].T, lw=0.9, color="0.5", label="truth")
        height.plot((true_t[shown] - t[0]) * 1e-9, true[shown, 2], lw=0.9, color="0.5")
    above.plot(path[:, 0], path[:, 1], lw=1.1, label="estimate")
    above.plot(*path[0, :2], "o", ms=4, color="black", label="begin")
    above.set_aspect("equal", "datalim")
    above.set_xlabel("x [m]")
    above.set_ylabel("y [m]")
    above.legend(fontsize=8)
    height.plot((t - t[0]) * 1e-9, path[:, 2], lw=1.1)
    height.set_xlabel("time [s]")
    height.set_ylabel("z [m]")
    return figure


def noise(track: NoiseTrack) -> Figure:
    """The noise along a log, by :func:`dpn.noise`; grey where the signal is unlike all that the networks were trained on."""
    from . import NoiseTrack

    track = _asked("track", track, NoiseTrack, "a dpn.NoiseTrack, as dpn.noise gives it")
    figure, axes = _figure(2, sharex=True)
    for axis, sigma, (sensor, unit) in zip(axes[:, 0], (track.accel, track.gyro), _SENSORS):
        _lines(axis, track.t, sigma, sensor, unit)
        axis.set_yscale("log")
        axis.fill_between(track.t, 0, 1, where=~track.in_range, transform=axis.get_xaxis_transform(), color="0.9", lw=0)
    axes[0, 0].set_title(f"standard deviation of a sample, by {track.model}", fontsize=9)
    axes[0, 0].legend(ncols=3, fontsize=8)
    axes[1, 0].set_xlabel("time [s]")
    return figure


def spectrum(log: Recording | str | os.PathLike[str]) -> Figure:
    """The root of the power spectral density of each axis (Welch, windows of some 4 s): white noise is level, at its density."""
    log = read(log) if isinstance(log, (str, os.PathLike)) else _asked("log", log, Recording, "a dpn.Recording or a path")
    figure, axes = _figure(2, sharex=True)
    from matplotlib.mlab import psd

    window = min(len(log), 2 ** max(4, round(np.log2(4 * log.rate))))
    for axis, values, (sensor, unit) in zip(axes[:, 0], (log.accel, log.gyro), _SENSORS):
        for letter, signal in zip("xyz", values.T):
            density, hz = map(np.asarray, psd(signal, NFFT=window, Fs=log.rate, noverlap=window // 2, detrend="linear"))
            axis.loglog(hz[1:], np.sqrt(density[1:]), lw=0.9, label=letter)
        axis.set_ylabel(f"{sensor} [{unit}/√Hz]", fontsize=8)
    axes[0, 0].legend(ncols=3, fontsize=8)
    axes[1, 0].set_xlabel("frequency [Hz]")
    return figure


def allan(found: Allan) -> Figure:
    """The Allan deviations of :func:`dpn.allan` with their 95 % intervals; dashed the model that is fitted."""
    found = _asked("found", found, Allan, "a dpn.Allan")
    figure, axes = _figure(2, sharex=True)
    for axis, plots, (sensor, unit) in zip(axes[:, 0], (found.axes[:3], found.axes[3:]), _SENSORS):
        for plot in plots:
            (line,) = axis.loglog(plot.tau, plot.deviation, lw=1.1, label=plot.axis)
            axis.fill_between(plot.tau, plot.low, plot.high, alpha=0.15, lw=0, color=line.get_color())
            axis.loglog(plot.tau, plot.model, lw=0.8, ls="--", color=line.get_color())
        axis.set_ylabel(f"{sensor} [{unit}]", fontsize=8)
    axes[0, 0].legend(ncols=3, fontsize=8)
    axes[1, 0].set_xlabel("averaging time [s]")
    return figure


def states(run: Run) -> Figure:
    """Velocity and biases of a run over time; where its noise was learned, the levels too."""
    run = _asked("run", run, Run, "a dpn.Run")
    t = (run.t_ns - run.t_ns[:1]) * 1e-9
    rows = [("velocity", run.velocity, "m/s"), ("accelerometer's bias", run.accel_bias, "m/s²"), ("gyroscope's bias", run.gyro_bias, "rad/s")]
    if run.levels is not None:
        rows += [("accelerometer's level", run.levels[:, :3], "-"), ("gyroscope's level", run.levels[:, 3:6], "-")]
    figure, axes = _figure(len(rows), sharex=True)
    for axis, (title, values, unit) in zip(axes[:, 0], rows):
        _lines(axis, t, values, title, unit)
    axes[0, 0].legend(ncols=3, fontsize=8)
    axes[-1, 0].set_xlabel("time [s]")
    return figure
