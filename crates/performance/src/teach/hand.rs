//! A scripted hand that leads a simulated rig.

use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;
use sinew_servo_sim::plant::Hand;

use super::GuideTrajectory;

/// A hand that holds all joints except ball joints, and leads them along a path.
#[derive(Debug, Clone)]
pub struct ScriptedHand {
    guide: GuideTrajectory,
    /// Dof and coordinate of each joint that the hand holds.
    held: Vec<(usize, usize)>,
}

impl ScriptedHand {
    /// Creates a hand for a rig with this mechanism.
    pub fn new(mechanism: &Mechanism, guide: GuideTrajectory) -> Self {
        let (mut held, mut dof, mut coordinate) = (Vec::new(), 0, 0);
        for link in &mechanism.bodies {
            let kind = link.joint.kind();
            let (dofs, coordinates) = (kind.dof_count(), kind.coordinate_count());
            if !matches!(link.joint, JointModel::Spherical | JointModel::Free) {
                held.extend((dof..dof + dofs).zip(coordinate..));
            }
            (dof, coordinate) = (dof + dofs, coordinate + coordinates);
        }
        Self { guide, held }
    }

    /// Returns the duration of the path, s.
    pub fn duration_s(&self) -> f64 {
        self.guide.duration_s()
    }

    /// Holds every dof at its position `time_s` after the beginning of the path. `lead` sets the hand of a dof.
    pub fn hold(&self, time_s: f64, mut lead: impl FnMut(usize, Option<Hand>)) {
        let instant = self.guide.at(time_s);
        for (dof, coordinate) in &self.held {
            let (position, velocity) = (instant.q[*coordinate], instant.qd[*dof]);
            lead(*dof, Some(Hand { position, velocity }));
        }
    }

    /// Releases all dofs that the hand holds.
    pub fn let_go(&self, mut lead: impl FnMut(usize, Option<Hand>)) {
        self.held.iter().for_each(|(dof, _)| lead(*dof, None));
    }
}
