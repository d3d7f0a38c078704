"""Haptic rendering of soft bodies, solved before the hand arrives.

Positions are displacements of the haptic interaction point (HIP, the tip) from rest, in the axes of the mesh.
Units are SI: m, N, N/m, J, s. Arrays of positions have the shape (n, 3). States are structured arrays with
`state_dtype`. Labels are uint8: SAFE 0, SPARSE 1, GAP 2, BLANK 3.

    import forefeel as ff
    labels = ff.classify(positions, points, spacing=0.006)       # which places are known how well
    ff.StateSpace(positions).coverage().volume                    # how much of each label
    there = ff.evaluate(positions, forces, points)                # the force between and beyond states
    bars = ff.error_bar(positions, forces, points, level=0.95)    # and how far it may be off [N]
    scene = ff.Scene("liver.toml")
    exact = scene.solve([[0, 0, -0.01]])["force"]                 # one exact force, slow
    run = scene.session(clock="virtual", seconds=5, policy=MyPolicy())
    run.frames["rendered"], run.summary["error"]["p95"]
    field = ff.SurfaceField("anywhere.toml")                      # a body that is touched anywhere
    field.evaluate([0.1, 0.02, 0.04], [[0, 0, -0.01]]).force
    ff.read("run/")                                               # any file or folder that the command wrote

Errors of input are InputError (a ValueError) with the command's own line.
"""

import pathlib as _pathlib
import re as _re
import sys as _sys


def _check_version():
    """The compiled module serves one version of Python. Also an older Python must be able to read these lines."""
    names = [_re.match(r"_core\.cpython-(\d)(\d+)", file.name) for file in _pathlib.Path(__file__).parent.glob("_core.*")]
    built = [".".join(name.groups()) for name in names if name]
    this = "%d.%d" % _sys.version_info[:2]
    if built and this not in built:
        raise ImportError(f"forefeel was built for Python {' and '.join(built)}, this is Python {this} "
                          f"({_sys.executable}); start python{built[-1]}, or configure the build with "
                          f"-DPython_EXECUTABLE={_sys.executable}")


_check_version()
try:
    import numpy as _numpy  # noqa: F401
except ImportError:
    raise ImportError(f"forefeel needs numpy, which {_sys.executable} does not have (Debian: python3-numpy, for "
                      "/usr/bin/python3)") from None

from ._core import (InputError, Model, PlannerView, Thresholds, candidate_dtype, dispatch_status_names, label_names,
                    register_policy, register_predictor, state_dtype, status_names, switch_cause_names)
from .bodies import Body, Run, Scene, generate, solve
from .commands import command, study
from .field import FieldForces, SurfaceField
from .files import read, read_inputs, read_pvd, read_run, read_study, read_table, read_vtu
from .placement import Placement
from .space import Coverage, StateSpace, classify, error_bar, evaluate, evaluation
from .states import States, measured, read_states, write_states

SAFE, SPARSE, GAP, BLANK = range(4)

__all__ = ["BLANK", "Body", "Coverage", "FieldForces", "GAP", "InputError", "Model", "Placement", "PlannerView", "Run",
           "SAFE", "SPARSE", "Scene", "StateSpace", "States", "SurfaceField", "Thresholds", "candidate_dtype",
           "classify", "command", "dispatch_status_names", "error_bar", "evaluate", "evaluation", "generate",
           "label_names", "measured", "read", "read_inputs", "read_pvd", "read_run", "read_states", "read_study",
           "read_table", "read_vtu", "register_policy", "register_predictor", "solve", "state_dtype", "status_names",
           "study", "switch_cause_names", "write_states"]
