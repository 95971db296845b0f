//! Feed-forward of the friction that the drives know.

use glam::DVec3;
use sinew_core::Wrench;
use sinew_core::glam::Vec3;
use sinew_figure::plant::Pose;
use sinew_rig::drive::Friction;
use sinew_rig::mechanism::{JointModel, Link};

use super::controller::narrow;
use super::reference::{Performance, rotation_vector};

/// Feed-forward of friction, for the drives of a rig whose joints have friction.
pub(super) struct FrictionFeed {
    /// Friction along every dof of each body's joint, and the maximum effort of its drive.
    joints: Vec<(Friction, f32)>,
    now: Vec<Pose>,
    next: Vec<Pose>,
}

impl FrictionFeed {
    /// Creates the feed-forward for a rig; `None` if no joint has friction.
    pub(super) fn new(links: &[Link], torque_limit_nm: f64) -> Option<Self> {
        let joint = |link: &Link| {
            // Clamped to stay finite in f32.
            let [coulomb, viscous] =
                [link.friction, link.damping].map(|x| x.min(f64::from(f32::MAX)));
            let friction = Friction::new(narrow(coulomb), narrow(viscous));
            let most = match link.joint {
                JointModel::Prismatic(_) => link.effort,
                _ => link.effort.min(torque_limit_nm),
            };
            (friction.expect("checked with the rig to be from 0"), narrow(most))
        };
        let joints: Vec<_> = links.iter().map(joint).collect();
        let rubs = joints.iter().any(|(friction, _)| !friction.is_none());
        rubs.then(|| Self { joints, now: Vec::new(), next: Vec::new() })
    }

    /// Adds the friction of the joints to their wrenches (body axes), at the mean speeds that are desired from
    /// this frame to the next, within the limits of the drives. Returns the number of drives at their limit.
    pub(super) fn add(
        &mut self,
        performance: &Performance<'_>,
        frame: usize,
        wrenches: &mut [Wrench],
    ) -> usize {
        let Performance { motion, setup, links } = *performance;
        motion.joint_poses(setup, frame, &mut self.now);
        motion.joint_poses(setup, frame + 1, &mut self.next);
        let poses = self.now.iter().zip(&self.next);
        let mut limited = 0;
        let joints = links.iter().zip(&self.joints).zip(poses).zip(wrenches);
        for (((link, (friction, most)), (now, next)), wrench) in joints {
            if friction.is_none() || link.joint == JointModel::Free {
                continue;
            }
            let moved = now.inside(next);
            let [spin_rad_s, slide_m_s] =
                [rotation_vector(moved.rotation), moved.position_m].map(|way| way / motion.dt_s());
            let placement = Pose { rotation: link.rotation, position_m: link.position_m };
            let (turns, slides) = link.joint.axes(&link.joint.along(&placement.inside(now)));
            let takes = |axes: &[DVec3], speed: DVec3| -> Vec3 {
                let along =
                    |axis: &DVec3| axis.as_vec3() * friction.effort(narrow(axis.dot(speed)));
                axes.iter().map(along).sum()
            };
            let [moment_nm, force_n] = [
                wrench.moment_nm + takes(&turns, spin_rad_s),
                wrench.force_n + takes(&slides, slide_m_s),
            ];
            let within =
                Wrench::new(moment_nm.clamp_length_max(*most), force_n.clamp_length_max(*most));
            limited += usize::from(within != Wrench::new(moment_nm, force_n));
            *wrench = within;
        }
        limited
    }
}
