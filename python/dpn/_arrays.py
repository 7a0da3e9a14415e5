"""Arguments as the compiled half takes them, or an exception that names the argument and what was expected."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._dpn import Error


def array(name: str, value: Any) -> NDArray[Any]:
    """``value`` as an array, or an exception that names it."""
    if np.ma.is_masked(value):
        raise Error(f"{name}: masked entries; expected an array without any, for what lies behind a mask would be taken for data")
    try:
        return np.asarray(value)
    except (TypeError, ValueError) as error:
        raise Error(f"{name}: no array ({error}); expected one") from None


def matrix(name: str, value: Any, columns: int, rows: int | None = None, dtype: type = np.float64) -> NDArray[Any]:
    """``value`` as a finite C-contiguous (rows, columns) array; copied only where it is not one already."""
    found = array(name, value)
    expected = f"expected ({'n' if rows is None else rows}, {columns})"
    if found.dtype.kind not in "fiu":
        raise Error(f"{name}: dtype {found.dtype}; expected real numbers, as float64")
    if found.ndim != 2 or found.shape[1] != columns or rows not in (None, found.shape[0]):
        hint = "; transpose it" if found.ndim == 2 and found.shape[0] == columns else ""
        raise Error(f"{name}: shape {found.shape}; {expected}{hint}")
    with np.errstate(over="ignore"):
        found = np.ascontiguousarray(found, dtype=dtype)
    finite = np.isfinite(found)
    if not finite.all():
        row, column = np.argwhere(~finite)[0]
        raise Error(f"{name}: {found[row, column]} at [{row}, {column}]; expected finite numbers")
    return found


def cube(name: str, value: Any, rows: int, side: int) -> NDArray[np.float64]:
    """``value`` of shape (rows, side, side) as a finite (rows, side * side) array."""
    found = array(name, value)
    if found.shape != (rows, side, side):
        raise Error(f"{name}: shape {found.shape}; expected ({rows}, {side}, {side})")
    return matrix(name, found.reshape(rows, side * side), side * side, rows)


def vector(name: str, value: Any) -> list[float]:
    """``value`` as three finite numbers x y z."""
    found = array(name, value)
    if found.shape != (3,) or found.dtype.kind not in "fiu" or not np.isfinite(found).all():
        raise Error(f"{name}: {value!r}; expected three finite numbers x y z")
    return [float(entry) for entry in found]


def stamps(name: str, value: Any, repeated: bool = False) -> NDArray[np.int64]:
    """``value`` as increasing int64 nanoseconds (or not falling, where ``repeated``): integers are nanoseconds, floats seconds."""
    found = array(name, value)
    if found.ndim != 1:
        raise Error(f"{name}: shape {found.shape}; expected (n,)")
    if found.dtype.kind == "f":
        # Of half precision seconds times 1e9 are infinite.
        with np.errstate(over="ignore"):
            found = found.astype(np.float64)
        if not np.isfinite(found).all():
            raise Error(f"{name}: {found[~np.isfinite(found)][0]} at [{np.argmin(np.isfinite(found))}]; expected finite seconds")
        if found.size and np.abs(found).max() > 9.2e9:
            raise Error(f"{name}: {np.abs(found).max():g} s is beyond int64 nanoseconds; expected float seconds or integer nanoseconds")
        found = np.round(found * 1e9)
    elif found.dtype.kind not in "iu":
        raise Error(f"{name}: dtype {found.dtype}; expected int64 nanoseconds or float seconds")
    elif found.size and int(found.max()) > np.iinfo(np.int64).max:
        raise Error(f"{name}: {found.max()} at [{np.argmax(found)}]; expected nanoseconds that int64 holds")
    found = np.ascontiguousarray(found, dtype=np.int64)
    back = np.flatnonzero(found[1:] < found[:-1] if repeated else found[1:] <= found[:-1])
    if back.size:
        at = back[0]
        expected = "do not fall" if repeated else "increase"
        raise Error(f"{name}: {found[at]} to {found[at + 1]} ns at [{at + 1}]; expected stamps that {expected}")
    return found


def stamp(name: str, value: Any) -> int:
    """One stamp as nanoseconds: an integer is nanoseconds, a float seconds."""
    return int(stamps(name, [value])[0])


def grey(name: str, value: Any) -> NDArray[np.uint8]:
    """``value`` as a C-contiguous image (height, width) of uint8; copied only where its rows are not contiguous."""
    found = array(name, value)
    if found.dtype != np.uint8 or found.ndim != 2:
        raise Error(f"{name}: dtype {found.dtype}, shape {found.shape}; expected uint8 (height, width), a grey image")
    return np.ascontiguousarray(found)


def counts(name: str, value: Any, rows: int) -> NDArray[np.uint64]:
    """``value`` as (rows,) whole numbers from 0."""
    found = array(name, value)
    if found.shape != (rows,):
        raise Error(f"{name}: shape {found.shape}; expected ({rows},)")
    if not rows:
        # numpy takes an empty list for floats.
        return np.empty(0, np.uint64)
    if found.dtype.kind not in "iu":
        raise Error(f"{name}: dtype {found.dtype}; expected whole numbers from 0")
    if (found < 0).any():
        raise Error(f"{name}: {found[found < 0][0]} at [{np.argmax(found < 0)}]; expected whole numbers from 0")
    return np.ascontiguousarray(found, dtype=np.uint64)


def poses(name: str, value: Any) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """(t, position, orientation) as stamps (n,) and rows (n, 7) of x y z, then a unit quaternion w x y z."""
    try:
        t, position, orientation = value
    except (TypeError, ValueError):
        raise Error(f"{name}: {type(value).__name__}; expected (t, position, orientation)") from None
    t_ns = stamps(f"{name}[0]", t)
    position = matrix(f"{name}[1]", position, 3, len(t_ns))
    orientation = matrix(f"{name}[2]", orientation, 4, len(t_ns))
    norm = np.linalg.norm(orientation, axis=1)
    if (np.abs(norm - 1) > 1e-3).any():
        at = int(np.argmax(np.abs(norm - 1)))
        raise Error(f"{name}[2]: norm {norm[at]:g} at [{at}]; expected unit quaternions w x y z")
    return t_ns, np.hstack([position, orientation / norm[:, None]])


def whole(name: str, value: Any, low: int, high: int) -> int:
    """``value`` as an integer from ``low`` to ``high``."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)) or not low <= value <= high:
        raise Error(f"{name}: {value!r}; expected an integer from {low} to {high}")
    return int(value)


