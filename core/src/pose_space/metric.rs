//! Distances between two poses, and products with the metric tensor `JᵀWJ` at a pose, without forming the matrix.

use glam::{Quat, Vec3};
use heapless::Vec;

use super::{BodyPoses, JointRotations, PoseCoordinates, PoseSpace, chart};
use crate::dynamics::dof_count;
use crate::fixed;
use crate::joint::JointKind;
use crate::kinematics::of_parent;
use crate::math;
use crate::symmetric::Symmetric;
use crate::transform::{Transform, Twist};
use crate::tree::Body;

impl<const N: usize> PoseSpace<'_, N> {
    /// Returns the joint-angle metric, eq. (1): the root of the sum of the squared differences of all coordinates
    /// (rad; m for slides), each taken the shorter way round. O(n).
    ///
    /// Rotation vectors of ball joints have a discontinuity at half a turn. Near it, the result depends on the
    /// coordinates, and the triangle inequality may fail. [`Self::rotation_distance`] has no discontinuity.
    pub fn angle_distance(&self, a: &PoseCoordinates<N>, b: &PoseCoordinates<N>) -> f32 {
        let joints = self.weighted().zip(a.joints.iter().zip(&b.joints));
        math::sqrt(
            joints
                .map(|((body, weight), (a, b))| weight * chart::way(body.joint, a, b).1.squared())
                .sum(),
        )
    }

    /// Returns the metric of the product of rotation groups: the root of the sum of the squared angles (rad) between
    /// the two rotations of every joint. It does not depend on coordinates. O(n).
    ///
    /// With the squares of [`Self::bone_lengths_m`] as weights, it is the metric of Tournier et al., "Motion
    /// compression using principal geodesics analysis" (2009), in metres.
    ///
    /// ```
    /// use sinew_core::pose_space::PoseSpace;
    /// use sinew_core::{Body, Inertia, JointKind, Transform, Tree, glam::Vec3, math};
    /// let neck = Body {
    ///     parent: None,
    ///     joint: JointKind::Spherical,
    ///     placement: Transform::IDENTITY,
    ///     inertia: Inertia::default(),
    ///     rotor_inertia: 0.0,
    /// };
    /// let tree = Tree::<1>::from_bodies(&[neck])?;
    /// let space = PoseSpace::new(&tree).with_root();
    /// let [ahead, aside] = [0.0, 0.5].map(|rad| Transform::new(math::exp(Vec3::Y * rad), Vec3::ZERO));
    /// let [ahead, aside] = [space.coordinates(&[ahead])?, space.coordinates(&[aside])?];
    /// let [ahead, aside] = [&ahead, &aside].map(|pose| space.joint_rotations(pose));
    /// assert!((space.rotation_distance(&ahead, &aside) - 0.5).abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn rotation_distance(&self, a: &JointRotations<N>, b: &JointRotations<N>) -> f32 {
        let joints = self.weights.iter().zip(a.rotations.iter().zip(&b.rotations));
        let squares = joints.map(|(weight, (a, b))| {
            let turn = math::log(math::turn_in_body(*a, *b));
            weight * turn.dot(turn)
        });
        math::sqrt(squares.sum())
    }

    /// Returns, for each joint, the mean length of the bones that it rotates, which is the mean distance from the joint
    /// to its child joints, m; 0 for a joint without children. O(n).
    pub fn bone_lengths_m(&self) -> Vec<f32, N> {
        let mut bones: Vec<(f32, f32), N> =
            fixed::collect(self.tree.bodies().iter().map(|_| (0.0, 0.0)));
        for body in self.tree.bodies() {
            if let Some((sum_m, count)) = body.parent.and_then(|parent| bones.get_mut(parent)) {
                *sum_m += math::length(body.placement.translation_m);
                *count += 1.0;
            }
        }
        fixed::collect(
            bones.iter().map(|(sum_m, count)| if *count > 0.0 { sum_m / count } else { 0.0 }),
        )
    }

    /// Returns the distance in space: the root of the sum of the squared distances (m) of all joints, `|F(a) - F(b)|`.
    /// It ignores that bones keep their lengths. It is therefore a lower bound of the length of every path between the
    /// poses. O(n).
    pub fn position_distance(&self, a: &BodyPoses<N>, b: &BodyPoses<N>) -> f32 {
        let ways = self.weighted().zip(a.positions_m().zip(b.positions_m()));
        math::sqrt(ways.map(|((_, weight), (a, b))| weight * (a - b).dot(a - b)).sum())
    }

    /// Writes a column of the Jacobian of F: the velocities of all joints (m/s, world axes) when one joint moves by
    /// `motion`, given in its body's axes; only the part that the joint allows counts. O(n).
    ///
    /// `out` is by body; items beyond the rig are unchanged.
    pub fn jacobian_column(
        &self,
        at: &BodyPoses<N>,
        joint: usize,
        motion: Twist,
        out: &mut [Vec3],
    ) {
        let moved = self.tree.bodies().get(joint).filter(|body| !self.leaves_out(body));
        let (Some(body), Some(place)) = (moved, at.bodies.get(joint)) else {
            return out.iter_mut().take(self.tree.len()).for_each(|out| *out = Vec3::ZERO);
        };
        let motion = self.let_through(body, place, at, motion).rotated(place.rotation);
        let subtree = self.tree.subtree(joint);
        for (index, (position, out)) in at.positions_m().zip(out).enumerate() {
            *out = if subtree.contains(index) {
                motion.linear + motion.angular.cross(position - place.translation_m)
            } else {
                Vec3::ZERO
            };
        }
    }

    /// Writes `JᵀWJ v`: the metric tensor at a pose times motions of all joints (body axes), without forming the
    /// matrix. O(n).
    ///
    /// `v` and `out` are by joint, in body axes; only the part of `v` that each joint allows counts.
    pub fn metric_product(&self, at: &BodyPoses<N>, v: &[Twist], out: &mut [Twist]) {
        // Outwards: the motion of every body, in world axes.
        for (index, ((body, place), v)) in
            self.tree.bodies().iter().zip(&at.bodies).zip(v).enumerate()
        {
            let of_joint = self.let_through(body, place, at, *v).rotated(place.rotation);
            let parent = of_parent(body, out, &Twist::ZERO);
            let arm = place.translation_m
                - of_parent(body, &at.bodies, &Transform::IDENTITY).translation_m;
            let moved = Twist {
                angular: parent.angular + of_joint.angular,
                linear: parent.linear + parent.angular.cross(arm) + of_joint.linear,
            };
            let Some(slot) = out.get_mut(index) else { return };
            *slot = moved;
        }
        for (motion, weight) in out.iter_mut().zip(&self.weights) {
            *motion = Twist { angular: Vec3::ZERO, linear: motion.linear * *weight };
        }
        self.gather(at, out);
    }

    /// Replaces forces `f` on all bodies by `Jᵀ f`, in place: the generalised force on every joint, in body axes, along
    /// its dofs. The forces are `linear`, at the joints, in world axes; `angular` is zero.
    pub(super) fn gather(&self, at: &BodyPoses<N>, forces: &mut [Twist]) {
        for (index, (body, place)) in self.tree.bodies().iter().zip(&at.bodies).enumerate().rev() {
            let Some(of_body) = forces.get(index).copied() else { continue };
            let parent =
                body.parent.and_then(|parent| at.bodies.get(parent).zip(forces.get_mut(parent)));
            if let Some((place_of_parent, of_parent)) = parent {
                let arm = place.translation_m - place_of_parent.translation_m;
                of_parent.linear += of_body.linear;
                of_parent.angular += of_body.angular + arm.cross(of_body.linear);
            }
            let felt =
                self.let_through(body, place, at, of_body.rotated(place.rotation.conjugate()));
            if let Some(slot) = forces.get_mut(index) {
                *slot = felt;
            }
        }
    }

    /// Returns the trace of the metric tensor `JᵀWJ` in body axes: the sum of the squared speeds of all joints, over
    /// all motions of one dof at 1 rad/s or 1 m/s. O(n).
    pub fn metric_trace(&self, at: &BodyPoses<N>) -> f32 {
        // For each joint: weight, first and second moments of the bodies it carries, about the joint, in world axes.
        let mut carried: Vec<Carried, N> =
            fixed::collect(self.weights.iter().map(|weight| Carried::point(*weight)));
        let mut trace = 0.0;
        for (index, (body, place)) in self.tree.bodies().iter().zip(&at.bodies).enumerate().rev() {
            let Some(of_body) = carried.get(index).copied() else { continue };
            let parent =
                body.parent.and_then(|parent| at.bodies.get(parent).zip(carried.get_mut(parent)));
            if let Some((place_of_parent, of_parent)) = parent {
                of_parent.add(&of_body, place.translation_m - place_of_parent.translation_m);
            }
            if self.leaves_out(body) {
                continue;
            }
            let rotation_in_joint = rotation_in_joint(body, place, at);
            for column in &body.joint.motion_subspace(rotation_in_joint) {
                let axis = math::rotate(place.rotation, column.angular);
                trace +=
                    of_body.turned_about(axis) + of_body.weight * column.linear.dot(column.linear);
            }
        }
        trace
    }

    /// Returns the number of coordinates: the joints' dofs, without those of an ignored root.
    pub fn dimensions(&self) -> usize {
        let bodies = self.tree.bodies();
        let root = bodies.iter().filter(|body| self.leaves_out(body));
        let left_out: usize = root.map(|body| body.joint.dof_count()).sum();
        dof_count(bodies).saturating_sub(left_out)
    }

    fn let_through(
        &self,
        body: &Body,
        place: &Transform,
        at: &BodyPoses<N>,
        motion: Twist,
    ) -> Twist {
        if self.leaves_out(body) {
            return Twist::ZERO;
        }
        body.joint.project_twist(rotation_in_joint(body, place, at), motion)
    }
}

