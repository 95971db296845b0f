//! The energy of a curve through poses, which geodesics minimise, and its gradient.

use glam::Vec3;

use super::{BodyPoses, JointCoordinates, PoseCoordinates, PoseSpace, chart};
use crate::fixed;
use crate::math;
use crate::transform::{Transform, Twist};

impl<const N: usize> PoseSpace<'_, N> {
    /// Returns the energy of a curve through poses, eq. (6): the sum of the squared distances from each pose to the
    /// next, m². O(n) for each pose.
    ///
    /// The integral of eq. (5) is approximately this sum times the number of steps.
    pub fn curve_energy(&self, points: &[BodyPoses<N>]) -> f32 {
        self.steps_m(points).map(|step_m| step_m * step_m).sum()
    }

    /// Returns the length of a curve through poses, eq. (4): the sum of the distances from each pose to the next, m.
    /// O(n) for each pose.
    pub fn curve_length(&self, points: &[BodyPoses<N>]) -> f32 {
        self.steps_m(points).sum()
    }

    fn steps_m(&self, points: &[BodyPoses<N>]) -> impl Iterator<Item = f32> {
        points.iter().zip(points.iter().skip(1)).map(|(a, b)| self.position_distance(a, b))
    }

    /// Writes the gradient of a curve's energy with respect to motions of an inner pose, joint by joint, in body
    /// axes: `2 Jᵀ W (2 F - F₋ - F₊)`. O(n).
    ///
    /// Eq. (7) of the paper has `2 (F₋ - F₊)` instead, which is not the derivative of eq. (6): it disagrees with
    /// finite differences.
    ///
    /// `out` is by joint; items beyond the rig are unchanged.
    pub fn energy_gradient(
        &self,
        before: &BodyPoses<N>,
        at: &BodyPoses<N>,
        after: &BodyPoses<N>,
        out: &mut [Twist],
    ) {
        let positions = before.positions_m().zip(at.positions_m()).zip(after.positions_m());
        for (((_, weight), ((before, at), after)), out) in
            self.weighted().zip(positions).zip(out.iter_mut())
        {
            // Differences of neighbours: the plain sum would lose the digits that the positions share.
            let linear = ((at - before) - (after - at)) * (2.0 * weight);
            *out = Twist { angular: Vec3::ZERO, linear };
        }
        if let Some(out) = out.get_mut(..self.tree.len()) {
            self.gather(at, out);
        }
    }

    /// Converts a gradient with respect to motions in body axes to one with respect to the coordinates of the pose.
    /// O(n).
    ///
    /// `of_motions` and `out` are by joint.
    pub fn in_coordinates(
        &self,
        at: &PoseCoordinates<N>,
        of_motions: &[Twist],
        out: &mut [JointCoordinates],
    ) {
        let joints = self.tree.bodies().iter().zip(&at.joints).zip(of_motions);
        for (((body, at), of_motion), out) in joints.zip(out) {
            *out = chart::gradient(body, at, of_motion);
        }
    }

    /// Returns the pose at `t` on the straight line in coordinates from `a` (`t` = 0) to `b` (`t` = 1). Every joint
    /// takes the shorter way round. O(n).
    pub fn on_line(
        &self,
        a: &PoseCoordinates<N>,
        b: &PoseCoordinates<N>,
        t: f32,
    ) -> PoseCoordinates<N> {
        let joints = self.tree.bodies().iter().zip(a.joints.iter().zip(&b.joints));
        let joints = joints.map(|(body, (a, b))| {
            let (start, step) = chart::way(body.joint, a, b);
            start + step * t
        });
        PoseCoordinates { joints: fixed::collect(joints) }
    }

    /// Returns the pose after `motions` of its joints, in body axes; only the part that each joint allows counts.
    /// O(n).
    #[must_use]
    pub fn moved(&self, at: &PoseCoordinates<N>, motions: &[Twist]) -> PoseCoordinates<N> {
        let joints =
            self.tree.bodies().iter().zip(&at.joints).zip(motions).map(|((body, at), motion)| {
                if self.leaves_out(body) {
                    return JointCoordinates::ZERO;
                }
                let pose = chart::pose(body, at);
                let step = Transform::new(math::exp(motion.angular), motion.linear);
                chart::coordinates(body, &(pose * step))
            });
        PoseCoordinates { joints: fixed::collect(joints) }
    }
}