def seconds(name: str, value: Any) -> float:
    """``value`` as a number of seconds from 0."""
    if isinstance(value, bool) or not isinstance(value, (int, float, np.number)) or not 0 <= value < math.inf:
        raise Error(f"{name}: {value!r}; expected seconds from 0")
    return float(value)


def path(name: str, value: Any, expected: str = "a path") -> str:
    """``value`` as a path's text."""
    if not isinstance(value, (str, os.PathLike)):
        raise Error(f"{name}: {type(value).__name__}; expected {expected}")
    return str(os.fspath(value))


def file_or_json(name: str, value: Any) -> tuple[str | None, str | None]:
    """A file's path, or a dictionary as JSON; arrays in it become lists."""
    if not isinstance(value, Mapping):
        return path(name, value, "a file or a dictionary"), None
    return None, _json(name, dict(value))


def file_or_keys(name: str, value: Any) -> tuple[str | None, list[tuple[str, str]]]:
    """A file's path, or a dictionary's keys with dots and their values as TOML, without tables, which JSON is."""
    if value is None:
        return None, []
    if not isinstance(value, Mapping):
        return path(name, value, "a TOML file or a dictionary"), []

    def flat(prefix: str, inner: Mapping[Any, Any]) -> list[tuple[str, str]]:
        found = []
        for key, entry in inner.items():
            full = f"{prefix}{key}"
            found += flat(f"{full}.", entry) if isinstance(entry, Mapping) else [(full, _json(f"{name}[{full!r}]", entry))]
        return found

    return None, flat("", value)


def _json(name: str, value: Any) -> str:
    def plain(entry: Any) -> Any:
        if isinstance(entry, (np.ndarray, np.generic)):
            return entry.tolist()
        raise TypeError(type(entry).__name__)

    try:
        return json.dumps(value, default=plain, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise Error(f"{name}: {error}; expected finite numbers, texts, lists and dictionaries") from None


def listener(value: Any) -> None:
    """Refuses a ``progress`` that cannot be called."""
    if value is not None and not callable(value):
        raise Error(f"progress: {type(value).__name__}; expected a function of (done, total)")
