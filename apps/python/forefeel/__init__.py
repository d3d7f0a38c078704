"""Haptic rendering of soft bodies, solved before the hand arrives.

Positions are displacements of the haptic interaction point (HIP, the tip) from rest, in the axes of the mesh.
Units are SI: m, N, N/m, J, s. Arrays of positions have the shape (n, 3). States are structured arrays with
`state_dtype`. Labels are uint8: SAFE 0, SPARSE 1, GAP 2, BLANK 3.

    import forefeel as ff
    labels = ff.classify(positions, points, spacing=0.006)       # which places are known how well
    forces = ff.evaluate(positions, forces, points)               # the force between and beyond states
    scene = ff.Scene("liver.toml")
    run = scene.session(clock="virtual", seconds=5, policy=MyPolicy())
    run.frames["rendered"], run.summary["error"]["p95"]
"""

import json as _json
import os as _os
import pathlib as _pathlib
import sys as _sys
import tempfile as _tempfile

import numpy as _np

from . import _core
from ._core import (InputError, Model, PlannerView, StateSpace as _StateSpace, Thresholds, candidate_dtype,
                    dispatch_status_names, label_names, register_policy, state_dtype, status_names, switch_cause_names)
from .files import read_run, read_table
from .placement import Placement

SAFE, SPARSE, GAP, BLANK = range(4)

__all__ = ["BLANK", "GAP", "InputError", "Model", "Placement", "PlannerView", "Run", "SAFE", "SPARSE", "Scene",
           "StateSpace", "States", "Thresholds", "candidate_dtype", "classify", "command", "dispatch_status_names",
           "evaluate", "evaluation", "label_names", "measured", "read_run", "read_states", "read_table",
           "register_policy", "state_dtype", "status_names", "study", "switch_cause_names", "write_states"]


class States:
    """States with what their file says about them.

    array     structured array with `state_dtype`
    spacing   of a full lattice [m]; nan if unknown
    box       (2, 3): low and high corner [m]
    identity  dict: the body that the states belong to; empty for measured states
    notes     dict of texts
    damaged   number of rows of the file that could not be read
    """

    def __init__(self, array, spacing, box, identity, notes, damaged=0):
        self.array, self.spacing, self.box = array, spacing, box
        self.identity, self.notes, self.damaged = identity, notes, damaged

    def __len__(self):
        return len(self.array)

    def __repr__(self):
        return f"<forefeel.States: {len(self)} states, spacing {self.spacing:g} m>"

    @property
    def usable(self):
        """Mask (n,) of the states that converged or were measured."""
        good = [status_names.index("converged"), status_names.index("measured")]
        return _np.isin(self.array["status"], good)

    def to_frame(self):
        """A pandas DataFrame with one column for each number, as `forefeel export` writes them."""
        import pandas
        columns = {}
        for field, name in (("at", "{}"), ("force", "f{}")):
            for i, axis in enumerate("xyz"):
                columns[name.format(axis)] = self.array[field][:, i]
        for i in range(3):
            for j in range(3):
                columns[f"k{i + 1}{j + 1}"] = self.array["stiffness"][:, i, j]
        for field in ("energy", "spacing", "residual", "seconds", "min_jacobian", "iterations", "multivalued"):
            columns[field] = self.array[field]
        columns["status"] = _np.array(status_names)[self.array["status"]]
        return pandas.DataFrame(columns)


def read_states(file):
    """Reads a .states file or a CSV of states. Returns States. InputError names the file and what is wrong."""
    return States(array=(read := _core.read_states(file))["states"], spacing=read["spacing"], box=read["box"],
                  identity=read["identity"], notes=read["notes"], damaged=read["damaged"])


def write_states(file, states, spacing):
    """Writes a new .states file. states: structured array; spacing of a full lattice [m]. An existing file is
    refused."""
    _core.write_states(file, _rows(states), spacing)


