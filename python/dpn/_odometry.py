"""The odometry beside running sensors: :class:`Odometry` and what it says."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
import warnings
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _dpn
from ._arrays import array, counts, grey, matrix, path, stamp, stamps, whole
from ._dpn import Error
from ._run import asked


@dataclass(frozen=True)
class Update:
    """What came of a frame. World z up, body = IMU frame, SI; None where nothing is known.

    ``t_ns`` the frame's stamp on the IMU's clock [ns]; ``phase`` "initialising", "tracking" or "restarted"; ``waits_for`` why, where
    it is not tracking; ``position`` (3,) of the body in the world [m]; ``orientation`` (4,) world from body, Hamilton quaternion
    w x y z; ``velocity`` (3,) in the world [m/s]; ``accel_bias`` (3,) [m/s^2]; ``gyro_bias`` (3,) [rad/s]; ``covariance`` (6, 6) of
    the pose as believed, position then rotation on the right, with ``config={"covariance": True}``; ``levels`` (9,) by what the noise
    told is multiplied from here on (accelerometer, gyroscope, walks of their biases, pixel), where it is learned; ``scale_std`` the
    relative deviation of the scale; ``tracked``, ``landmarks`` counts.
    """

    t_ns: int
    phase: str
    waits_for: str | None
    position: NDArray[np.float64] | None
    orientation: NDArray[np.float64] | None
    velocity: NDArray[np.float64] | None
    accel_bias: NDArray[np.float64] | None
    gyro_bias: NDArray[np.float64] | None
    covariance: NDArray[np.float64] | None
    levels: NDArray[np.float64] | None
    scale_std: float | None
    tracked: int
    landmarks: int

    @property
    def known(self) -> bool:
        """Whether the frame has a pose."""
        return self.position is not None


class Sample(NamedTuple):
    """A sample of a bag: ``t_ns``, ``gyro`` (3,) [rad/s], ``accel`` (3,) [m/s^2]."""

    t_ns: int
    gyro: NDArray[np.float64]
    accel: NDArray[np.float64]


class Image(NamedTuple):
    """An image of a bag: the camera's stamp ``t_ns``, and ``pixels`` (height, width) of uint8, grey."""

    t_ns: int
    pixels: NDArray[np.uint8]


def sensors(
    bag: str | os.PathLike[str],
    calibration: str | os.PathLike[str] | None = None,
    *,
    size: tuple[int, int] | None = None,
    topic: str | None = None,
    image_topic: str | None = None,
) -> Iterator[Sample | Image]:
    """What a bag's IMU and camera say, in the order in which they were recorded: :class:`Sample` and :class:`Image`, ready for :class:`Odometry`.

    ``bag``: rosbag1, MCAP or rosbag2. The images' ``size`` (width, height) is given, or the file of a ``calibration`` that says it; ``topic`` and
    ``image_topic`` choose where there are several. It is read on a thread, a few messages ahead. What is passed over is a :class:`UserWarning`.

    Raises :class:`Error`: no bag, no size, several topics and no choice.
    """
    if (calibration is None) == (size is None):
        raise Error("size: expected (width, height), or a file of a calibration instead")
    sides = None if size is None else (whole("size[0]", size[0], 1, 65535), whole("size[1]", size[1], 1, 65535))
    inner = _dpn.Sensors(path("bag", bag), None if calibration is None else path("calibration", calibration), sides, topic, image_topic)

    def each() -> Iterator[Sample | Image]:
        while (said := inner.next()) is not None:
            if isinstance(said, str):
                warnings.warn(said, stacklevel=2)
            else:
                yield Sample(*said) if len(said) == 3 else Image(*said)

    return each()


@dataclass(frozen=True)
class Noise:
    """The IMU's noise in force: what was told times what was learned.

    ``rate`` [Hz]; ``accel`` (3,) [m/s^2] and ``gyro`` (3,) [rad/s] deviations of one sample; ``accel_walk`` [m/s^3/sqrt(Hz)],
    ``gyro_walk`` [rad/s^2/sqrt(Hz)]; ``pixel`` [px]; ``unsure`` (8,) deviations of the logarithms of what was learned
    (accelerometer, gyroscope, walks), 1 and more where next to nothing is known, None where nothing is learned.
    """

    rate: float
    accel: NDArray[np.float64]
    gyro: NDArray[np.float64]
    accel_walk: float
    gyro_walk: float
    pixel: float
    unsure: NDArray[np.float64] | None

    @property
    def accel_density(self) -> NDArray[np.float64]:
        """(3,) [m/s^2/sqrt(Hz)]."""
        return np.asarray(self.accel / np.sqrt(self.rate))

    @property
    def gyro_density(self) -> NDArray[np.float64]:
        """(3,) [rad/s/sqrt(Hz)]."""
        return np.asarray(self.gyro / np.sqrt(self.rate))


