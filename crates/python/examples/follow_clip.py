"""Lets an arm follow a clip: retargets it, bakes a show within the arm's limits, and tracks it in a simulation."""

import numpy as np

import sinew_motion as sm


def main() -> None:
    arm = sm.Rig.arm(6)
    clip = sm.read_clip("punches_01", cutoff_hz=6, seconds=3.0)
    show = sm.bake(clip, arm, fit=True)
    print(show.fitted)

    dt = 0.002
    tracker = sm.Tracker(arm, rate_hz=1 / dt)
    q, qd = show.sample(0.0)[0], np.zeros(arm.nv)
    errors, limited = [], 0
    for t in np.arange(0.0, show.duration, dt):
        wanted, speed, acceleration = show.sample(t)
        step = tracker.step(wanted, q, qd, qd_desired=speed, qdd_desired=acceleration)
        limited += sum(reason is not None for reason in step.limited)
        qdd = arm.forward_dynamics(q, qd, step.effort)
        qd = qd + dt * qdd
        q = q + dt * qd
        errors.append(np.abs(wanted - q).max())
    print(f"largest error {np.rad2deg(max(errors)):.2f} deg; {limited} efforts were limited")


if __name__ == "__main__":
    main()
