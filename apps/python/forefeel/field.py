"""A body that is touched anywhere: forces at (site, displacement)."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from .arrays import numbers


class FieldForces(NamedTuple):
    """Of SurfaceField.evaluate(), a row for each displacement.

    site       (n, 3): on the surface, nearest to the one asked for [m]
    force      (n, 3): of the body on the tip [N]
    stiffness  (n, 3, 3): -d force / d displacement [N/m]
    energy     (n,): of body and pad [J]
    estimate   (n,): of the error of the force [N]
    trusted    (n,): three times the estimate is within state_space.tolerance, and the tip is no deeper than `thickness`
    thickness  (n,): of the body at rest under the site, against the normal [m]; infinite beside a sharp rim
    """

    site: NDArray[np.float64]
    force: NDArray[np.float64]
    stiffness: NDArray[np.float64]
    energy: NDArray[np.float64]
    estimate: NDArray[np.float64]
    trusted: NDArray[np.bool_]
    thickness: NDArray[np.float64]


class SurfaceField:
    """The field of a scene with contact.anywhere = true: what its body at rest says about a touch at any place, with
    the corrections of solved states. It is made, or read from the cache.

    scene    file of the scene (TOML)
    states   file of `forefeel generate`, of a session, or a CSV with columns sx,sy,sz; None: the field alone
    set      keys of the scene that are overridden, as "material.young=8000"
    threads  0: all of the machine

    sites    (n, 3): whose jets at rest make the field [m]
    depth    to which states are placed [m]
    """

    def __init__(self, scene: str | os.PathLike[str], states: str | os.PathLike[str] | None = None,
                 set: Iterable[str] = (), threads: int = 0) -> None:
        self._field = _core.SurfaceField(scene, list(set), states, threads)

    def __repr__(self) -> str:
        return f"<forefeel.SurfaceField: {len(self.sites)} sites>"

    @property
    def sites(self) -> NDArray[np.float64]:
        """(n, 3) [m]"""
        return self._field.sites

    @property
    def depth(self) -> float:
        """[m]"""
        return self._field.depth

    def evaluate(self, sites: ArrayLike, displacements: ArrayLike) -> FieldForces:
        """sites: (n, 3), or (3,) for all; places near the surface. displacements of the tip there: (n, 3) [m]."""
        return FieldForces(*self._field._evaluate(numbers(sites, "sites"), numbers(displacements, "displacements")))

    def solve(self, sites: ArrayLike, displacements: ArrayLike) -> NDArray[Any]:
        """Exact states (n,), solved straight from rest, with `state_dtype`; arguments as of evaluate()."""
        return self._field._solve(numbers(sites, "sites"), numbers(displacements, "displacements"))

    def stiffness(self, sites: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """At rest: of body and pad (n, 3, 3) [N/m], and the mean normal under the pad (n, 3)."""
        return self._field._rest(numbers(sites, "sites"))
