"""Bodies and scenes: exact forces, lattices of states, haptic sessions."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from .arrays import Table, node_set, numbers, whole_numbers
from .states import States, known_rows

Progress = Callable[[float], Any]


class Body:
    """What is pressed: a tetrahedral mesh with material, clamped nodes, and a contact with the tip: nodes that move with
    it, or a compliant pad.

    nodes    (v, 3): rest positions [m]
    tets     (t, 4): numbers of nodes, from 0
    clamp    numbers of the nodes that never move, or a mask (v,) of True and False
    contact  numbers of the nodes that move by the position of the tip, or a mask; none with a pad
    law      "linear", "st-venant-kirchhoff", "neo-hookean", "stable-neo-hookean" or "mooney-rivlin"
    young    Young's modulus at small strain, of every law: at rest its stiffness is that of the linear law [Pa]
    poisson  Poisson's ratio at small strain, of every law, in (-1, 0.5)
    element  "linear", or "quadratic", which does not lock above a ratio of 0.45
    pad      dict: springs between the surface and the tip, about a fingertip, in place of contact nodes:
               nearest    (3,): a place; the pad is at the point of the surface that is nearest to it [m]
               radius     of the springs, 0.02 if absent [m]
               stiffness  sum of the springs on a flat surface, 1000 if absent [N/m]
    """

    def __init__(self, nodes: ArrayLike, tets: ArrayLike, clamp: ArrayLike, contact: ArrayLike = (),
                 law: str = "neo-hookean", young: float = 5e3, poisson: float = 0.45,
                 element: str = "linear", pad: Mapping[str, Any] | None = None) -> None:
        if isinstance(nodes, _core.Body):
            self._body = nodes
            return
        nodes = numbers(nodes, "nodes")
        self._body = _core.Body(nodes, whole_numbers(tets, "tets"), node_set(clamp, len(nodes), "clamp"),
                                node_set(contact, len(nodes), "contact"), law, young, poisson, element,
                                dict(pad) if isinstance(pad, Mapping) else pad)

    @classmethod
    def _of(cls, body: _core.Body) -> Body:
        made = cls.__new__(cls)
        made._body = body
        return made

    def __repr__(self) -> str:
        return f"<forefeel.Body: {len(self.nodes)} nodes, {len(self.tets)} tetrahedra>"

    @property
    def nodes(self) -> NDArray[np.float64]:
        """(v, 3): rest positions [m]"""
        return self._body.nodes

    @property
    def tets(self) -> NDArray[np.int32]:
        """(t, 4): numbers of nodes; positive volume"""
        return self._body.tets

    @property
    def clamp(self) -> NDArray[np.int32]:
        """Numbers of the clamped nodes, sorted."""
        return self._body.clamp

    @property
    def contact(self) -> NDArray[np.int32]:
        """Numbers of the contact nodes, sorted; none with a pad."""
        return self._body.contact

    @property
    def pad(self) -> dict[str, Any] | None:
        """The pad, as it is given to Body(), with nearest on the surface; None: the contact is nodes."""
        return self._body.pad

    @property
    def warnings(self) -> list[str]:
        """Reasons why its forces may be inaccurate, such as locking."""
        return self._body.warnings

    def keys(self) -> tuple[str, ...]:
        return ("nodes", "tets", "clamp", "contact")

    def __getitem__(self, key: str) -> NDArray[Any]:
        if key not in self.keys():
            raise KeyError(key)
        return getattr(self, key)

    def solve(self, positions: ArrayLike, displacements: bool = False, spacing: float = 0.006,
              progress: Progress | None = None, jet: int = 1) -> Any:
        """Exact states at positions (n, 3) [m], on all cores: a structured array (n,). With displacements=True also
        (n, v, 3) [m]. With jet=2, 3 or 4, the order of the force about a state, also a list (n) of energy jets: dict
        {"e300": …, "limit": …} of the coefficients of dx^a dy^b dz^c [J/m^(a+b+c)] and of how far the material allows
        it [m]; None where a solve failed. Each state is reached straight from rest in steps of at most `spacing` [m].
        Ctrl-C ends it."""
        return self._body.solve(numbers(positions, "positions"), spacing, displacements, progress, jet)

    def generate(self, spacing: float, box: ArrayLike, threads: int = 0, progress: Progress | None = None) -> States:
        """All states of the lattice {k spacing} in the box (2, 3) [m], sorted by position. threads 0: all cores.
        progress(share) is called a few times a second; Ctrl-C ends it."""
        array = self._body.generate(spacing, numbers(box, "box"), threads, progress)
        return States(array, spacing, numbers(box, "box").copy(), {}, {})


class Run:
    """Result of a session.

    frames, dispatches, switches  Tables with all columns of frames.csv, dispatch.csv and switches.csv, also those that a
                 file leaves out; a word is its number (255: none). pandas.DataFrame(run.frames) has their names
    fields       for each of the three, a tuple of (field, columns of the file, unit, meaning); a field of several columns
                 is a vector, run.frames["rendered"] (n, 3)
    states       structured array with `state_dtype`: known at its end
    summary      dict with the keys of summary.json
    interrupted  True: Ctrl-C ended it
    """

    def __init__(self, run: Any) -> None:
        self._run = run
        self.fields = dict(zip(("frames", "dispatches", "switches"), _core._run_fields))
        self.frames, self.dispatches, self.switches = (
            Table.of(getattr(run, name), fields) for name, fields in self.fields.items())
        self.states = run.states
        self.summary: dict[str, Any] = json.loads(run._summary)
        self.interrupted: bool = run.interrupted

    def __repr__(self) -> str:
        return f"<forefeel.Run: {len(self.frames)} frames, {len(self.dispatches)} dispatches>"

    def write(self, folder: Any) -> None:
        """Writes frames.csv, dispatch.csv and switches.csv into a folder, as `forefeel session` does."""
        self._run.write(folder)


class Scene:
    """A scene file (TOML). set: overrides of keys, as ["material.poisson=0.4"]."""

    def __init__(self, file: Any, set: Iterable[str] = ()) -> None:
        self._scene = _core.Scene(file, list(set))

    def __repr__(self) -> str:
        return f"<forefeel.Scene {self.file}>"

    @property
    def file(self) -> str:
        return self._scene.file

    @property
    def spacing(self) -> float:
        """Spacing of the lattice of states [m]."""
        return self._scene.spacing

    @property
    def box(self) -> NDArray[np.float64]:
        """(2, 3): where states are placed [m]"""
        return self._scene.box

    @property
    def warnings(self) -> list[str]:
        return self._scene.warnings

    @property
    def identity(self) -> dict[str, str]:
        """Identity of the body that its states belong to."""
        return self._scene.identity

    @property
    def body(self) -> Body:
        """Its mesh, material, clamped nodes, and contact nodes or pad."""
        return Body._of(self._scene._body())

    def solve(self, positions: ArrayLike, displacements: bool = False, progress: Progress | None = None,
              jet: int = 1) -> Any:
        """Exact states at positions (n, 3) [m], on all cores: a structured array (n,). With displacements=True also
        (n, v, 3) [m], with jet=2, 3 or 4 also a list of energy jets, as Body.solve(). Same states as `forefeel solve`.
        Ctrl-C ends it."""
        return self._scene._body().solve(numbers(positions, "positions"), self.spacing, displacements, progress, jet)

    def generate(self, spacing: float | None = None, threads: int = 0, progress: Progress | None = None) -> States:
        """All states of the lattice in the box, sorted by position. spacing [m], None: the scene's; threads 0: all
        cores. progress(share) is called a few times a second; Ctrl-C ends it. Same states as `forefeel generate`."""
        spacing, box = self._scene._lattice(spacing)
        array = self._scene._body().generate(spacing, box, threads, progress)
        return States(array, spacing, box, self.identity, {})

    def session(self, progress: Progress | None = None, **options: Any) -> Run:
        """A haptic session. Options as of `forefeel session`, by the same names: clock, seconds, device, policy,
        predictor, workers, cost, latency, switch, select, seed, threads, arrivals, replay; states: States,
        structured array or file known at the start; positions alone are refused. extend=True: new states are appended
        to that file; foreign=True: the states are of another body and alone are rendered. progress(share) is called
        meanwhile; Ctrl-C ends it.

        policy, predictor and device may also be Python objects:
          policy.prioritise(candidates, view) -> (n,) priorities >= 0; the largest is solved next. candidates:
            structured array with candidate_dtype. view: PlannerView. Called once per planning step; with
            reads_pending = True also after each dispatch; with reads_regions = True candidates carry labels.
          predictor.observe(t, at, velocity), predictor.predict(horizon) -> (at, deviation)
          device.position(t, force) -> (3,), at rest for t = 0; duration [s] and force_limit [N] if it has them
        Under the virtual clock the same options give the same arrays, bit by bit.
        """
        states = options.get("states")
        if isinstance(states, (str, os.PathLike)):
            options["states"] = os.fspath(states)
        elif states is not None:
            options["states"] = known_rows(states)
        return Run(_core._run_session(self._scene, progress, options))


def solve(what: Scene | Body, positions: ArrayLike, displacements: bool = False, jet: int = 1) -> Any:
    """Exact states of a Scene or Body at positions (n, 3) [m]: a structured array (n,); with displacements=True also
    (n, v, 3) [m]; with jet=2, 3 or 4 also a list of energy jets, as Body.solve()."""
    return what.solve(positions, displacements, jet=jet)


def generate(what: Scene | Body, spacing: float | None = None, box: ArrayLike | None = None,
             progress: Progress | None = None) -> States:
    """All states of a lattice: of a Scene (its own box and spacing), or of a Body in a box (2, 3) [m]."""
    if isinstance(what, Scene):
        if box is not None:
            raise _core.InputError("box: a scene has its own, expected none")
        return what.generate(spacing, progress=progress)
    if spacing is None or box is None:
        raise _core.InputError("generate: a body needs spacing [m] and box (2, 3) [m]")
    return what.generate(spacing, box, progress=progress)
