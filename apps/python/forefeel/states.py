"""States: positions with forces, and the files that hold them."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from .arrays import numbers, refuse_masked


class States:
    """States with what their file says about them.

    array     structured array (n,) with `state_dtype`: at [m], site [m] (NaN without one), force [N],
              stiffness [N/m], energy [J], …
    spacing   of a full lattice [m]; nan if unknown
    box       (2, 3): low and high corner [m]
    identity  dict: the body that the states belong to; empty for measured states
    notes     dict of texts
    damaged   number of rows of the file that could not be read
    jets      list (n) of the energy jets that the file holds, dict or None as of Body.solve(); None without any
    """

    def __init__(self, array: NDArray[Any], spacing: float, box: NDArray[np.float64], identity: dict[str, str],
                 notes: dict[str, str], damaged: int = 0, jets: list[dict[str, float] | None] | None = None) -> None:
        self.array, self.spacing, self.box = array, spacing, box
        self.identity, self.notes, self.damaged, self.jets = identity, notes, damaged, jets

    def __len__(self) -> int:
        return len(self.array)

    def __getitem__(self, key: Any) -> Any:
        """A field as an array, by its name: states["force"] is (n, 3) [N]; else rows, as of `array`."""
        return self.array[key]

    def __repr__(self) -> str:
        return f"<forefeel.States: {len(self)} states, spacing {self.spacing:g} m>"

    @property
    def usable(self) -> NDArray[np.bool_]:
        """Mask (n,) of the states that converged or were measured."""
        good = [_core.status_names.index("converged"), _core.status_names.index("measured")]
        return np.isin(self.array["status"], good)

    def to_frame(self) -> Any:
        """One column for each number, named as `forefeel export` does (x, fx, k11, …; units m, N, N/m, J): a pandas
        DataFrame, or a structured array where pandas is not installed."""
        columns: dict[str, NDArray[Any]] = {}
        fields = [("at", "{}"), ("force", "f{}")]
        if np.isfinite(self.array["site"]).any():
            fields.insert(0, ("site", "s{}"))
        for field, name in fields:
            for i, axis in enumerate("xyz"):
                columns[name.format(axis)] = self.array[field][:, i]
        for i in range(3):
            for j in range(3):
                columns[f"k{i + 1}{j + 1}"] = self.array["stiffness"][:, i, j]
        for field in ("energy", "spacing", "residual", "seconds", "min_jacobian", "iterations", "multivalued"):
            columns[field] = self.array[field]
        columns["status"] = np.array(_core.status_names)[self.array["status"]]
        return frame_of(columns)


def frame_of(columns: dict[str, NDArray[Any]]) -> Any:
    """A pandas DataFrame of columns of one length, or a structured array where pandas is not installed."""
    try:
        import pandas
        return pandas.DataFrame(columns)
    except ImportError:
        out = np.empty(len(next(iter(columns.values()), ())), [(name, c.dtype) for name, c in columns.items()])
        for name, column in columns.items():
            out[name] = column
        return out


def read_states(file: Any) -> States:
    """Reads a .states file or a CSV of states. InputError names the file and what is wrong."""
    read = _core.read_states(file)
    return States(read["states"], read["spacing"], read["box"], read["identity"], read["notes"], read["damaged"],
                  read["jets"])


def write_states(file: Any, states: Any, spacing: float | None = None) -> None:
    """Writes a new .states file; an existing one is refused. states: States or structured array; positions alone
    are refused, as their forces are not known. spacing of a full lattice [m]; None: that of the States."""
    rows = known_rows(states)
    if spacing is None:
        if not isinstance(states, States):
            raise _core.InputError("spacing: missing, expected metres, as write_states(file, states, spacing=0.005)")
        spacing = states.spacing
    _core.write_states(file, rows, spacing)


def measured(positions: ArrayLike, forces: ArrayLike, stiffness: ArrayLike | None = None) -> NDArray[Any]:
    """States from measured values, a structured array (n,): positions (n, 3) [m], forces (n, 3) [N], stiffness
    (n, 3, 3) [N/m] with K = -df/dx, or None."""
    rows = _core.measured(numbers(positions, "positions"), numbers(forces, "forces"),
                          None if stiffness is None else numbers(stiffness, "stiffness"))
    if stiffness is not None:
        warn_of_stiffness(rows)
    return rows


def warn_of_stiffness(rows: NDArray[Any]) -> None:
    """Warns where the stiffness contradicts the forces of neighbours: another sign or unit."""
    problem = _core._stiffness_problem(rows)
    if problem:
        warnings.warn("states: " + problem.replace(" (k11 to k33)", ""), stacklevel=3)


def refuse_positions() -> None:
    raise _core.InputError("states: positions alone have no forces, expected States or a structured array; "
                           "forefeel.measured(positions, forces) makes one")


def has_forces(states: Any) -> bool:
    """False: the states are positions alone."""
    return isinstance(states, States) or np.asarray(states).dtype.names is not None


def known_rows(states: Any) -> NDArray[Any]:
    """The structured array of States or of a structured array. InputError for positions: their forces are not known."""
    if not has_forces(states):
        refuse_positions()
    return rows_of(states)


def rows_of(states: Any) -> NDArray[Any]:
    """The structured array of anything that represents states: States, structured array, or positions (n, 3) [m]. The
    forces of positions are zero and must not be used."""
    if isinstance(states, States):
        return states.array
    refuse_masked(states, "states")
    states = np.asarray(states)
    if states.dtype.names:
        if states.dtype != _core.state_dtype:
            raise _core.InputError("states: has other fields than state_dtype; forefeel.measured() makes such an array")
        return states
    states = numbers(states, "states")
    return _core.measured(states, np.zeros_like(states), None)
