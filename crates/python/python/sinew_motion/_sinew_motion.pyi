"""The native part: no stable interface. The modules beside it check shapes and have the documentation."""

import builtins
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Excess = tuple[str, str, float, float, float, float, float]

class NativeRig:
    name: str
    notes: list[str]
    nq: int
    nv: int
    body_names: list[str]
    joint_names: list[str]
    dof_names: list[str]
    joint_kinds: list[str]
    parents: list[int | None]
    followers: list[tuple[int, int, float, float]]
    def toml(self) -> str: ...
    def home(self) -> list[float]: ...
    def mass_kg(self) -> list[float]: ...
    def lower(self) -> list[float]: ...
    def upper(self) -> list[float]: ...
    def speed(self) -> list[float]: ...
    def acceleration(self) -> list[float]: ...
    def effort(self) -> list[float]: ...
    def fk(self, q: Array) -> Array: ...
    def jacobian(self, q: Array, body: int, point: tuple[float, ...]) -> Array: ...
    def inverse_dynamics(self, q: Array, qd: Array, qdd: Array) -> Array: ...
    def forward_dynamics(self, q: Array, qd: Array, tau: Array) -> Array: ...
    def mass_matrix(self, q: Array) -> Array: ...

class NativeClip:
    name: str
    notes: list[str]
    joint_names: list[str]
    parents: list[int | None]
    rate_hz: float
    start_s: float
    frame_count: int
    def offsets(self) -> Array: ...
    def local(self) -> Array: ...
    def world(self) -> Array: ...

class NativeShow:
    bytes: builtins.bytes
    excesses: list[Excess]
    fitted: str | None
    duration_s: float
    rate_hz: float
    is_loop: bool
    rig_crc: int
    cues: list[tuple[str, float]]
    def sample(self, times_s: list[float]) -> tuple[Array, Array, Array]: ...

class NativeTracker:
    def __init__(self, rig: NativeRig, settings: str, rate_hz: float, latency_ticks: int) -> None: ...
    def step(
        self, q_desired: Array, qd_desired: Array, qdd_desired: Array, q: Array, qd: Array | None
    ) -> tuple[list[float], list[float], list[str | None]]: ...
    def skip(self, ticks: int) -> None: ...

def load_rig(
    path: str,
    base: str | None,
    rotors: bool,
    repair_inertia: bool,
    metres_per_unit: float | None,
    up: str | None,
) -> NativeRig: ...
def new_arm(joints: int) -> NativeRig: ...
def new_face() -> NativeRig: ...
def read_clip(
    path: str, cutoff_hz: float | None, seconds: float | None, metres_per_unit: float | None, up: str | None
) -> NativeClip: ...
def map(clip: NativeClip, rig: NativeRig) -> str: ...
def retarget(
    clip: NativeClip, rig: NativeRig, mapping: str | None, mirror: bool
) -> tuple[Array, float, float]: ...
def bake(
    source: NativeClip | str | Array,
    rig: NativeRig,
    rate_hz: float | None,
    mapping: str | None,
    mirror: bool,
    fit: bool,
    loop_blend_s: float | None,
    tolerance_rad: float,
    cues: list[tuple[str, float]],
) -> NativeShow: ...
def open_show(bytes: bytes) -> NativeShow: ...
def errors(
    method: str,
    bodies: int,
    desired: Array,
    measured: Array,
    desired_velocity: Array | None,
    measured_velocity: Array | None,
    parents: list[int | None] | None,
    rig: NativeRig | None,
    beta: float,
) -> Array: ...
def pose_distance(
    clip: NativeClip, a: Array, b: Array, metric: str, weighted: bool, steps: int, root: str | None
) -> Array: ...
def geodesic(
    clip: NativeClip, a: Array, b: Array, weighted: bool, steps: int
) -> tuple[float, float, bool, Array]: ...
def importance(
    source: NativeRig | NativeClip | str, method: str, base: float | None, discount: float
) -> tuple[list[str], list[float]]: ...
def methods() -> list[tuple[str, str]]: ...
def evaluate(
    clips: list[str],
    rig: NativeRig | None,
    methods: list[str] | None,
    scales: list[float],
    setup: str,
    seconds: float | None,
    rate_hz: float | None,
    mapping: str | None,
    progress: Callable[[int, int], Any] | None,
) -> tuple[str, str, str]: ...
def sweep(
    file: str,
    clips: list[str],
    rig: NativeRig | None,
    seconds: float | None,
    rate_hz: float | None,
    mapping: str | None,
    output: str | None,
    progress: Callable[[int, int], Any] | None,
) -> tuple[str, str]: ...
