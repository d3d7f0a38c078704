"""Arrays that a caller gives, checked: InputError names the argument. And tables that a caller gets."""

from __future__ import annotations

from collections.abc import Iterable
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


class Table(np.ndarray):  # type: ignore[type-arg]
    """A structured array with one field for each column of a file. A vector has a name of its own as well:
    table["rendered"] is (n, 3), of the columns rendered_x, rendered_y and rendered_z."""

    _columns: dict[str, list[str]]

    @classmethod
    def of(cls, array: NDArray[Any], fields: Iterable[tuple[str, str, str, str]]) -> Table:
        """fields: (field of the array, columns of the file, unit, meaning)"""
        columns = {field: names.split(",") for field, names, *_ in fields}
        dtype = [(name, array.dtype[field].base) for field, names in columns.items() for name in names]
        table = np.empty(len(array), dtype).view(cls)
        table._columns = {field: names for field, names in columns.items() if names != [field]}
        for field, names in columns.items():
            for name, values in zip(names, array[field].reshape(len(array), len(names)).T):
                np.ndarray.__setitem__(table, name, values)
        return table

    def __array_finalize__(self, other: Any) -> None:
        self._columns = getattr(other, "_columns", {})

    def __getitem__(self, key: Any) -> Any:
        if not isinstance(key, str):
            return super().__getitem__(key)
        if key not in self._columns:
            return np.asarray(super().__getitem__(key))
        found = [np.asarray(super(Table, self).__getitem__(name)) for name in self._columns[key]]
        return found[0] if len(found) == 1 else np.stack(found, axis=-1)
