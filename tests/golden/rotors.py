"""Writes rotors.json: dynamics of random rigs whose drives have rotors, computed by MuJoCo and checked by Pinocchio.

    pip install mujoco==4.0.0 pin==4.1.0 numpy
    python rotors.py > rotors.json

README.md beside this file describes the numbers.
"""

import json
import sys

import mujoco
import numpy as np
import pinocchio as pin

GRAVITY = [0.6, -9.2, 1.9]
KINDS = ["revolute", "prismatic", "universal", "spherical", "fixed"]
FREEDOMS = {"revolute": 1, "prismatic": 1, "universal": 2, "spherical": 3, "fixed": 0}
# Largest difference of the two programs, both in f64, relative to the largest number of the state; for accelerations
# multiplied by the condition number of H.
AGREEMENT = 1e-13


def unit(v):
    return np.array(v) / np.linalg.norm(v)


def matrix(quaternion):
    return pin.Quaternion(np.array(quaternion)).toRotationMatrix()


# The rigs


def axes(kind, rng):
    if kind in ("spherical", "fixed"):
        return []
    first = unit(rng.normal(size=3))
    if kind == "universal":
        return [first, unit(np.cross(first, rng.normal(size=3)))]
    return [first]


def rotor(kind, rng):
    """Returns a rotor inertia: zero for one drive in five, otherwise up to far more than the inertia of a link."""
    if kind == "fixed" or rng.random() < 0.2:
        return 0.0
    return float(f"{10 ** rng.uniform(-4, 0.5):.3e}")


def inertia(mass, rng):
    """Returns an inertia about the centre of mass, made from random second moments of mass."""
    moments = rng.uniform(0.0, 0.01, size=3) * mass
    turn = matrix(unit(rng.normal(size=4)))
    return turn @ np.diag(moments.sum() - moments) @ turn.T


def body(index, kind, rng):
    mass = round(rng.uniform(0.05, 2.0), 3)
    return {
        "parent": -1 if index == 0 else int(rng.integers(max(0, index - 4), index)),
        "joint": kind,
        "axes": [axis.tolist() for axis in axes(kind, rng)],
        "offset": rng.uniform(-0.25, 0.25, size=3).round(4).tolist(),
        "rot": unit(rng.normal(size=4)).tolist(),
        "mass": mass,
        "com": rng.uniform(-0.1, 0.1, size=3).round(4).tolist(),
        "inertia": inertia(mass, rng)[np.triu_indices(3)].tolist(),
        "rotor": rotor(kind, rng),
    }


def freedoms(bodies):
    return sum(FREEDOMS[body["joint"]] for body in bodies)


def position(bodies, rng):
    """Returns random positions in the order of the core: angles, displacements, quaternions."""
    q = []
    for body in bodies:
        if body["joint"] == "spherical":
            q += unit(rng.normal(size=4)).tolist()
        else:
            scale = 0.2 if body["joint"] == "prismatic" else 2.0
            q += rng.uniform(-scale, scale, size=FREEDOMS[body["joint"]]).round(4).tolist()
    return q


# The same rig in both programs


class Mujoco:
    def __init__(self, bodies):
        spec = mujoco.MjSpec()
        spec.option.gravity = GRAVITY
        spec.option.disableflags = mujoco.mjtDisableBit.mjDSBL_CONTACT
        made = []
        for index, body in enumerate(bodies):
            parent = spec.worldbody if index == 0 else made[body["parent"]]
            x, y, z, w = body["rot"]
            xx, xy, xz, yy, yz, zz = body["inertia"]
            it = parent.add_body(name=str(index), pos=body["offset"], quat=[w, x, y, z])
            it.explicitinertial = True
            it.mass, it.ipos = body["mass"], body["com"]
            it.fullinertia = [xx, yy, zz, xy, xz, yz]
            kinds = {
                "revolute": mujoco.mjtJoint.mjJNT_HINGE,
                "universal": mujoco.mjtJoint.mjJNT_HINGE,
                "prismatic": mujoco.mjtJoint.mjJNT_SLIDE,
            }
            for number, axis in enumerate(body["axes"]):
                kind = kinds[body["joint"]]
                it.add_joint(name=f"{index}.{number}", type=kind, axis=axis, armature=body["rotor"])
            if body["joint"] == "spherical":
                ball = mujoco.mjtJoint.mjJNT_BALL
                it.add_joint(name=f"{index}.0", type=ball, armature=body["rotor"])
            made.append(it)
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        # MuJoCo numbers bodies depth first. For each of our numbers: its index in MuJoCo's list.
        self.q, self.v = [], []
        for index, body in enumerate(bodies):
            for number in range(max(len(body["axes"]), body["joint"] == "spherical")):
                joint = self.model.joint(f"{index}.{number}")
                q, v = joint.qposadr[0], joint.dofadr[0]
                if body["joint"] == "spherical":
                    self.q += [q + 1, q + 2, q + 3, q]
                    self.v += [v, v + 1, v + 2]
                else:
                    self.q.append(q)
                    self.v.append(v)

    def at(self, q, qd):
        self.data.qpos[self.q] = q
        self.data.qvel[self.v] = qd

    def inverse(self, q, qd, qdd):
        self.at(q, qd)
        self.data.qacc[self.v] = qdd
        mujoco.mj_inverse(self.model, self.data)
        return self.data.qfrc_inverse[self.v].copy()

    def forward(self, q, qd, tau):
        self.at(q, qd)
        self.data.qfrc_applied[self.v] = tau
        mujoco.mj_forward(self.model, self.data)
        return self.data.qacc[self.v].copy()

    def mass_matrix(self, q):
        self.at(q, np.zeros(len(self.v)))
        mujoco.mj_forward(self.model, self.data)
        full = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.data, full)
        return full[np.ix_(self.v, self.v)]


