"""Labels of places (how well the force is known there), and forces between and beyond states."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from .arrays import numbers
from .states import States, has_forces, refuse_positions, rows_of, warn_of_stiffness


def _length(spacing: Any) -> float | None:
    if spacing is None:
        return None
    try:
        return float(spacing)
    except (TypeError, ValueError):
        raise _core.InputError(f"spacing: is {spacing!r}, expected metres") from None


def classify(positions: ArrayLike, points: ArrayLike, spacing: float | None = None) -> NDArray[np.uint8]:
    """Labels of points from the positions of known states: uint8 (m,), 0 safe, 1 sparse, 2 gap, 3 blank.

    positions (n, 3) [m]; points (m, 3) [m]; spacing that counts as dense [m], None: estimated from the density
    of the states, of which at least two are needed. Same labels as `forefeel classify`.
    `label_names` has the words.
    """
    return _core.classify(numbers(positions, "positions"), numbers(points, "points"), _length(spacing))


def evaluate(positions: ArrayLike, forces: ArrayLike, points: ArrayLike, stiffness: ArrayLike | None = None,
             **options: Any) -> NDArray[np.float64]:
    """Forces (m, 3) [N] at points (m, 3) [m], approximated from states at positions (n, 3) [m].

    forces (n, 3) [N]; stiffness (n, 3, 3) [N/m] with K = -df/dx, or None. Options as of `forefeel evaluate`:
    method, kernel, data, neighbours, select, ridge (a number or "auto"), spacing [m], noise [N] and position_noise [m]
    (deviation of a component of a measured force and of a coordinate; estimated if not given), stiffest [N/m] (seldom
    exceeded across measured states; three times that along them if not given). Same forces as the command; error_bar()
    gives their error bars.
    States without stiffness have method="auto" if nothing is given: it chooses kernel, neighbours and ridge by
    leaving out groups of neighbouring states; evaluation() says what it chose.
    """
    return evaluation(positions, forces, points, stiffness, **options)[0]


def evaluation(positions: ArrayLike, forces: ArrayLike, points: ArrayLike, stiffness: ArrayLike | None = None,
               **options: Any) -> tuple[NDArray[np.float64], dict[str, Any]]:
    """evaluate(), and a dict of what was used: method, kernel, data, neighbours, ridge, spacing [m], averaged (states
    that contradicted another at their position), and for method "auto" expected_error {p50, p95} [N] and groups, the
    number of independent groups behind it; for measured states noise [N], given or estimated. With bars=True
    also bars (m, 3) [N], the half-widths of 90, 95 and 99 %, and error_bar: how well they cover known forces that are
    left out (levels, coverage, samples, width_p50 [N])."""
    at, force = numbers(positions, "positions"), numbers(forces, "forces")
    given = None if stiffness is None else numbers(stiffness, "stiffness")
    if given is not None:
        warn_of_stiffness(_core.measured(at, force, given))
    return _core.evaluate(at, force, numbers(points, "points"), given, **options)


def _column(level: float) -> int:
    """The column of a level in the arrays of bars."""
    levels = (0.9, 0.95, 0.99)
    if level not in levels:
        raise _core.InputError(f"level: is {level!r}, expected 0.9, 0.95 or 0.99")
    return levels.index(level)


def _bars(used: dict[str, Any], level: float) -> NDArray[np.float64]:
    if "bars" not in used:
        raise _core.InputError(f"method: is {used['method']}, which has no error bars, expected rbf or auto")
    return np.ascontiguousarray(used["bars"][:, _column(level)])


def error_bar(positions: ArrayLike, forces: ArrayLike, points: ArrayLike, stiffness: ArrayLike | None = None,
              level: float = 0.95, **options: Any) -> NDArray[np.float64]:
    """Half-widths (m,) [N] of the error bars of evaluate() at points (m, 3) [m]: |evaluated - true force| is at most
    this at the share `level` (0.9, 0.95 or 0.99) of the places. They come from known forces that are left out in groups
    of neighbouring positions; inf where the states are too few for the level. Arguments and options as of evaluate();
    same bars as `forefeel evaluate`."""
    _column(level)
    return _bars(evaluation(positions, forces, points, stiffness, bars=True, **options)[1], level)


class Coverage(NamedTuple):
    """How a set of states covers its box.

    volume      (4,) [m^3] by label, in the order of label_names
    components  structured array of the connected regions, by label, then by falling volume: label, volume [m^3], a place
                inside x, y, z [m], bounds low_x … high_z [m]
    holes       structured array of the balls without a state that are larger than the spacing and lie between states,
                largest first, none centred in a larger one, at most 1000: radius, x, y, z [m]
    """
    volume: NDArray[np.float64]
    components: NDArray[Any]
    holes: NDArray[Any]


class StateSpace:
    """Known states, indexed by position. Made once; every method is vectorised and uses all cores.

    states      structured array, States, or positions (n, 3) [m], which have labels but no forces
    spacing     that counts as dense [m]; None: of the States, else estimated from the density
    thresholds  of the labels
    """

    def __init__(self, states: Any, spacing: float | None = None, thresholds: _core.Thresholds | None = None) -> None:
        if isinstance(states, _core.StateSpace):
            self._space, self._has_forces = states, True
            return
        if spacing is None and isinstance(states, States) and np.isfinite(states.spacing):
            spacing = states.spacing
        self._has_forces = has_forces(states)
        self._space = _core.StateSpace(rows_of(states), _length(spacing), thresholds or _core.Thresholds())

    def _known(self) -> _core.StateSpace:
        """The space, if its states have forces. InputError otherwise."""
        if not self._has_forces:
            refuse_positions()
        return self._space

    def __len__(self) -> int:
        return len(self._space)

    @property
    def spacing(self) -> float:
        """Distance of neighbouring states that counts as dense [m]."""
        return self._space.spacing

    @property
    def box(self) -> NDArray[np.float64]:
        """(2, 3): low and high corner of the states [m]"""
        return self._space.box

    @property
    def states(self) -> NDArray[Any]:
        """Structured array (n,) of its states: those given, without failed and repeated ones. The forces of positions
        are nan."""
        rows = self._space.states
        if not self._has_forces:
            rows["force"] = np.nan
        return rows

    def label(self, points: ArrayLike) -> NDArray[np.uint8]:
        """uint8 (m,) at points (m, 3) [m]: 0 safe, 1 sparse, 2 gap, 3 blank"""
        return self._space.label(numbers(points, "points"))

    def coverage(self) -> Coverage:
        """Volume, connected regions and holes of its box. A few seconds for a million states."""
        return Coverage(*self._space._coverage())

    def spread(self, points: ArrayLike) -> NDArray[np.float64]:
        """(m,) [m] at points (m, 3) [m]: sqrt(R^2 - |q - c|^2) in the Delaunay cell of q with circumcentre c and
        circumradius R; inf outside the hull of the states"""
        return self._space.spread(numbers(points, "points"))

    def distance(self, points: ArrayLike) -> NDArray[np.float64]:
        """(m,) [m]: from points (m, 3) [m] to the nearest state"""
        return self._space.distance(numbers(points, "points"))

    def nearest(self, points: ArrayLike, n: int = 1) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """The n nearest states of points (m, 3) [m], by distance: int64 (m, n), rows of the array that the space was
        made from, and distances (m, n) [m]."""
        if not (isinstance(n, (int, np.integer)) and n >= 1):
            raise _core.InputError(f"n: is {n!r}, expected a whole number >= 1")
        return self._space.nearest(numbers(points, "points"), n)

    def evaluate(self, points: ArrayLike, **options: Any) -> NDArray[np.float64]:
        """Forces (m, 3) [N] at points (m, 3) [m]; each has the model of its own neighbours. Options: evaluate().
        InputError if the space was made from positions alone, which have no forces; error_bar and model_at likewise."""
        return _core.evaluate_in(self._known(), numbers(points, "points"), **options)[0]

    def error_bar(self, points: ArrayLike, level: float = 0.95, **options: Any) -> NDArray[np.float64]:
        """Half-widths (m,) [N] of the error bars of evaluate() at points (m, 3) [m], at the share `level` (0.9, 0.95 or
        0.99) of the places. Function error_bar() says how they are made."""
        _column(level)
        return _bars(_core.evaluate_in(self._known(), numbers(points, "points"), bars=True, **options)[1], level)

    def model_at(self, hip: ArrayLike, **options: Any) -> _core.Model:
        """The Model around a HIP position (3,) [m]; evaluate it anywhere near. Options as of evaluate()."""
        return _core.model_at(self._known(), numbers(hip, "hip"), **options)
