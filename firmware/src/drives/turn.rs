//! Unwrapping of a joint's target angle.

use heapless::Vec;
use sinew_core::JointKind;
use sinew_core::coordinates::nearest_turn;
use sinew_rig::board::BoardRig;

/// The rule by which the target of a dof is unwrapped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Turn {
    /// The target is not an angle, or is part of a ball joint's three components.
    Not,
    /// Nearest to this angle, the middle of the joint's range, rad.
    Middle(f32),
    /// Nearest to the last target, which is this angle, rad.
    Last(f32),
}

impl Turn {
    /// Returns the angle in its intended turn, rad.
    pub(super) fn unwrapped(&mut self, angle_rad: f32) -> f32 {
        match self {
            Self::Not => angle_rad,
            Self::Middle(middle) => nearest_turn(angle_rad, *middle),
            Self::Last(last) => {
                *last = nearest_turn(angle_rad, *last);
                *last
            }
        }
    }
}

/// Returns the rule for each dof of a rig.
pub(super) fn turns<const BODIES: usize, const DOFS: usize, const SERVOS: usize>(
    rig: &BoardRig<BODIES, DOFS, SERVOS>,
) -> Vec<Turn, DOFS> {
    let mut turns = Vec::new();
    let mut dofs = rig.dofs().iter();
    for body in rig.tree().bodies() {
        let is_angle =
            matches!(body.joint, JointKind::Revolute { .. } | JointKind::Universal { .. });
        for dof in dofs.by_ref().take(body.joint.dof_count()) {
            let [least, most] = dof.range;
            let middle = 0.5 * (least + most);
            // There is room: `DOFS` is the maximum number.
            let _ = turns.push(match (is_angle, middle.is_finite()) {
                (false, _) => Turn::Not,
                (true, true) => Turn::Middle(middle),
                (true, false) => Turn::Last(dof.home),
            });
        }
    }
    turns
}