class Pinocchio:
    def __init__(self, bodies):
        self.model = pin.Model()
        self.model.gravity.linear = np.array(GRAVITY)
        # For each body: its joint, and its pose in the joint's frame. A fixed body has the joint of its parent.
        places, armature = [], []
        for index, body in enumerate(bodies):
            joint, place = (0, pin.SE3.Identity()) if index == 0 else places[body["parent"]]
            place = place * pin.SE3(matrix(body["rot"]), np.array(body["offset"]))
            models = {
                "revolute": pin.JointModelRevoluteUnaligned,
                "universal": pin.JointModelRevoluteUnaligned,
                "prismatic": pin.JointModelPrismaticUnaligned,
            }
            made = [models[body["joint"]](*axis) for axis in body["axes"]]
            if body["joint"] == "spherical":
                made = [pin.JointModelSpherical()]
            for number, model in enumerate(made):
                joint = self.model.addJoint(joint, model, place, f"{index}.{number}")
                place = pin.SE3.Identity()
                armature += [body["rotor"]] * model.nv
            upper = np.zeros((3, 3))
            upper[np.triu_indices(3)] = body["inertia"]
            about_center = upper + np.triu(upper, 1).T
            mass = pin.Inertia(body["mass"], np.array(body["com"]), about_center)
            self.model.appendBodyToJoint(joint, mass, place)
            places.append((joint, place))
        self.model.armature = np.array(armature)
        self.data = self.model.createData()

    def inverse(self, q, qd, qdd):
        return pin.rnea(self.model, self.data, np.array(q), qd, qdd).copy()

    def forward(self, q, qd, tau):
        return pin.aba(self.model, self.data, np.array(q), qd, tau).copy()

    def mass_matrix(self, q):
        """Computes the matrix by columns of inverse dynamics: Pinocchio's own function needs depth-first numbers."""
        still = np.zeros(self.model.nv)
        bias = self.inverse(q, still, still)
        columns = [self.inverse(q, still, unit) - bias for unit in np.eye(self.model.nv)]
        return np.array(columns).T


def agree(what, one, other, condition=1.0):
    error = np.abs(one - other).max() / np.abs(one).max() / condition
    assert error < AGREEMENT, f"{what}: {error}"
    return error


def case(name, count, kinds, seed):
    rng = np.random.default_rng(seed)
    bodies = [body(index, str(rng.choice(kinds)), rng) for index in range(count)]
    ours, other = Mujoco(bodies), Pinocchio(bodies)
    size = freedoms(bodies)
    states, worst = [], 0.0
    for _ in range(3):
        q = position(bodies, rng)
        qd = rng.uniform(-4.0, 4.0, size=size).round(4)
        qdd = rng.uniform(-30.0, 30.0, size=size).round(4)
        efforts = rng.uniform(-5.0, 5.0, size=size).round(4)
        tau, acc, h = ours.inverse(q, qd, qdd), ours.forward(q, qd, efforts), ours.mass_matrix(q)
        condition = np.linalg.cond(h)
        worst = max(
            worst,
            agree("tau", tau, other.inverse(q, qd, qdd)),
            agree("H", h, other.mass_matrix(q)),
            agree("acc", acc, other.forward(q, qd, efforts), condition),
        )
        state = {"q": q, "qd": qd, "qdd": qdd, "tau": tau, "efforts": efforts, "acc": acc}
        state["H_lower"] = h[np.tril_indices(size)]
        states.append({key: np.asarray(value).tolist() for key, value in state.items()})
    print(f"{name}: {size} freedoms, the programs agree to {worst:.1e}", file=sys.stderr)
    return {"name": name, "gravity": GRAVITY, "bodies": bodies, "states": states}


def main():
    rigs = [
        ("arm_06", 6, ["revolute"], 6),
        ("slides_08", 8, ["revolute", "prismatic"], 8),
        ("balls_10", 10, ["spherical"], 10),
        ("mixed_12", 12, KINDS, 12),
        ("mixed_20", 20, KINDS, 20),
        ("mixed_32", 32, KINDS, 32),
    ]
    file = {
        "schema": "rotors/1",
        "units": "SI (m, kg, rad, s, N, N m)",
        "source": f"MuJoCo {mujoco.__version__}, cross-checked with Pinocchio {pin.__version__}",
        "cases": [case(*rig) for rig in rigs],
    }
    print(json.dumps(file))


main()
