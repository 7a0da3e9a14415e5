"""What the questions to a log answer, as values with names. ``report`` is the dictionary of the command's ``--json`` in each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Finding:
    """Something that a log says: ``weight`` ("fault", "warning", "note"), ``about`` in a word, ``text``, and the ``remedy`` where there is one."""

    weight: str
    about: str
    text: str
    remedy: str | None


@dataclass(frozen=True)
class Check:
    """What is wrong with a log, as ``dpn check`` finds it; ``rate`` [Hz], ``length`` [s]."""

    samples: int
    length: float
    rate: float
    findings: list[Finding]
    report: dict[str, Any]

    @classmethod
    def of(cls, report: dict[str, Any]) -> Check:
        """Of the dictionary."""
        return cls(report["samples"], report["length_s"], report["rate_hz"], [Finding(**found) for found in report["findings"]], report)


@dataclass(frozen=True)
class Figures:
    """Noise as densities at ``rate`` [Hz]: ``accel_white`` [m/s^2/sqrt(Hz)], ``gyro_white`` [rad/s/sqrt(Hz)], ``accel_walk`` [m/s^3/sqrt(Hz)],
    ``gyro_walk`` [rad/s^2/sqrt(Hz)]: (3,), or a number where all axes have one; None where nothing is known."""

    rate: float
    accel_white: NDArray[np.float64] | None
    gyro_white: NDArray[np.float64] | None
    accel_walk: NDArray[np.float64] | None
    gyro_walk: NDArray[np.float64] | None

    @classmethod
    def of(cls, report: Mapping[str, Any]) -> Figures:
        """Of the dictionary."""
        white_and_walk = (report.get(f"{sensor}_{kind}") for kind in ("white", "walk") for sensor in ("accel", "gyro"))
        return cls(report["rate"], *(None if value is None else np.array(value) for value in white_and_walk))


@dataclass(frozen=True)
class Coefficient:
    """A coefficient of an Allan fit with its 95 % interval; ``seen`` whether the log is long enough to tell it."""

    value: float
    low: float
    high: float
    seen: bool


@dataclass(frozen=True)
class AllanAxis:
    """An axis' Allan deviation: over ``tau`` (k,) [s] the ``deviation`` with its 95 % interval ``low`` to ``high`` and the ``model`` fitted, all (k,) in
    the sensor's unit; ``coefficients`` by name."""

    sensor: str
    axis: str
    tau: NDArray[np.float64]
    deviation: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    model: NDArray[np.float64]
    coefficients: dict[str, Coefficient]


@dataclass(frozen=True)
class Allan:
    """The Allan deviations of a log at rest: six ``axes``, accelerometer first, and the ``figures`` that they say."""

    axes: list[AllanAxis]
    figures: Figures
    report: dict[str, Any]

    @classmethod
    def of(cls, report: dict[str, Any]) -> Allan:
        """Of the dictionary."""

        def axis(found: Mapping[str, Any]) -> AllanAxis:
            tau, deviation, low, high, model = (
                np.array([point[key] for point in found["points"]]) for key in ("tau", "deviation", "low", "high", "model")
            )
            fitted = {e["coefficient"]: Coefficient(e["value"], e["low"], e["high"], e["seen"]) for e in found["estimates"]}
            return AllanAxis(found["sensor"], found["axis"], tau, deviation, low, high, model, fitted)

        return cls([axis(found) for found in report["log"]["axes"]], Figures.of(report["figures"]), report)


@dataclass(frozen=True)
class Converted:
    """Noise figures in another program's words: ``text`` is what to paste; ``remarks`` and ``warnings`` texts."""

    text: str
    figures: Figures
    remarks: list[str]
    warnings: list[str]
    report: dict[str, Any]


@dataclass(frozen=True)
class Phase:
    """A part of a log ("rest", "moving"; "all" of it): ``seconds``, and the median deviation of a sample, ``accel`` (3,) [m/s^2] and ``gyro`` (3,) [rad/s]."""

    phase: str
    seconds: float
    accel: NDArray[np.float64]
    gyro: NDArray[np.float64]
