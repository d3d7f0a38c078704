"""Where to solve or measure next: ask and tell."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from .arrays import numbers


class Placement:
    """Places states in a box one after the other, for a solver or a measurement of the user's own.

        placement = Placement(low, high, spacing)
        while len(placement) < 50:
            for x in placement.ask(4):
                placement.tell(x, *my_solver(x))

    The first positions are rest (where the box holds it) and the corners at 3/4 of the box. Then each next position
    is the candidate of the largest estimated error, relative to max(|force|, floor). With stiffness the estimate is
    that of `forefeel generate --error`. Without, it is the squared distance to the nearest state times the
    disagreement of two models, one with half of the other's neighbours; this is hardly better than a lattice.

    low, high  (3,): corners of the box [m]
    spacing    finest distance of states; candidates are its lattice [m]
    floor      force below which errors count in newtons [N]
    rule       an object of yours with doubt(states, candidates) -> (n,): how much each candidate (n, 3) [m] is worth,
               from the structured array of the states so far; None: the estimates above
    """

    def __init__(self, low: ArrayLike, high: ArrayLike, spacing: float, floor: float = 0.05,
                 rule: Any = None) -> None:
        self.rule = rule
        self.low, self.high = numbers(low, "low"), numbers(high, "high")
        self.spacing, self.floor = float(spacing), float(floor)
        if not (self.low.shape == self.high.shape == (3,) and np.all(self.low < self.high) and self.spacing > 0):
            raise _core.InputError("Placement: expected corners (3,) with low < high, and spacing > 0")
        if not np.prod((self.high - self.low) / self.spacing + 1) <= 1e6:
            raise _core.InputError("Placement: the box holds more than 1e6 candidates, expected a larger spacing")
        axes = [np.arange(np.ceil(l / spacing - 1e-9), np.floor(h / spacing + 1e-9) + 1) * spacing
                for l, h in zip(self.low, self.high)]
        self.candidates = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        if len(self.candidates) == 0:
            raise _core.InputError("Placement: the box holds no position of the lattice, expected a smaller spacing")
        self._at, self._force, self._stiffness = [], [], []
        self._open = []  # asked, not told yet
        self._gaps = np.full(len(self.candidates), np.inf)  # to the nearest state or asked position [m]
        self._errors = _core.CandidateErrors(self.candidates, self.spacing, self.floor)

    def __len__(self) -> int:
        return len(self._at)

    @property
    def states(self) -> NDArray[Any]:
        """Structured array of the states told so far."""
        if not self._at:
            return np.empty(0, _core.state_dtype)
        stiffness = np.array([np.full((3, 3), np.nan) if k is None else k for k in self._stiffness])
        return _core.measured(np.array(self._at), np.array(self._force), stiffness)

    def tell(self, at: ArrayLike, force: ArrayLike, stiffness: ArrayLike | None = None) -> None:
        """Adds a state: force (3,) [N] at a position (3,) [m], and stiffness (3, 3) [N/m], K = -df/dx, if known."""
        at, force = numbers(at, "at").reshape(3), numbers(force, "force").reshape(3)
        if not (np.all(np.isfinite(at)) and np.all(np.isfinite(force))):
            raise _core.InputError("Placement.tell: expected finite numbers")
        if stiffness is not None and not np.all(np.isfinite(numbers(stiffness, "stiffness"))):
            raise _core.InputError("Placement.tell: a stiffness that is not finite, expected numbers, or None where it "
                                   "is not known")
        if np.any(at < self.low - 1e-9) or np.any(at > self.high + 1e-9):
            warnings.warn(f"Placement.tell: {at} lies outside the box; it counts, but nothing there is asked for",
                          stacklevel=2)
        self._at.append(at)
        self._force.append(force)
        self._stiffness.append(None if stiffness is None else numbers(stiffness, "stiffness").reshape(3, 3))
        if stiffness is not None:
            self._errors.tell(at[None], force[None], self._stiffness[-1][None])
        self._open = [x for x in self._open if not np.array_equal(x, at)]
        self._near(at)

    def ask(self, n: int = 1) -> NDArray[np.float64]:
        """The next n positions (n, 3) [m]; fewer if the lattice is full. Positions that were asked and not told yet
        are not asked again."""
        chosen = []
        doubt = self._doubt()
        for _ in range(n):
            x = self._next(doubt)
            if x is None:
                break
            chosen.append(x)
            self._open.append(x)
            self._near(x)
        return np.array(chosen).reshape(-1, 3)

    def _near(self, at):
        np.minimum(self._gaps, np.linalg.norm(self.candidates - at, axis=1), out=self._gaps)

    def _next(self, doubt):
        if self._gaps.max() <= 1e-9 * self.spacing:
            return None
        taken = np.array(self._at + self._open).reshape(-1, 3)
        for start in self._starts():
            if len(taken) == 0 or np.linalg.norm(taken - start, axis=1).min() > 1e-9 * self.spacing:
                return start
        weights = (self._gaps > 1e-9 * self.spacing).astype(float)
        # An asked position will be known soon: its surroundings need less.
        if self._open:
            near = np.min([np.linalg.norm(self.candidates - x, axis=1) for x in self._open], axis=0)
            weights *= np.minimum(1, near / (2 * self.spacing))
        if doubt is None:
            return self.candidates[self._errors.worst(weights)].copy()
        # gaps break ties, and decide where the models agree to rounding
        return self.candidates[np.lexsort((-self._gaps, -doubt * weights))[0]].copy()

    def _starts(self):
        middle, half = (self.low + self.high) / 2, (self.high - self.low) / 2
        inside = np.all((self.low <= 0) & (self.high >= 0))
        wanted = [np.zeros(3) if inside else middle]
        wanted += [middle + 0.75 * half * np.array(s) for s in
                   ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1), (-1, -1, -1), (-1, 1, 1), (1, -1, 1), (1, 1, -1))]
        return [self.candidates[((self.candidates - w) ** 2).sum(axis=1).argmin()] for w in wanted]

    def _doubt(self):
        """How much each candidate is worth; None: the errors that states with stiffness tell."""
        states = self.states
        if self.rule is not None:
            doubt = np.asarray(self.rule.doubt(states, self.candidates), float)
            if doubt.shape != (len(self.candidates),) or not np.all(np.isfinite(doubt)):
                raise _core.InputError(f"doubt() gave the shape {doubt.shape}, expected ({len(self.candidates)},) "
                                       "finite numbers")
            return np.maximum(doubt, 0)
        if len(states) == 0:
            return np.ones(len(self.candidates))
        if all(k is not None for k in self._stiffness):
            return None
        space = _core.StateSpace(states, self.spacing)
        n = max(4, min(len(states), 24))
        fine = _core.evaluate_in(space, self.candidates, method="rbf", neighbours=n, select="nearest")[0]
        coarse = _core.evaluate_in(space, self.candidates, method="rbf", neighbours=max(2, n // 2),
                                   select="nearest")[0]
        size = np.maximum(np.linalg.norm(fine, axis=1), self.floor)
        disagreement = np.linalg.norm(fine - coarse, axis=1) / size
        gaps = space.distance(self.candidates)
        return gaps ** 2 * (disagreement + 0.1 * np.median(disagreement))
