"""Rigs, their names and limits, kinematics and dynamics."""

from __future__ import annotations

import os
from typing import Literal

import numpy as np
import numpy.typing as npt

from . import _sinew_motion as _native
from ._arrays import Array, rows, same_rows


class Rig:
    """A rig: bodies in a tree, joints, limits, drives and servos.

    ``Rig.load`` reads a file; ``Rig.arm`` and ``Rig.face`` create example rigs.

    Positions ``q`` have ``nq`` numbers in the order of the joints: an angle or a distance for each axis, a quaternion
    ``x y z w`` for a ball joint, and for a free joint (the base of a rig that travels) a quaternion, then ``x y z``.
    Speeds ``qd``, accelerations ``qdd`` and efforts ``tau`` have ``nv`` numbers, one for each dof. A ball joint has
    three dofs: its angular velocity in body axes. A free joint has six: angular, then linear velocity, in body axes.

    >>> arm = Rig.arm(6)
    >>> arm.dof_names[:2]
    ['turn1', 'bend2']
    """

    def __init__(self, native: _native.NativeRig) -> None:
        self._native = native

    @classmethod
    def load(
        cls,
        path: str | os.PathLike[str],
        *,
        base: Literal["stand", "driven"] | None = None,
        rotors: bool = True,
        repair_inertia: bool = False,
        metres_per_unit: float | None = None,
        up: Literal["x", "y", "z"] | None = None,
    ) -> Rig:
        """Reads a rig: rig.toml, URDF or MJCF, recognized by its content.

        Parameters
        ----------
        path : file
        base : ``"stand"`` holds the base, ``"driven"`` lets it travel; default: as in the file
        rotors : whether dynamics include the inertia that rotors add to dofs
        repair_inertia : whether impossible inertia of a URDF or MJCF is replaced instead of refused
        metres_per_unit, up : unit of length and up axis of a URDF or MJCF; default: found from the file

        Raises
        ------
        ValueError
            If the file cannot be read; the message contains file, line and the expected content.

        >>> import pathlib, tempfile
        >>> folder = tempfile.TemporaryDirectory()
        >>> path = pathlib.Path(folder.name) / "rig.toml"
        >>> Rig.arm(4).save(path)
        >>> Rig.load(path).nq
        4
        >>> Rig.load("no.toml")
        Traceback (most recent call last):
            ...
        ValueError: no.toml: No such file or directory (os error 2)
        """
        return cls(_native.load_rig(os.fspath(path), base, rotors, repair_inertia, metres_per_unit, up))

    @classmethod
    def arm(cls, joints: int = 6) -> Rig:
        """Creates the desk arm of ``sinew rig new --arm``, with 1 to 40 joints.

        >>> Rig.arm(3).joint_names
        ['base', 'turn1', 'bend2', 'bend3']
        """
        return cls(_native.new_arm(joints))

    @classmethod
    def face(cls) -> Rig:
        """Creates the face of ``sinew rig new --face``: jaw, eyes, lids, brows and neck, without masses.

        >>> Rig.face().nv
        14
        """
        return cls(_native.new_face())

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the rig as a rig.toml.

        >>> import pathlib, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = pathlib.Path(folder) / "arm.toml"
        ...     Rig.arm(2).save(path)
        ...     Rig.load(path).nv
        2
        """
        with open(path, "w", encoding="utf-8") as file:
            file.write(self._native.toml())

    def __repr__(self) -> str:
        return f"Rig({self.name!r}, nq={self.nq}, nv={self.nv}, bodies={len(self.body_names)})"

    @property
    def name(self) -> str:
        """The name in the file."""
        return self._native.name

    @property
    def notes(self) -> list[str]:
        """Sentences about everything that an import changed or filled in, and about doubtful values."""
        return self._native.notes

    @property
    def nq(self) -> int:
        """The number of positions."""
        return self._native.nq

    @property
    def nv(self) -> int:
        """The number of dofs, which is the number of speeds, accelerations and efforts."""
        return self._native.nv

    @property
    def body_names(self) -> list[str]:
        """The names of the bodies, parents first. Bodies on fixed joints are merged into their parents."""
        return self._native.body_names

    @property
    def joint_names(self) -> list[str]:
        """The names of the joints that move the bodies; for the base, the name of the body."""
        return self._native.joint_names

    @property
    def joint_kinds(self) -> list[str]:
        """The kinds of the joints: fixed, revolute, prismatic, universal, spherical, free."""
        return self._native.joint_kinds

    @property
    def dof_names(self) -> list[str]:
        """The names of the ``nv`` dofs."""
        return self._native.dof_names

    @property
    def parents(self) -> list[int]:
        """The index of each body's parent; -1 for the base."""
        return [-1 if parent is None else parent for parent in self._native.parents]

    @property
    def crc(self) -> int:
        """The checksum by which shows and boards identify the rig; 0 if no board can hold the rig."""
        return self._native.crc

    @property
    def home(self) -> Array:
        """The home pose, ``(nq,)``."""
        return np.array(self._native.home())

    @property
    def mass(self) -> Array:
        """The masses of the bodies, kg."""
        return np.array(self._native.mass_kg())

    @property
    def lower(self) -> Array:
        """The lower ends of the ranges, ``(nv,)``, rad or m; ``-inf`` if the dof has no range of its own."""
        return np.array(self._native.lower())

    @property
    def upper(self) -> Array:
        """The upper ends of the ranges, ``(nv,)``, rad or m; ``inf`` if the dof has no range of its own."""
        return np.array(self._native.upper())

    @property
    def speed(self) -> Array:
        """The largest commanded speeds, ``(nv,)``, rad/s or m/s; ``inf`` without limit."""
        return np.array(self._native.speed())

    @property
    def acceleration(self) -> Array:
        """The largest commanded accelerations, ``(nv,)``, rad/s² or m/s²; ``inf`` without limit."""
        return np.array(self._native.acceleration())

    @property
    def effort(self) -> Array:
        """The largest efforts, ``(nv,)``, N m or N; ``inf`` without limit."""
        return np.array(self._native.effort())

    @property
    def followers(self) -> list[tuple[int, int, float, float]]:
        """Joints that follow others: index in ``q``, index of the leader in ``q``, factor, offset."""
        return self._native.followers

    def fk(self, q: npt.ArrayLike) -> Array:
        """Computes the poses of all bodies in the world (forward kinematics), in float64.

        Parameters
        ----------
        q : (nq,) or (T, nq)

        Returns
        -------
        (B, 7) or (T, B, 7): position in m, then quaternion ``x y z w``.

        Raises
        ------
        ValueError
            For a wrong length, NaN, or a quaternion that is not unit.

        >>> arm = Rig.arm(6)
        >>> arm.fk(arm.home).shape
        (7, 7)
        >>> arm.fk([arm.home] * 3).shape
        (3, 7, 7)
        >>> arm.fk([0, 0, 0, 0, 0, float("nan")])
        Traceback (most recent call last):
            ...
        ValueError: q[5], of joint 6, is NaN; it must be a number from -1e6 to 1e6
        """
        array, single = rows("q", q)
        poses = self._native.fk(array)
        return poses[0] if single else poses

    def jacobian(
        self, q: npt.ArrayLike, body: str | int, point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    ) -> Array:
        """Computes the velocity of a point of a body for unit speed of each dof, in float64.

        Parameters
        ----------
        q : (nq,) or (T, nq)
        body : name or index of the body
        point : the point in the body's frame, m

        Returns
        -------
        (6, nv) or (T, 6, nv): rows of the linear velocity in m/s, then of the angular velocity in rad/s, in world axes.

        Raises
        ------
        ValueError
            If there is no such body, or as ``fk``.

        >>> arm = Rig.arm(6)
        >>> arm.jacobian(arm.home, "bend2").shape
        (6, 6)
        """
        array, single = rows("q", q)
        jacobians = self._native.jacobian(array, self._body(body), tuple(point))
        return jacobians[0] if single else jacobians

    def inverse_dynamics(self, q: npt.ArrayLike, qd: npt.ArrayLike | None, qdd: npt.ArrayLike | None) -> Array:
        """Computes the efforts that cause accelerations, with gravity of 9.81 m/s² along -y and without friction.

        Many rows in a call take a fraction of the time of a call for each row; the results are identical.

        Parameters
        ----------
        q : (nq,) or (T, nq)
        qd, qdd : (nv,) or (T, nv); ``None`` for zeros. A single row stands for all rows of ``q``.

        Returns
        -------
        (nv,) or (T, nv): N m or N.

        Raises
        ------
        ValueError
            For a wrong length, a number that is not from -1e6 to 1e6, or a quaternion that is not unit.

        >>> import numpy as np
        >>> arm = Rig.arm(6)
        >>> still = arm.inverse_dynamics(arm.home, None, None)
        >>> bool(np.all(still == arm.gravity(arm.home)))
        True
        >>> many = arm.inverse_dynamics(np.tile(arm.home, (5, 1)), None, None)
        >>> bool(np.all(many == still))
        True
        """
        of_row = self._native.inverse_dynamics_of_row(q, qd, qdd)
        if of_row is not None:
            return of_row
        array, single = rows("q", q)
        count = len(array)
        speeds, accelerations = (same_rows(name, of, count, self.nv) for name, of in (("qd", qd), ("qdd", qdd)))
        efforts = self._native.inverse_dynamics(array, speeds, accelerations)
        return efforts[0] if single else efforts

    def gravity(self, q: npt.ArrayLike) -> Array:
        """Computes the efforts that hold the rig at rest.

        Parameters
        ----------
        q : (nq,) or (T, nq)

        Returns
        -------
        (nv,) or (T, nv): N m or N.

        Raises
        ------
        ValueError
            As ``inverse_dynamics``.

        >>> arm = Rig.arm(2)
        >>> arm.gravity(arm.home).shape
        (2,)
        """
        return self.inverse_dynamics(q, None, None)

    def forward_dynamics(self, q: npt.ArrayLike, qd: npt.ArrayLike | None, tau: npt.ArrayLike | None) -> Array:
        """Computes the accelerations that efforts cause, with gravity and without friction.

        Parameters
        ----------
        q : (nq,) or (T, nq)
        qd, tau : (nv,) or (T, nv); ``None`` for zeros. A single row stands for all rows of ``q``.

        Returns
        -------
        (nv,) or (T, nv): rad/s² or m/s².

        Raises
        ------
        ValueError
            As ``inverse_dynamics``.

        >>> import numpy as np
        >>> arm = Rig.arm(6)
        >>> qdd = arm.forward_dynamics(arm.home, None, arm.gravity(arm.home))
        >>> bool(np.all(np.abs(qdd) < 1e-2))
        True
        """
        array, single = rows("q", q)
        count = len(array)
        speeds, efforts = (same_rows(name, of, count, self.nv) for name, of in (("qd", qd), ("tau", tau)))
        accelerations = self._native.forward_dynamics(array, speeds, efforts)
        return accelerations[0] if single else accelerations

    def mass_matrix(self, q: npt.ArrayLike) -> Array:
        """Computes the mass matrix in the space of the dofs.

        Parameters
        ----------
        q : (nq,) or (T, nq)

        Returns
        -------
        (nv, nv) or (T, nv, nv): symmetric, kg m² between turns, kg between slides.

        Raises
        ------
        ValueError
            As ``inverse_dynamics``.

        >>> import numpy as np
        >>> arm = Rig.arm(6)
        >>> inertia = arm.mass_matrix(arm.home)
        >>> bool(np.all(inertia == inertia.T)), bool(np.all(np.linalg.eigvalsh(inertia) > 0))
        (True, True)
        """
        array, single = rows("q", q)
        matrices = self._native.mass_matrix(array)
        return matrices[0] if single else matrices

    def _body(self, body: str | int) -> int:
        if isinstance(body, str):
            names = self.body_names
            if body not in names:
                raise ValueError(f"body: expected one of {', '.join(names)}, found `{body}`")
            return names.index(body)
        if not 0 <= body < len(self.body_names):
            raise ValueError(f"body: expected 0 to {len(self.body_names) - 1}, found {body}")
        return body
