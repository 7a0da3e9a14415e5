"""The odometry: :func:`run` and what it leaves."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _dpn
from ._arrays import counts, file_or_json, file_or_keys, listener, matrix, path, poses, seconds, stamps, whole
from ._dpn import Error, Recording


@dataclass(frozen=True)
class Run:
    """A finished run: a row a frame, NaN where the estimator had nothing to say yet. World z up, body = IMU frame, SI.

    ``t_ns`` (f,) int64 stamps of the frames [ns]; ``phase`` f texts ("initialising: ...", "tracking", "restarted");
    ``position`` (f, 3) of the body in the world [m]; ``orientation`` (f, 4) world from body, Hamilton quaternion w x y z;
    ``velocity`` (f, 3) in the world [m/s]; ``accel_bias`` (f, 3) [m/s^2]; ``gyro_bias`` (f, 3) [rad/s];
    ``covariance`` (f, 6, 6) of the newest pose as believed, position then rotation on the right (R <- R Exp(d)), about
    ``anchor``; None unless asked for with ``config={"covariance": True}``;
    ``levels`` (f, 9) by what the noise told is multiplied from the frame on: accelerometer x y z, gyroscope x y z, walks of
    their biases, pixel; None unless learned (``noise="self"``);
    ``whitened`` (f,) squares of the inertial residual that left the window, 9 where the noise is right;
    ``tracked``, ``landmarks``, ``outliers``, ``iterations`` (f,) counts;
    ``noise_t_ns`` (n,) and ``noise`` (n, 6) the deviation in force at every sample, accelerometer [m/s^2] then gyroscope [rad/s];
    ``anchor`` the pose taken for known, (t_ns, position, orientation), or None; ``warnings`` texts;
    ``report`` the dictionary of ``dpn run --json``: ``report["report"]["row"]["ate_se3"]`` is the error [m].
    """

    t_ns: NDArray[np.int64]
    phase: list[str]
    position: NDArray[np.float64]
    orientation: NDArray[np.float64]
    velocity: NDArray[np.float64]
    accel_bias: NDArray[np.float64]
    gyro_bias: NDArray[np.float64]
    covariance: NDArray[np.float64] | None
    levels: NDArray[np.float64] | None
    whitened: NDArray[np.float64]
    tracked: NDArray[np.int64]
    landmarks: NDArray[np.int64]
    outliers: NDArray[np.int64]
    iterations: NDArray[np.int64]
    noise_t_ns: NDArray[np.int64]
    noise: NDArray[np.float64]
    anchor: tuple[int, list[float], list[float]] | None
    warnings: list[str]
    report: dict[str, Any]

    @property
    def known(self) -> NDArray[np.bool_]:
        """(f,) whether the frame has a pose."""
        return ~np.isnan(self.position[:, 0])

    @property
    def ate(self) -> float | None:
        """Absolute trajectory error after the best rigid motion [m], where the truth is known."""
        error: float | None = self.report["report"]["row"]["ate_se3"]
        return error

    @property
    def restarts(self) -> int:
        """How often it was given up and began again."""
        return int(self.report["report"]["row"]["restarts"])

    @property
    def trajectory(self) -> NDArray[np.float64]:
        """(n, 8) the poses there are, as a TUM file has them: t [s], x y z [m], qx qy qz qw."""
        known = self.known
        t = self.t_ns[known] * 1e-9
        return np.column_stack([t, self.position[known], self.orientation[known][:, [1, 2, 3, 0]]])


def _tracks(value: Any) -> tuple[NDArray[np.int64], NDArray[np.uint64], NDArray[np.float64]]:
    """(t, ids, px) of observations in increasing time, no id twice in a frame."""
    try:
        t, ids, px = value
    except (TypeError, ValueError):
        raise Error("tracks: expected (t, ids, px) with a row an observation, or a file where `log` is a folder") from None
    t_ns = stamps("tracks[0]", t, repeated=True)
    found = counts("tracks[1]", ids, len(t_ns))
    px = matrix("tracks[2]", px, 2, len(t_ns))
    order = np.lexsort((found, t_ns))
    twice = np.flatnonzero((np.diff(t_ns[order]) == 0) & (np.diff(found[order]) == 0))
    if twice.size:
        at = order[twice[0] + 1]
        raise Error(f"tracks[1]: id {found[at]} twice in the frame of {t_ns[at]} ns; expected each at most once a frame")
    return t_ns, found, px


def asked(noise: Any, calibration: Any, config: Any, models: Any, seed: Any) -> dict[str, Any]:
    """What every run is told, as the compiled half takes it."""
    if not isinstance(noise, str):
        raise Error(f"noise: {type(noise).__name__}; expected a spec as \"self\", \"x4\" or 'file(\"noise.csv\")'")
    given, as_json = (None, None) if calibration is None else file_or_json("calibration", calibration)
    file, sets = file_or_keys("config", config)
    return {
        "noise": noise, "config": file, "sets": sets, "calibration": given, "calibration_json": as_json,
        "models": None if models is None else path("models", models), "seed": whole("seed", seed, 0, 2**64 - 1),
        "start": "0", "end": None, "progress": None,
    }


def run(
    log: Recording | str | os.PathLike[str],
    noise: str = "self",
    *,
    tracks: Any = None,
    calibration: Mapping[str, Any] | str | os.PathLike[str] | None = None,
    truth: Any = None,
    camera: str | None = None,
    config: Mapping[str, Any] | str | os.PathLike[str] | None = None,
    models: str | os.PathLike[str] | None = None,
    seed: int = 0,
    start: float | str = 0.0,
    end: float | None = None,
    skip_missing: bool = False,
    topic: str | None = None,
    image_topic: str | None = None,
    name: str = "arrays",
    progress: Callable[[float, float], object] | None = None,
) -> Run:
    """Runs the odometry: the numbers of ``dpn run --json``.

    ``log``: a folder with an ASL sequence, a log with images (rosbag1, MCAP, rosbag2, a folder with
    times.txt), the name of a flight; or a :class:`Recording` with ``tracks`` and ``calibration``.
    ``noise``: where every sample's noise comes from: ``"self"`` (the odometry estimates
    it while it runs), ``"x4"``, ``"dualpronet"``, ``'file("noise.csv")'``, ...
    ``tracks``: of a recording (t, ids, px), a row an observation: ``t`` (m,) its frame's stamp, int64 ns or float s on the
    IMU's clock, not falling; ``ids`` (m,) the same number for the same point; ``px`` (m, 2) distorted pixels. Of a folder the
    file of tracks; without it its images, else tracks made along the ground truth.
    ``calibration``: of the camera, a file or its dictionary (Kalibr, OpenVINS, VINS, ORB-SLAM3, Basalt, OKVIS2, ASL), instead
    of the one beside the images.
    ``truth``: of a recording (t, position, orientation) as for :func:`dpn.metrics.ate`; of a folder one with reconciled truth.
    ``camera``: ``"tracks"``, ``"images"`` or ``"rendered"``. ``config``: the estimator's settings, a TOML file or a dictionary
    (``{"window": {"key_frames": 8}}`` or ``{"window.key_frames": 8}``). ``models``: folder of networks of your own.
    ``start``, ``end``: seconds after the first frame; ``"table"`` starts as the paper's comparison does.
    ``skip_missing``, ``topic``, ``image_topic``: how images are read. ``name``: what arrays are called; a file's
    stem gives the file's numbers where chance is in them.
    ``progress(done, total)`` is called after every frame with seconds of the recording; an exception in it ends the run, as
    Ctrl-C does. The GIL is released.

    Raises :class:`Error`: what cannot be read or run, naming the argument and what was expected.
    """
    listener(progress)
    told = asked(noise, calibration, config, models, seed)
    told.update(start=str(start), end=None if end is None else seconds("end", end), progress=progress)
    if isinstance(log, Recording):
        of_paths = {"camera": camera, "topic": topic, "image_topic": image_topic, "skip_missing": skip_missing or None}
        for argument, value in of_paths.items():
            if value is not None:
                raise Error(f"{argument}: {value!r}; expected none where `log` is a Recording")
        if calibration is None:
            raise Error("calibration: None; expected a file or a dictionary: nobody knows what camera the tracks are from")
        known = None if truth is None else poses("truth", truth)
        found = _dpn.run_arrays(told, name, log, *_tracks(tracks), known)
    else:
        source = path("log", log, "a dpn.Recording, a path or the name of a flight")
        file_of = {"tracks": tracks, "truth": truth}
        for argument, value in file_of.items():
            file_of[argument] = None if value is None else path(argument, value, "a path, as `log` is one")
        found = _dpn.run_source(
            told, source, camera, file_of["tracks"], file_of["truth"], bool(skip_missing), topic, image_topic
        )
    found["report"] = json.loads(found["report"])
    return Run(**found)