def measured(positions, forces, stiffness=None):
    """States from measured values: positions (n, 3) [m], forces (n, 3) [N], stiffness (n, 3, 3) [N/m] or None.
    Returns a structured array."""
    return _core.measured(positions, forces, stiffness)


def classify(positions, points, spacing=None):
    """Labels of points from the positions of known states: uint8 (m,), 0 safe, 1 sparse, 2 gap, 3 blank.

    positions (n, 3) [m]; points (m, 3) [m]; spacing that counts as dense [m], None: the median distance of the
    states to their nearest neighbour. Same labels as `forefeel classify`.
    """
    return _core.classify(positions, points, spacing)


def evaluate(positions, forces, points, stiffness=None, **options):
    """Forces (m, 3) [N] at points (m, 3) [m], approximated from states at positions (n, 3) [m].

    forces (n, 3) [N]; stiffness (n, 3, 3) [N/m] with K = -df/dx, or None. Options as of `forefeel evaluate`:
    method, kernel, data, neighbours, select, ridge (a number or "auto"), spacing [m]. Same forces as the command.
    States without stiffness have method="auto" if nothing is given: it chooses kernel, neighbours and ridge by
    leaving out groups of neighbouring states; evaluation() says what it chose.
    """
    return _core.evaluate(positions, forces, points, stiffness, **options)[0]


def evaluation(positions, forces, points, stiffness=None, **options):
    """evaluate(), and a dict of what was used: method, kernel, data, neighbours, ridge, spacing [m], averaged (states
    that contradicted another at their position), and for method "auto" expected_error {p50, p95} [N]."""
    return _core.evaluate(positions, forces, points, stiffness, **options)


class StateSpace:
    """Known states, indexed by position. Made once; every method is vectorised and uses all cores.

    states      structured array, States, or positions (n, 3) [m]
    spacing     that counts as dense [m]; None: the median distance of states
    thresholds  of the labels
    """

    def __init__(self, states, spacing=None, thresholds=None):
        if isinstance(states, _StateSpace):
            self._space = states
            return
        if spacing is None and isinstance(states, States) and _np.isfinite(states.spacing):
            spacing = states.spacing
        self._space = _StateSpace(_rows(states), spacing, thresholds or Thresholds())

    def __len__(self):
        return len(self._space)

    @property
    def spacing(self):
        """[m]"""
        return self._space.spacing

    @property
    def box(self):
        """(2, 3): low and high corner of the states [m]"""
        return self._space.box

    @property
    def states(self):
        """Structured array of the states, by their numbers."""
        return self._space.states

    def label(self, points):
        """uint8 (m,): 0 safe, 1 sparse, 2 gap, 3 blank"""
        return self._space.label(points)

    def spread(self, points):
        """(m,) [m]: sqrt(R^2 - |q - c|^2) in the Delaunay cell of q; inf outside the hull of the states"""
        return self._space.spread(points)

    def distance(self, points):
        """(m,) [m]: to the nearest state"""
        return self._space.distance(points)

    def nearest(self, points, n=1):
        """Numbers int64 (m, n) and distances (m, n) [m] of the n nearest states, by distance."""
        return self._space.nearest(points, n)

    def evaluate(self, points, **options):
        """Forces (m, 3) [N]; each point has the model of its own neighbours. Options as of evaluate()."""
        return _core.evaluate_in(self._space, points, **options)[0]

    def model_at(self, hip, **options):
        """The Model around a HIP position (3,) [m]; evaluate it anywhere near."""
        return _core.model_at(self._space, hip, **options)


class Run:
    """Result of a session: structured arrays `frames`, `dispatches`, `switches` and `states`, and `summary`, a
    dict with the keys of summary.json."""

    def __init__(self, run):
        self._run = run
        self.frames, self.dispatches, self.switches = run.frames, run.dispatches, run.switches
        self.states = run.states
        self.summary = _json.loads(run._summary)
        self.interrupted = run.interrupted

    def write(self, folder):
        """Writes frames.csv, dispatch.csv and switches.csv into a folder, as `forefeel session` does."""
        self._run.write(folder)