class Odometry:
    """The odometry beside running sensors: feed what comes, take what there is. The poses have the bits of :func:`dpn.run`.

    ``calibration``: of the camera, a file or its dictionary (Kalibr, OpenVINS, VINS, ORB-SLAM3, Basalt, OKVIS2, ASL).
    ``noise``: ``"self"`` (learned while it runs), figures a sample (``"const(0.05,0.004)"``), ``"x4"``, ``"dualpronet"``, ...
    ``camera``: ``"images"``, or ``"tracks"`` of a front-end of your own. ``config``: the estimator's settings, a TOML file or a
    dictionary (``{"covariance": True, "fed_tracks": "followed"}``). ``models``: folder of networks of your own.

    Samples and images may come in any order between the two, each in increasing time. Threads that share one take turns; the GIL
    is released while it computes. After an exception it goes on as if nothing had been fed.

    >>> odometry = dpn.Odometry("cam0/sensor.yaml")               # doctest: +SKIP
    >>> odometry.feed_imu(t, gyro, accel)                         # doctest: +SKIP
    >>> odometry.feed_image(t_image, image)                       # doctest: +SKIP
    >>> for update in odometry.updates(): print(update.position)  # doctest: +SKIP

    Raises :class:`Error`: what cannot be read, naming the argument and what was expected.
    """

    def __init__(
        self,
        calibration: Mapping[str, Any] | str | os.PathLike[str],
        noise: str = "self",
        *,
        camera: str = "images",
        config: Mapping[str, Any] | str | os.PathLike[str] | None = None,
        models: str | os.PathLike[str] | None = None,
        seed: int = 0,
    ) -> None:
        if camera not in ("images", "tracks"):
            raise Error(f"camera: {camera!r}; expected \"images\" or \"tracks\"")
        if calibration is None:
            raise Error("calibration: None; expected a file or a dictionary")
        self._inner = _dpn.Odometry(asked(noise, calibration, config, models, seed), camera)

    def feed_imu(self, t: ArrayLike, gyro: ArrayLike, accel: ArrayLike) -> None:
        """Takes samples: ``t`` (n,) int64 ns or float s; ``gyro`` (n, 3) rad/s; ``accel`` (n, 3) m/s^2; or one, ``t`` a number and (3,).

        Raises :class:`Error`: shapes, NaN, stamps that do not increase; nothing of them was taken then.
        """
        one = array("t", t).ndim == 0
        t_ns = stamps("t", [t] if one else t)
        rates, forces = ([gyro], [accel]) if one else (gyro, accel)
        self._inner.feed_imu(t_ns, matrix("gyro", rates, 3, len(t_ns)), matrix("accel", forces, 3, len(t_ns)))

    def feed_image(self, t: float, image: NDArray[np.uint8]) -> None:
        """Takes a grey image (height, width) of uint8 with the camera's stamp ``t``, int ns or float s; it is copied once, and not kept.

        Raises :class:`Error`: another type, shape or size, a stamp that goes back, 40 that wait.
        """
        self._inner.feed_image(stamp("t", t), grey("image", image))

    def feed_tracks(self, t: float, ids: ArrayLike, points: ArrayLike, *, normalised: bool = False) -> None:
        """Takes a frame's tracks: ``ids`` (m,) whole numbers, each for ever the same point's; ``points`` (m, 2) distorted pixels, or where
        ``normalised`` x / z and y / z in the camera's frame. A frame without any is ``[], np.empty((0, 2))``.

        Raises :class:`Error`: shapes, an id twice, NaN, a stamp that goes back, 40 frames that wait.
        """
        found = matrix("points", points, 2)
        self._inner.feed_tracks(stamp("t", t), counts("ids", ids, len(found)), found, bool(normalised))

    def end(self) -> None:
        """Says that nothing more comes: points are followed into the last images too."""
        self._inner.end()

    def updates(self) -> Iterator[Update]:
        """Works off the frames that samples have reached, one by one; to be emptied after every image or frame."""
        while (found := self._inner.next_update()) is not None:
            yield Update(**found)

    @property
    def waiting(self) -> str | None:
        """What is waited for, in words; None while poses come."""
        return self._inner.waiting()

    @property
    def learned(self) -> Noise | None:
        """The noise in force; None until the samples' rate is known (100 samples)."""
        found = self._inner.noise()
        if found is None:
            return None
        rate, accel, gyro, accel_walk, gyro_walk, pixel, unsure = found
        of = None if unsure is None else np.array(unsure)
        return Noise(rate, np.array(accel), np.array(gyro), accel_walk, gyro_walk, pixel, of)

    def warnings(self) -> list[str]:
        """What seems to be wrong with the input, each once."""
        return self._inner.warnings()
