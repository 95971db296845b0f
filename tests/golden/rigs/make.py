"""Joint torques of robots, by programs that share nothing with this project.

    pip install pin==4.1.0 mujoco==4.0.0 numpy
    python make.py FOLDER_OF_DATA

For each robot below, writes NAME.json beside this file: random positions, speeds and accelerations of its joints, and
the torques that this motion needs, in the order of `joints`. The base is fixed, gravity is 9.81 m/s^2 along -z of the
robot's file, and there is no friction. Pinocchio computes the torques of a URDF, MuJoCo those of an MJCF. Rotors
(`armature`) come from the MJCF; for a URDF they are the numbers below. Units are SI: rad or m, rad/s or m/s, N m or N.

If `repair_inertia` is true, inertia that no body can have is replaced by the rule of MuJoCo's `balanceinertia`: each
principal moment becomes the mean of the three.
"""

import hashlib
import json
import pathlib
import sys
import tempfile
import xml.etree.ElementTree as ET

import mujoco
import numpy as np
import pinocchio

STATES = 8

# Name, file, whether inertia is repaired, rotor inertia of each joint (kg m^2 or kg).
URDFS = [
    ("poppy", "urdf/poppy-humanoid/Poppy_Humanoid.urdf", False, 0.0),
    ("op3", "urdf/robotis-op3/robotis_op3.urdf", False, 0.0),
    ("open_duck_urdf", "urdf/open-duck-mini/open_duck_mini_v2.urdf", False, 0.0),
    ("panda", "foreign/urdf/panda.urdf", False, 0.0),
    ("so100", "foreign/urdf/so100.urdf", False, 0.01),
    ("h1", "foreign/urdf/h1.urdf", False, 0.0),
    ("allegro", "foreign/urdf/allegro_left.urdf", True, 0.0),
    ("anymal", "foreign/urdf/anymal_c.urdf", True, 0.0),
    ("talos", "foreign/urdf/talos_reduced.urdf", True, 0.0),
]
# A file without a folder is in the folder of this script.
MJCFS = [
    ("open_duck_mjcf", "urdf/open-duck-mini/open_duck_mini_v2.mjcf.xml"),
    ("quirks", "quirks.xml"),
]
HERE = pathlib.Path(__file__).parent


def place(data, file):
    return data / file if "/" in file else HERE / file


def balance(root):
    """Replaces inertia that no body can have, in place."""
    for inertia in root.iter("inertia"):
        value = lambda key: float(inertia.get(key, 0))
        xx, yy, zz = value("ixx"), value("iyy"), value("izz")
        xy, xz, yz = value("ixy"), value("ixz"), value("iyz")
        low, mid, high = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        # Deviations of up to 1e-5 of the sum may be rounding errors of the file.
        if low < -1e-5 * high or high - low - mid > 1e-5 * (low + mid + high):
            mean = str((xx + yy + zz) / 3)
            inertia.attrib = dict(ixx=mean, iyy=mean, izz=mean, ixy="0", ixz="0", iyz="0")


def positions(random, lower, upper):
    """Returns random positions within the ranges; within half a turn for a joint without a range."""
    lower = np.where(np.abs(lower) < 1e3, lower, -np.pi)
    upper = np.where(np.abs(upper) < 1e3, upper, np.pi)
    return random.uniform(lower, upper)


def of_urdf(path, repair, rotor, random):
    root = ET.parse(path).getroot()
    if repair:
        balance(root)
    with tempfile.NamedTemporaryFile(suffix=".urdf") as file:
        ET.ElementTree(root).write(file.name)
        model = pinocchio.buildModelFromUrdf(file.name)
    assert model.nq == model.nv == model.njoints - 1, "one number a joint"
    model.armature[:] = rotor
    data = model.createData()
    states = []
    for state in range(STATES):
        q = positions(random, model.lowerPositionLimit, model.upperPositionLimit)
        moves = 0.0 if state == 0 else 1.0
        qd, qdd = (moves * random.uniform(-most, most, model.nv) + 0.0 for most in (3.0, 20.0))
        tau = pinocchio.rnea(model, data, q, qd, qdd)
        states.append(dict(q=list(q), qd=list(qd), qdd=list(qdd), tau=list(tau)))
    return list(model.names)[1:], states


def of_mjcf(path, random):
    root = ET.parse(path).getroot()
    # Mesh files are missing, and the meshes have no mass here. Without the free joint, the base is fixed.
    for parent in root.iter():
        for child in list(parent):
            is_mesh = child.tag == "geom" and child.get("type") == "mesh"
            if is_mesh or child.tag in ("asset", "freejoint", "actuator", "contact"):
                parent.remove(child)
    model = mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"))
    model.dof_damping[:] = 0
    model.dof_frictionloss[:] = 0
    flags = mujoco.mjtDisableBit
    model.opt.disableflags |= flags.mjDSBL_CONTACT | flags.mjDSBL_LIMIT
    assert model.nq == model.nv == model.njnt, "one number a joint"
    data = mujoco.MjData(model)
    states = []
    for state in range(STATES):
        ranges = np.where(model.jnt_limited[:, None], model.jnt_range, [-np.pi, np.pi])
        q = positions(random, *ranges.T)
        moves = 0.0 if state == 0 else 1.0
        data.qpos, data.qvel = q, moves * random.uniform(-3.0, 3.0, model.nv) + 0.0
        data.qacc = moves * random.uniform(-20.0, 20.0, model.nv) + 0.0
        qdd = data.qacc.copy()
        mujoco.mj_inverse(model, data)
        tau = data.qfrc_inverse
        states.append(dict(q=list(q), qd=list(data.qvel), qdd=list(qdd), tau=list(tau)))
    names = [model.joint(joint).name for joint in range(model.njnt)]
    return names, states, list(model.dof_armature)


def write(name, data, file, repair, source, names, rotors, states):
    content = dict(
        schema="rig_dynamics/1",
        source=source,
        file=file,
        sha256=hashlib.sha256(place(data, file).read_bytes()).hexdigest(),
        repair_inertia=repair,
        joints=names,
        rotor_inertia=rotors,
    )
    lines = [f"{json.dumps(key)}: {json.dumps(value)}" for key, value in content.items()]
    lines.append('"states": [\n' + ",\n".join(json.dumps(state) for state in states) + "\n]")
    out = HERE / f"{name}.json"
    out.write_text("{\n" + ",\n".join(lines) + "\n}\n")
    largest = max(abs(tau) for state in states for tau in state["tau"])
    print(f"{name}: {len(names)} joints, largest effort {largest:.4g}")


def main(data):
    random = np.random.default_rng(14)
    for name, file, repair, rotor in URDFS:
        names, states = of_urdf(place(data, file), repair, rotor, random)
        source = f"Pinocchio {pinocchio.__version__}"
        write(name, data, file, repair, source, names, [rotor] * len(names), states)
    for name, file in MJCFS:
        names, states, rotors = of_mjcf(place(data, file), random)
        write(name, data, file, False, f"MuJoCo {mujoco.__version__}", names, rotors, states)


main(pathlib.Path(sys.argv[1]))
