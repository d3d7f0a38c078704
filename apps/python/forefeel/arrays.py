"""What a caller gives as an array, checked. InputError names the argument."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core


def _is_masked(values: Any) -> bool:
    # np.ma.is_masked() fails for structured arrays.
    return isinstance(values, np.ma.MaskedArray) and 1 in np.ma.getmaskarray(values).tobytes()


def refuse_masked(values: Any, argument: str) -> None:
    """InputError for a masked array with masked values: NumPy would take what lies under the mask."""
    inner = values if isinstance(values, (list, tuple)) else [values]
    if any(_is_masked(value) for value in inner):
        raise _core.InputError(f"{argument}: has masked values, expected an array without; .compressed() or "
                               ".filled() makes one")


def numbers(values: Any, argument: str) -> NDArray[np.float64]:
    """Any array-like of real numbers as floats."""
    refuse_masked(values, argument)
    try:
        kind = np.asarray(values).dtype.kind
        if kind == "c":
            raise _core.InputError(f"{argument}: has complex numbers, expected real ones")
        if kind in "bmM":
            raise TypeError
        return np.asarray(values, dtype=float)
    except _core.InputError:
        raise
    except (TypeError, ValueError):
        raise _core.InputError(f"{argument}: expected an array of numbers") from None


def whole_numbers(values: Any, argument: str, of: str = "numbers of nodes") -> NDArray[np.int64]:
    """An array-like of whole numbers. Floats are refused: what was meant by node 1.5 is not known."""
    refuse_masked(values, argument)
    try:
        array = np.asarray(values)
    except ValueError:
        raise _core.InputError(f"{argument}: expected whole numbers, {of} from 0") from None
    if array.size == 0:
        return array.astype(np.int64)
    if array.dtype.kind not in "iu":
        what = {"f": "floats", "c": "complex numbers", "b": "True and False"}.get(array.dtype.kind, "other values")
        raise _core.InputError(f"{argument}: has {what}, expected whole numbers, {of} from 0")
    if array.dtype.kind == "u" and array.max() > np.iinfo(np.int64).max:
        raise _core.InputError(f"{argument}: holds {array.max()}, expected {of} from 0")
    return array.astype(np.int64)


def node_set(values: ArrayLike, nodes: int, argument: str) -> NDArray[np.int64]:
    """Numbers of nodes; a mask (v,) of True and False chooses nodes as in NumPy."""
    if not _is_masked(values):
        try:
            array = np.asarray(values)
        except ValueError:
            array = np.empty(0)
        if array.dtype.kind == "b" and array.size > 0:
            if array.shape != (nodes,):
                raise _core.InputError(f"{argument}: is a mask of the shape {array.shape}, expected ({nodes},), one "
                                       "for each node")
            return np.flatnonzero(array)
    return whole_numbers(values, argument)
