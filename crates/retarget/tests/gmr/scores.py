"""Nine clips on three robots, scored: `cargo xtask retargeting` calls this (README.md).

scores.py REFERENCE DATA SINEW FOLDER: a table as CSV on standard output. FOLDER takes what is made on the way.
"""

import concurrent.futures
import csv
import math
import pathlib
import subprocess
import sys

# Our scripts leave nothing beside the reference's.
sys.dont_write_bytecode = True

# Name here, its table in the reference's rigs.json, its model.
ROBOTS = [
    ("G1", "g1", "g1_mocap_29dof.xml"),
    ("Hi", "hi", "hi_25dof.xml"),
    ("ToddlerBot", "toddy", "toddy_mocap.xml"),
]
CLIPS = ["walk/07_01", "walk/02_01", "fight/02_05"]
RATE_HZ = 30
METRES_PER_UNIT = 0.056444
# Rows of 120 Hz that are cut off the beginning of a clip: whole rows of 30 Hz.
CUTS = [8, 40, 120]
# From when on the start must not matter, s.
SETTLED_S = 0.5
# By their names in the score. The first two of a pair are mean and largest.
PAIRS = ["limb_dir_deg_world", "hand_pos_cm", "foot_pos_cm", "foot_slide_cm_s"]
NUMBERS = ["foot_height_spread_cm", "frames_at_a_limit_%", "worst_over_limit_deg", "max_speed_rad_s", "max_jerk_rad_s3"]


def cut(clip, rows, to):
    """A clip without the first `rows` of its motion; its T-pose row stays."""
    lines = clip.read_text(errors="replace").splitlines()
    motion = next(i for i, line in enumerate(lines) if line.strip() == "MOTION")
    head, t_pose, rest = lines[: motion + 3], lines[motion + 3], lines[motion + 4 + rows :]
    head[motion + 1] = f"Frames: {1 + sum(1 for line in rest if line.strip())}"
    to.write_text("\n".join([*head, t_pose, *rest]) + "\n")


def in_radians(table):
    """Rewrites an exported table as the score reads it: joints without a unit in the header, in rad and m."""
    with open(table, newline="") as file:
        head, *rows = csv.reader(file)
    units = {"_deg": math.radians(1), "_mm": 0.001}
    ends = [next((unit for unit in units if name.endswith(unit)), "") for name in head]
    with open(table, "w", newline="") as file:
        out = csv.writer(file)
        out.writerow(name.removesuffix(end) for name, end in zip(head, ends))
        out.writerows([float(x) * units.get(end, 1) for x, end in zip(row, ends)] for row in rows)


def joints(table):
    """Times, and the rows of joint angles, of an exported table."""
    with open(table, newline="") as file:
        head, *rows = csv.reader(file)
    own = [i for i, name in enumerate(head) if name != "time" and not name.startswith("root_")]
    return [float(row[0]) for row in rows], [[float(row[i]) for i in own] for row in rows]


def farthest_deg(whole, part, rows):
    """The largest difference of an angle, from `SETTLED_S` of the part on, which begins `rows` of 120 Hz later."""
    times, angles = joints(part)
    skip, later = round(SETTLED_S * RATE_HZ), rows * RATE_HZ // 120
    pairs = list(zip(angles[skip:], joints(whole)[1][later + skip :]))
    assert len(pairs) == len(angles) - skip, "the part ends where the whole does"
    return max(math.degrees(abs(a - b)) for now, then in pairs for a, b in zip(now, then))


def main():
    reference, data, sinew, folder = map(pathlib.Path, sys.argv[1:])
    sys.path.insert(0, str(reference))
    from score import score

    def export(model, clip, to):
        command = [sinew, "clip", "export", clip, "--rig", model, "--rate-hz", str(RATE_HZ), "-o", to]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"{clip} on {model}: {done.stderr}")
        in_radians(to)
        return to

    cases = []
    with concurrent.futures.ThreadPoolExecutor() as pool:
        for robot, table, file in ROBOTS:
            model = reference / "models" / file
            for clip in CLIPS:
                bvh, name = data / "cmu" / f"{clip}.bvh", f"{table}-{pathlib.Path(clip).name}"
                whole = pool.submit(export, model, bvh, folder / f"{name}.csv")
                parts = []
                for rows in CUTS:
                    part = folder / f"{pathlib.Path(clip).name}-{rows}.bvh"
                    if not part.exists():
                        cut(bvh, rows, part)
                    parts.append((rows, pool.submit(export, model, part, folder / f"{name}-{rows}.csv")))
                cases.append((robot, table, model, bvh, whole, parts))

    out = csv.writer(sys.stdout, lineterminator="\n")
    pairs = [f"{name} {which}" for name in PAIRS for which in ("mean", "max")]
    out.writerow(["robot", "clip", "by", *pairs, *NUMBERS, "other_start_deg"])
    for robot, table, model, bvh, whole, parts in cases:
        theirs = reference / "gmr" / f"{table}-{bvh.stem}-{RATE_HZ}hz.csv"
        for by, result in [("GMR", theirs), ("Sinew", whole.result())]:
            scored = score(result, model, table, str(bvh), METRES_PER_UNIT)
            other = ""
            if by == "Sinew":
                assert not scored["missing"], f"no column for {scored['missing']}"
                other = f"{max(farthest_deg(result, part.result(), rows) for rows, part in parts):.2f}"
            numbers = [x for name in PAIRS for x in scored[name]] + [scored[name] for name in NUMBERS]
            out.writerow([robot, bvh.stem, by, *numbers, other])


main()
