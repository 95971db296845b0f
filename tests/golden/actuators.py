"""Forces of actuators of random models, by MuJoCo.

    pip install mujoco==3.3.7
    python actuators.py COUNT FILE

Writes COUNT models of one to four actuators to FILE, each as MJCF, with the lowest and the highest force that
`mj_forward` gives each joint at rest, over all combinations of the ends of the controls. `null` is a force without
bound. Every second model is the text that `mj_saveLastXML` makes of the first one.
"""

import itertools
import json
import os
import pathlib
import random
import sys
import tempfile

import mujoco

# A control that stands for one without bound; MuJoCo refuses 1e10. Forces from ENDLESS on are without bound.
HUGE, ENDLESS = 9e9, 1e6


def number(low, high):
    return f"{random.uniform(low, high):.3g}"


def pair(low, high):
    a, b = sorted([random.uniform(low, high), random.uniform(low, high)])
    return f"{a:.3g} {b + 0.01:.3g}"


def limits(name, low, high):
    """A range that limits by itself, by a word, or not at all."""
    word = dict(ctrlrange="ctrllimited", forcerange="forcelimited", actuatorfrcrange="actuatorfrclimited")[name]
    return random.choice([
        "",
        f'{name}="{pair(low, high)}"',
        f'{name}="{pair(low, high)}" {word}="true"',
        f'{name}="{pair(low, high)}" {word}="false"',
        f'{name}="0 0"',
    ])


def values(kind):
    text = []
    if random.random() < 0.6:
        text.append(f'gear="{number(-30, 30)}"')
    text.append(limits("ctrlrange", -3, 3) if kind != "damper" else f'ctrlrange="0 {number(0.1, 3)}"')
    text.append(limits("forcerange", -20, 20))
    if kind in ("position", "intvelocity") and random.random() < 0.7:
        text.append(f'kp="{number(0.1, 50)}"')
    if kind in ("position", "velocity", "damper") and random.random() < 0.6:
        text.append(f'kv="{number(0.1, 5)}"')
    if kind == "intvelocity":
        text.append(f'actrange="{pair(-2, 2)}"')
    if kind == "general":
        text.append(random.choice(["", 'gaintype="fixed"', 'gaintype="affine"']))
        text.append(random.choice(["", 'biastype="none"', 'biastype="affine"']))
        if random.random() < 0.7:
            text.append(f'gainprm="{number(-9, 9)} {number(-1, 1)} {number(-1, 1)}"')
        if random.random() < 0.7:
            text.append(f'biasprm="{number(-3, 3)} {number(-9, 0)} {number(-1, 0)}"')
        if random.random() < 0.3:
            text.append(f'dyntype="filter" dynprm="0.1"')
    return " ".join(text)


KINDS = ["motor", "position", "velocity", "intvelocity", "damper", "general", "general"]


def model():
    joints, bodies, ends = ["a", "b", "c"][: random.randint(1, 3)], "", ""
    for name in joints:
        kind, ref = random.choice(["hinge", "slide"]), random.choice(["", f'ref="{number(-0.5, 0.5)}"'])
        joint = f'<joint name="{name}" type="{kind}" {ref} {limits("actuatorfrcrange", -30, 30)}/>'
        bodies += f'<body name="{name}">{joint}<geom size="0.1"/>'
        ends += "</body>"
    defaults = ""
    if random.random() < 0.5:
        kind = random.choice(["motor", "position", "velocity", "general"])
        inner = random.choice(["motor", "position", "general"])
        defaults = f'<default><{kind} {values(kind)}/><default class="x"><{inner} {values(inner)}/></default></default>'
    tendon = ""
    if len(joints) > 1 and random.random() < 0.3:
        parts = "".join(f'<joint joint="{name}" coef="{number(-2, 2)}"/>' for name in joints[:2])
        tendon = f'<tendon><fixed name="t">{parts}</fixed></tendon>'
    actuators = ""
    for _ in range(random.randint(1, 4)):
        kind = random.choice(KINDS)
        to = 'tendon="t"' if tendon and random.random() < 0.5 else f'joint="{random.choice(joints)}"'
        of = random.choice(["", 'class="x"']) if defaults else ""
        actuators += f"<{kind} {to} {of} {values(kind)}/>"
    return (
        f'<mujoco><compiler angle="radian"/>{defaults}<worldbody><body name="base"><geom size="0.1"/>{bodies}{ends}'
        f"</body></worldbody>{tendon}<actuator>{actuators}</actuator></mujoco>"
    )


def saved(text):
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "saved.xml")
        mujoco.mj_saveLastXML(path, mujoco.MjModel.from_xml_string(text))
        return pathlib.Path(path).read_text()


def forces(text):
    model = mujoco.MjModel.from_xml_string(text)
    data, dyn = mujoco.MjData(model), mujoco.mjtDyn
    sides = []
    for k in range(model.nu):
        control = list(model.actuator_ctrlrange[k]) if model.actuator_ctrllimited[k] else [-HUGE, HUGE]
        activation = list(model.actuator_actrange[k]) if model.actuator_actlimited[k] else [-HUGE, HUGE]
        if model.actuator_dyntype[k] == dyn.mjDYN_INTEGRATOR:
            sides.append([(0.0, end) for end in activation])
        else:
            sides.append([(end, min(max(end, activation[0]), activation[1])) for end in control])
    ends = {model.joint(j).name: [float("inf"), float("-inf")] for j in range(model.njnt)}
    for corner in itertools.product(*sides):
        mujoco.mj_resetData(model, data)
        for k, (control, activation) in enumerate(corner):
            data.ctrl[k] = control
            if model.actuator_actadr[k] >= 0:
                data.act[model.actuator_actadr[k]] = activation
        mujoco.mj_forward(model, data)
        for j in range(model.njnt):
            end, force = ends[model.joint(j).name], float(data.qfrc_actuator[model.jnt_dofadr[j]])
            end[:] = [min(end[0], force), max(end[1], force)]
    driven, joint, of_joint = set(), int(mujoco.mjtTrn.mjTRN_JOINT), mujoco.mjtWrap.mjWRAP_JOINT
    for kind, (to, _) in zip(model.actuator_trntype, model.actuator_trnid):
        wraps = range(model.tendon_adr[to], model.tendon_adr[to] + model.tendon_num[to]) if kind != joint else []
        driven |= {to} if kind == joint else {model.wrap_objid[k] for k in wraps if model.wrap_type[k] == of_joint}
    bounded = lambda force: None if abs(force) >= ENDLESS else force
    return {model.joint(j).name: [bounded(force) for force in ends[model.joint(j).name]] for j in sorted(driven)}


def main(count, file):
    random.seed(39)
    models = []
    while len(models) < count:
        text = model()
        try:
            last = saved(text)
        except ValueError:
            continue  # MuJoCo refuses the model.
        if len(models) % 2:
            text = last
        models.append(dict(mjcf=text, forces=forces(text)))
    source = f"MuJoCo {mujoco.__version__}"
    content = dict(schema="sinew-actuators-1", units="N m, N", source=source, cases=models)
    pathlib.Path(file).write_text(json.dumps(content, indent=1) + "\n")


main(int(sys.argv[1]), sys.argv[2])
