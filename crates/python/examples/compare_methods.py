"""Prints the mean errors of control methods on the built-in clips, for the paper's figure at scale 1.1."""

import sinew_motion as sm


def main() -> None:
    table = sm.evaluate(
        methods=["local", "world", "linear_compensation", "recommended"],
        scales=[1.1],
        seconds=1.0,
        setup={"plant": {"kind": "articulated"}},
    )
    for method, joints, angle, distance in zip(
        table["method"], table["joints"], table["angular_mean_deg"], table["linear_mean_cm"]
    ):
        if joints == "all":
            print(f"{method}: {angle:.2f} deg, {distance:.2f} cm")


if __name__ == "__main__":
    main()
