"""Arrays as the compiled half takes them, or an exception that names the argument."""

import numpy as np

from ._dpn import Error


def matrix(name, value, columns, rows=None, dtype=np.float64):
    """``value`` as a finite C-contiguous (rows, columns) array; copied only where it is not one already."""
    found = np.asarray(value)
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


def stamps(name, value):
    """``value`` as increasing int64 nanoseconds: integers are nanoseconds, floats seconds."""
    found = np.asarray(value)
    if found.ndim != 1:
        raise Error(f"{name}: shape {found.shape}; expected (n,)")
    if found.dtype.kind == "f":
        if not np.isfinite(found).all():
            raise Error(f"{name}: {found[~np.isfinite(found)][0]} at [{np.argmin(np.isfinite(found))}]; expected finite seconds")
        if found.size and np.abs(found).max() > 9.2e9:
            raise Error(f"{name}: {np.abs(found).max():g} s is beyond int64 nanoseconds; expected float seconds or integer nanoseconds")
        found = np.round(found * 1e9)
    elif found.dtype.kind not in "iu":
        raise Error(f"{name}: dtype {found.dtype}; expected int64 nanoseconds or float seconds")
    found = np.ascontiguousarray(found, dtype=np.int64)
    back = np.flatnonzero(found[1:] <= found[:-1])
    if back.size:
        at = back[0]
        raise Error(f"{name}: {found[at]} to {found[at + 1]} ns at [{at + 1}]; expected stamps that increase")
    return found
