"""Results as tables of pandas, for those who ask."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ._dpn import Error, Recording
from ._run import Run

if TYPE_CHECKING:
    from . import NoiseTrack

_AXES = [f"{sensor}_{axis}" for sensor in ("accel", "gyro") for axis in "xyz"]


def frame(of: Recording | NoiseTrack | Run) -> Any:
    """A :class:`pandas.DataFrame` of a recording, a noise track or a run: a row a sample, an answer or a frame, columns as ``accel_x``, SI, by time (of stamps,
    as nanoseconds since 1970).

    Raises :class:`Error`: another value, no pandas (``pip install pandas``).
    """
    try:
        import pandas  # type: ignore[import-untyped, unused-ignore]
    except ImportError:
        raise Error("pandas is not there; pip install pandas") from None
    if isinstance(of, Run):
        columns: dict[str, Any] = {"phase": of.phase}
        named = (("", of.position), ("v", of.velocity), ("accel_bias_", of.accel_bias), ("gyro_bias_", of.gyro_bias))
        for name, values in named:
            columns.update({f"{name}{axis}": values[:, k] for k, axis in enumerate("xyz")})
        columns.update({f"q{axis}": of.orientation[:, k] for k, axis in enumerate("wxyz")})
        columns.update(tracked=of.tracked, landmarks=of.landmarks, outliers=of.outliers)
    elif isinstance(of, Recording):
        columns = dict(zip(_AXES, np.hstack([of.accel, of.gyro]).T))
    elif hasattr(of, "sigma") and hasattr(of, "in_range"):
        columns = {**dict(zip(_AXES, of.sigma.T)), "in_range": of.in_range}
    else:
        raise Error(f"of: {type(of).__name__}; expected a dpn.Recording, dpn.NoiseTrack or dpn.Run")
    return pandas.DataFrame(columns, index=pandas.to_datetime(of.t_ns).rename("t"))
