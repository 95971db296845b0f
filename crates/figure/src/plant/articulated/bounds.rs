//! What holds a joint: Coulomb friction and the ends of its range, over a step.
//!
//! Both act on the speed `v` at the end of the step, with an effort that is just as large as it has to be. So they are
//! stable at any step, and need no stiffness that nobody knows:
//!
//! - friction holds a dof at `v = 0` as long as that takes no more than the friction, and brakes with all of it
//!   otherwise;
//! - an end of the range lets a dof come to it within the step and no farther: an inelastic stop. Its effort only
//!   pushes back. A dof that starts beyond may not go on, and is not thrown back.
//!
//! With the mechanism between them, this is a linear complementarity problem with a positive definite matrix: it has
//! one solution. The modes of all dofs are guessed, a pass of forward dynamics tells what holds them and how fast they
//! are, and what does not agree is guessed again. If that does not end, one at a time (Murty's least index), which
//! does.

/// The motion of a dof in a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Mode {
    /// It moves, in this direction if there is friction; zero if there is none.
    Slide(f64),
    /// Friction holds it.
    Stick,
    /// It comes to the lower end of its range.
    Low,
    /// It comes to the upper end of its range.
    High,
}

/// A bound that may hold a dof in a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    /// Speeds that lead to the ends of the range.
    ends: [f64; 2],
    friction: f64,
}

/// Efforts and speeds that differ by less, as a share of what they are, are the same.
const ROUNDING: f64 = 1e-9;

impl Mode {
    /// That of a dof that nothing stops.
    pub(super) fn of_speed(friction: f64, speed: f64) -> Self {
        match (friction > 0.0, speed == 0.0) {
            (false, _) => Self::Slide(0.0),
            (true, true) => Self::Stick,
            (true, false) => Self::Slide(speed.signum()),
        }
    }
}

impl Bounds {
    /// Those of a dof at a coordinate in its range, for a step of `h` seconds. `back`: the speed at which it may be
    /// brought back if it is beyond an end.
    pub(super) fn new(range: [f64; 2], at: f64, friction: f64, h: f64, back: f64) -> Self {
        let [low, high] = range.map(|end| (end - at) / h);
        Self { ends: [low.min(back), high.max(-back)], friction }
    }

    /// Effort of the friction on a dof, if it slides.
    pub(super) fn braking(self, mode: Mode) -> f64 {
        match mode {
            Mode::Slide(direction) => -direction * self.friction,
            _ => 0.0,
        }
    }

    /// The speed that a dof is held at.
    pub(super) fn held_speed(self, mode: Mode) -> Option<f64> {
        match mode {
            Mode::Slide(_) => None,
            Mode::Stick => Some(0.0),
            Mode::Low => Some(self.ends[0]),
            Mode::High => Some(self.ends[1]),
        }
    }

    /// The mode that agrees better: `speed` at the end of the step, and `effort` that holds it there. `scale`: of
    /// the efforts that it is the difference of.
    pub(super) fn next(self, mode: Mode, speed: f64, effort: f64, scale: f64) -> Mode {
        let Self { ends: [low, high], friction } = self;
        let slide = |direction: f64| Mode::Slide(if friction > 0.0 { direction } else { 0.0 });
        let least = ROUNDING * (friction + scale.abs());
        // What friction gives at a speed.
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
