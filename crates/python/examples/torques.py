"""Prints the largest torques if all joints of a rig (the desk arm, or the file in the argument) swing as a sine."""

import sys

import numpy as np

import sinew_motion as sm


def main() -> None:
    rig = sm.Rig.load(sys.argv[1]) if len(sys.argv) > 1 else sm.Rig.arm(6)
    if rig.nq != rig.nv:
        sys.exit("expected a rig without ball joints and with a fixed base")
    t = np.arange(0.0, 4.0, 0.002)[:, None]
    rate = 2.0 * np.pi * 0.5
    amplitude = 0.3
    q = rig.home + amplitude * np.sin(rate * t)
    qd = amplitude * rate * np.cos(rate * t) * np.ones(rig.nv)
    qdd = -amplitude * rate**2 * np.sin(rate * t) * np.ones(rig.nv)
    tau = rig.inverse_dynamics(q, qd, qdd)
    for name, most, limit in zip(rig.dof_names, np.abs(tau).max(axis=0), rig.effort):
        note = "" if most <= limit else f", above its limit of {limit:.2f}"
        print(f"{name}: {most:.2f} N m at most{note}")


if __name__ == "__main__":
    main()
