//! Which turn of a joint a target angle is in.

use heapless::Vec;
use sinew_core::JointKind;
use sinew_core::coordinates::nearest_turn;
use sinew_rig::board::BoardRig;

/// How the target of a dof is unwrapped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Turn {
    /// It is no angle, or one of three that belong together.
    Not,
    /// Next to this.
    Middle(f32),
    /// Next to the last target, which is this.
    Last(f32),
}

impl Turn {
    /// The angle in the turn that is meant, rad.
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

/// Returns the turn of each dof of a rig.
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
            // There is room: one for each dof.
            let _ = turns.push(match (is_angle, middle.is_finite()) {
                (false, _) => Turn::Not,
                (true, true) => Turn::Middle(middle),
                (true, false) => Turn::Last(dof.home),
            });
        }
    }
    turns
}
