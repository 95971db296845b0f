"""Sinew in Python: rigs, dynamics, evaluation of control, shows and boards of animatronic figures.

The functions call the same Rust code as the command ``sinew``.

Conventions of all functions:

- Units are SI (m, kg, s, N, N m) and radians. Quaternions are unit quaternions ``x y z w``. ``y`` points up; a file
  with another up axis is rotated when it is read.
- Arrays contain float64. Dynamics, errors and trackers compute in float32, as a board does: expect a relative error of
  about 1e-6. Kinematics compute in float64.
- Functions accept one row, or many rows with time as the first axis, and return as many rows. One call with many rows
  is faster than many calls.
- A pose has seven numbers: position ``x y z``, then the quaternion. A velocity has six: linear, then angular.
- Wrong input, including NaN and infinity, raises ``ValueError`` with the message of the command ``sinew``.
- Long work releases Python's global lock. Ctrl-C ends it.

>>> import sinew_motion as sm
>>> arm = sm.Rig.arm(6)
>>> arm.nq, arm.nv, len(arm.body_names)
(6, 6, 7)
>>> arm.gravity(arm.home).shape
(6,)
"""

from importlib.metadata import PackageNotFoundError, version

from ._board import Board, BoardError, BoardFault, BoardState, Console
from ._clip import Clip, read_clip
from ._errors import StateErrors, errors
from ._evaluation import evaluate, methods, sweep
from ._metrics import Geodesic, geodesic, importance, pose_distance
from ._rig import Rig
from ._show import Retargeted, Show, bake, map, retarget
from ._tracker import Step, Tracker

try:
    __version__ = version("sinew-motion")
except PackageNotFoundError:
    __version__ = "0"

__all__ = [
    "Board",
    "BoardError",
    "BoardFault",
    "BoardState",
    "Clip",
    "Console",
    "Geodesic",
    "Retargeted",
    "Rig",
    "Show",
    "StateErrors",
    "Step",
    "Tracker",
    "bake",
    "errors",
    "evaluate",
    "geodesic",
    "importance",
    "map",
    "methods",
    "pose_distance",
    "read_clip",
    "retarget",
    "sweep",
]