class Scene:
    """A scene file (TOML). set: overrides of keys, as ["material.poisson=0.4"]."""

    def __init__(self, file, set=()):
        self._scene = _core.Scene(file, list(set))

    def __repr__(self):
        return f"<forefeel.Scene {self.file}>"

    file = property(lambda self: self._scene.file)
    spacing = property(lambda self: self._scene.spacing, doc="of states [m]")
    box = property(lambda self: self._scene.box, doc="(2, 3): where states are placed [m]")
    warnings = property(lambda self: self._scene.warnings)
    identity = property(lambda self: self._scene.identity, doc="dict: the body that its states belong to")
    body = property(lambda self: self._scene._body(),
                    doc="dict: nodes (V, 3) [m], tets (T, 4), clamp and contact: numbers of nodes")

    def solve(self, positions, displacements=False):
        """Exact states at positions (n, 3) [m], on all cores: a structured array. With displacements=True also
        (n, V, 3) [m]."""
        solved = self._scene._solve(positions, displacements)
        return (solved["states"], solved["displacements"]) if displacements else solved["states"]

    def generate(self, spacing=None, threads=0, progress=None):
        """All states of the lattice in the box, sorted by position: States. progress(share) is called meanwhile;
        Ctrl-C ends it."""
        array = self._scene._generate(spacing, threads, progress)
        return States(array, spacing or self.spacing, self.box, self.identity, {})

    def session(self, progress=None, **options):
        """A haptic session: Run. Options as of `forefeel session`, by the same names: clock, seconds, device,
        policy, predictor, workers, cost, latency, switch, select, seed, threads, arrivals, replay; states:
        structured array known at the start.

        policy, predictor and device may also be Python objects:
          policy.prioritise(candidates, view) -> (n,) priorities >= 0; the largest is solved next. candidates:
            structured array with candidate_dtype. view: PlannerView. Called once per planning step; with
            reads_pending = True also after each dispatch; with reads_regions = True candidates carry labels.
          predictor.observe(t, at, velocity), predictor.predict(horizon) -> (at, deviation)
          device.position(t, force) -> (3,), at rest for t = 0; duration [s] and force_limit [N] if it has them
        Under the virtual clock the same options give the same arrays, bit by bit.
        """
        if isinstance(options.get("states"), States):
            options["states"] = options["states"].array
        return Run(_core._run_session(self._scene, progress, options))


def command(*words):
    """Runs `forefeel WORDS` in this process, where parts registered from Python are known. Returns what it printed
    on stdout and its exit code; bad input raises InputError."""
    _sys.stdout.flush()
    with _tempfile.TemporaryFile() as printed:
        kept = _os.dup(1)
        try:
            _os.dup2(printed.fileno(), 1)
            code = _core._command([str(word) for word in words])
        finally:
            _os.dup2(kept, 1)
            _os.close(kept)
        printed.seek(0)
        return printed.read().decode(), code


def study(file, folder, set=()):
    """Runs a study (TOML) into a folder; a rerun resumes. Returns a dict: `cells`, a pandas DataFrame of cells.csv
    where pandas is installed, else a dict of arrays; `ranking` and the other keys of `forefeel study --json`.
    Policies added with register_policy(name, factory) are known to it."""
    flags = [word for override in set for word in ("--set", override)]
    text, code = command("study", file, "-o", folder, "--json", "--quiet", *flags)
    if code != 0:
        raise RuntimeError(f"{file}: the study ended with exit code {code}")
    result = _json.loads(text)
    cells = _pathlib.Path(folder) / "cells.csv"
    try:
        import pandas
        result["cells"] = pandas.read_csv(cells)
    except ImportError:
        result["cells"] = read_table(cells)
    return result


def _rows(states):
    if isinstance(states, States):
        return states.array
    states = _np.asarray(states)
    if states.dtype.names:
        return states
    return _core.measured(states, _np.zeros_like(states, dtype=float), None)
