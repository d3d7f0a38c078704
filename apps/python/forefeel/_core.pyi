from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

class InputError(ValueError): ...

class Thresholds:
    safe_spread: float
    safe_cone_radius: float
    safe_angle_deg: float
    sparse_distance: float
    gap_cone_radius: float
    gap_angle_deg: float

class Model:
    kernel: str
    degree: int
    is_tangent: bool
    force_bound: float
    trust_distance: float
    hold_distance: float
    states: NDArray[np.int64]
    def force(self, points: ArrayLike) -> NDArray[np.float64]: ...
    def jacobian(self, points: ArrayLike) -> NDArray[np.float64]: ...

class PlannerView:
    now: float
    hip: NDArray[np.float64]
    velocity: NDArray[np.float64]
    predicted: NDArray[Any]
    solve_seconds: float
    workers: int
    pending: NDArray[np.float64]
    spacing: float
    space: StateSpace
    def prioritise(self, policy: str, candidates: NDArray[Any]) -> NDArray[np.float64]: ...

class Body:
    nodes: NDArray[np.float64]
    tets: NDArray[np.int32]
    clamp: NDArray[np.int32]
    contact: NDArray[np.int32]
    warnings: list[str]
    def __init__(self, nodes: ArrayLike, tets: ArrayLike, clamp: ArrayLike, contact: ArrayLike, law: str,
                 young: float, poisson: float, element: str) -> None: ...
    def solve(self, positions: ArrayLike, spacing: float, displacements: bool,
              progress: Callable[[float], Any] | None) -> Any: ...
    def generate(self, spacing: float, box: ArrayLike, threads: int,
                 progress: Callable[[float], Any] | None) -> NDArray[Any]: ...

class Scene:
    file: str
    spacing: float
    box: NDArray[np.float64]
    warnings: list[str]
    identity: dict[str, str]
    def __init__(self, file: Any, set: list[str] = ...) -> None: ...
    def _body(self) -> Body: ...
    def _lattice(self, spacing: float | None) -> tuple[float, NDArray[np.float64]]: ...

class StateSpace:
    spacing: float
    box: NDArray[np.float64]
    states: NDArray[Any]
    rows: NDArray[np.int64]
    def __init__(self, states: NDArray[Any], spacing: float | None = ..., thresholds: Thresholds = ...) -> None: ...
    def __len__(self) -> int: ...
    def label(self, points: ArrayLike) -> NDArray[np.uint8]: ...
    def spread(self, points: ArrayLike) -> NDArray[np.float64]: ...
    def distance(self, points: ArrayLike) -> NDArray[np.float64]: ...
    def nearest(self, points: ArrayLike, n: int = ...) -> tuple[NDArray[np.int64], NDArray[np.float64]]: ...

state_dtype: np.dtype[Any]
candidate_dtype: np.dtype[Any]
status_names: tuple[str, ...]
label_names: tuple[str, ...]
dispatch_status_names: tuple[str, ...]
switch_cause_names: tuple[str, ...]

def classify(positions: ArrayLike, points: ArrayLike, spacing: float | None = ...) -> NDArray[np.uint8]: ...
def evaluate(positions: ArrayLike, forces: ArrayLike, points: ArrayLike, stiffness: ArrayLike | None = ...,
             **options: Any) -> tuple[NDArray[np.float64], dict[str, Any]]: ...
def evaluate_in(space: StateSpace, points: ArrayLike, **options: Any) -> tuple[NDArray[np.float64], dict[str, Any]]: ...
def estimated_errors(space: StateSpace, points: ArrayLike, floor: float = ...) -> NDArray[np.float64]: ...
def model_at(space: StateSpace, hip: ArrayLike, **options: Any) -> Model: ...
def measured(positions: ArrayLike, forces: ArrayLike, stiffness: ArrayLike | None = ...) -> NDArray[Any]: ...
def read_states(file: Any) -> dict[str, Any]: ...
def write_states(file: Any, states: NDArray[Any], spacing: float) -> None: ...
def read_mesh(file: Any) -> dict[str, Any]: ...
def register_policy(name: str, factory: Callable[..., Any]) -> None: ...
def _command(words: list[str]) -> int: ...
def _run_session(scene: Scene, progress: Callable[[float], Any] | None, options: dict[str, Any]) -> Any: ...
