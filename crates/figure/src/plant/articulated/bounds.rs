//! Constraints on a dof over a step: Coulomb friction and the ends of its range.
//!
//! Both act on the speed `v` at the end of the step, with exactly the effort that is needed. They are therefore stable
//! for any step size, and need no stiffness parameter, whose value would be a guess:
//!
//! - friction holds a dof at `v = 0` if the effort for that is at most the friction, and otherwise brakes with the
//!   whole friction;
//! - an end of the range lets a dof reach it within the step, but not pass it: an inelastic stop. Its effort only
//!   pushes back. A dof that starts beyond the end may not move farther, but is not thrown back.
//!
//! Together with the mechanism, this is a linear complementarity problem with a positive definite matrix, which
//! has exactly one solution. It is solved iteratively: the modes of all dofs are guessed, a pass of forward
//! dynamics computes the holding efforts and the speeds, and the modes that contradict them are changed. If this
//! does not converge, one mode is changed at a time (Murty's least index), which always terminates.

/// The mode of motion of a dof in a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Mode {
    /// The dof moves, in this direction if it has friction; the direction is zero without friction.
    Slide(f64),
    /// Friction holds the dof.
    Stick,
    /// The dof arrives at the lower end of its range.
    Low,
    /// The dof arrives at the upper end of its range.
    High,
}

/// The bounds that may hold a dof in a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    /// Speeds at which the dof reaches the ends of its range within the step.
    ends: [f64; 2],
    friction: f64,
}

/// Relative difference below which two efforts or speeds are equal.
const ROUNDING: f64 = 1e-9;

impl Mode {
    /// Returns the mode of an unconstrained dof with this speed.
    pub(super) fn of_speed(friction: f64, speed: f64) -> Self {
        match (friction > 0.0, speed == 0.0) {
            (false, _) => Self::Slide(0.0),
            (true, true) => Self::Stick,
            (true, false) => Self::Slide(speed.signum()),
        }
    }
}

impl Bounds {
    /// Creates the bounds of a dof at coordinate `at`, for a step of `h` seconds. `back` is the speed at which the
    /// dof may be moved back if it is beyond an end.
    pub(super) fn new(range: [f64; 2], at: f64, friction: f64, h: f64, back: f64) -> Self {
        let [low, high] = range.map(|end| (end - at) / h);
        Self { ends: [low.min(back), high.max(-back)], friction }
    }

    /// Returns the effort of the friction on a dof, if it slides.
    pub(super) fn braking(self, mode: Mode) -> f64 {
        match mode {
            Mode::Slide(direction) => -direction * self.friction,
            _ => 0.0,
        }
    }

    /// Returns the speed at which the mode holds a dof; `None` for a sliding dof.
    pub(super) fn held_speed(self, mode: Mode) -> Option<f64> {
        match mode {
            Mode::Slide(_) => None,
            Mode::Stick => Some(0.0),
            Mode::Low => Some(self.ends[0]),
            Mode::High => Some(self.ends[1]),
        }
    }

    /// Returns the mode that agrees with the result: `speed` at the end of the step, and the `effort` that holds the
    /// dof there. `effort` is a difference of two efforts of the magnitude `scale`, which determines the tolerance for
    /// rounding.
    pub(super) fn next(self, mode: Mode, speed: f64, effort: f64, scale: f64) -> Mode {
        let Self { ends: [low, high], friction } = self;
        let slide = |direction: f64| Mode::Slide(if friction > 0.0 { direction } else { 0.0 });
        let least = ROUNDING * (friction + scale.abs());
        // Returns the friction at a speed.
        let at = |speed: f64, towards: f64| {
            if speed == 0.0 { towards * friction } else { -speed.signum() * friction }
        };
        match mode {
            Mode::Slide(_) if speed < low => Mode::Low,
            Mode::Slide(_) if speed > high => Mode::High,
            Mode::Slide(direction) if direction * speed < 0.0 => Mode::Stick,
            Mode::Stick if effort > friction + least => slide(-1.0),
            Mode::Stick if effort < -friction - least => slide(1.0),
            Mode::Low if effort < at(low, -1.0) - least => {
                slide(if low < 0.0 { -1.0 } else { 1.0 })
            }
            Mode::High if effort > at(high, 1.0) + least => {
                slide(if high > 0.0 { 1.0 } else { -1.0 })
            }
            kept => kept,
        }
    }
}