/// Returns the rotation of a body in its joint frame, or the identity if the joint's motion subspace does not
/// depend on this rotation.
fn rotation_in_joint<const N: usize>(body: &Body, place: &Transform, at: &BodyPoses<N>) -> Quat {
    if !matches!(body.joint, JointKind::Universal { .. }) {
        return Quat::IDENTITY;
    }
    let parent = of_parent(body, &at.bodies, &Transform::IDENTITY);
    body.rotation_in_joint(parent.rotation.conjugate() * place.rotation)
}

/// Moments of the weights that a joint carries, about the joint.
#[derive(Debug, Clone, Copy)]
struct Carried {
    weight: f32,
    /// First moment, Σ w r.
    first: Vec3,
    /// Second moment, Σ w r rᵀ.
    second: Symmetric,
}

impl Carried {
    fn point(weight: f32) -> Self {
        Self { weight, first: Vec3::ZERO, second: Symmetric::ZERO }
    }

    /// Adds the moments of an outer joint at a distance `arm`.
    fn add(&mut self, outer: &Self, arm: Vec3) {
        self.weight += outer.weight;
        self.first += outer.first + arm * outer.weight;
        self.second = self.second
            + outer.second
            + Symmetric::from_outer(arm, outer.first)
            + Symmetric::from_outer(arm, arm * (0.5 * outer.weight));
    }

    /// Returns `Σ w |axis × r|²` for a unit axis, or 0 for a zero axis.
    fn turned_about(&self, axis: Vec3) -> f32 {
        let along = axis.dot(Vec3::new(
            self.second.x_axis().dot(axis),
            self.second.y_axis().dot(axis),
            self.second.z_axis().dot(axis),
        ));
        self.second.trace() * axis.dot(axis) - along
    }
}
