//! The tree of bodies, its state, and the integration of the state.

use glam::{DMat3, DQuat, DVec3};

use super::articulated_body::Articulated;
use super::joint::Joint;
use super::spatial::{InParent, World, skew};
use crate::plant::{Drive, GRAVITY_M_S2, JointModel, Link as Given, Mechanism, MovingPose, Pose};

/// A tree of bodies in reduced coordinates. Parents precede their children.
#[derive(Debug, Clone)]
pub(super) struct Tree {
    pub(super) root: RootMount,
    pub(super) gravity_m_s2: DVec3,
    /// Position of the root's origin, in the world.
    root_position_m: DVec3,
    /// Velocity of the root's origin, world axes.
    root_velocity_m_s: DVec3,
    /// Classical acceleration of the root's origin, world axes.
    pub(super) root_acceleration_m_s2: DVec3,
    /// Force on the root's origin, in the root's axes.
    pub(super) root_force_n: DVec3,
    pub(super) links: Vec<Link>,
}

/// The connection of the root to the world.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RootMount {
    /// The root is bolted to the world at its initial position.
    Fixed,
    /// The root moves freely, driven by an external force and torque.
    Driven,
    /// The root is connected to the world by an ordinary joint.
    ByJoint,
}

/// A body and its joint. The root moves relative to the world.
#[derive(Debug, Clone)]
pub(super) struct Link {
    pub(super) parent: Option<usize>,
    pub(super) mass_kg: f64,
    /// Mass times centre of mass, body axes.
    pub(super) first_moment_kg_m: DVec3,
    /// Rotational inertia about the joint, body axes.
    pub(super) rotational_kg_m2: DMat3,

    pub(super) in_parent: InParent,
    /// Acceleration of the spin along the joint's dofs, body axes.
    pub(super) spin_rate_rad_s2: DVec3,
    /// Acceleration of the slide along the joint's dofs, body axes.
    pub(super) slide_rate_m_s2: DVec3,
    /// Torque of the joint on the body, body axes.
    pub(super) torque_nm: DVec3,
    /// The joint, unless it is a ball joint that turns freely.
    ///
    /// Boxed since it is large: a tree of ball joints then fits the processor's nearest cache.
    pub(super) joint: Option<Box<Joint>>,

    pub(super) world: World,
    pub(super) articulated: Articulated,
}

impl Link {
    /// Creates the body with its joint in the state given by the motion of the body and its parent.
    fn new(body: &Given, state: &MovingPose, parent: Option<&MovingPose>) -> Self {
        let (rotation, angular) = parent.map_or((DQuat::IDENTITY, DVec3::ZERO), |parent| {
            (parent.pose.rotation, parent.angular_rad_s)
        });
        let first_moment = body.mass_kg * body.center_of_mass_m;
        let about_joint = skew(first_moment) * skew(body.center_of_mass_m).transpose();
        let still = MovingPose {
            pose: Pose::IDENTITY,
            angular_rad_s: DVec3::ZERO,
            linear_m_s: DVec3::ZERO,
        };
        let from = parent.unwrap_or(&still);
        let arm_m = state.pose.position_m - from.pose.position_m;
        let slide_m_s = state.linear_m_s - from.linear_m_s - from.angular_rad_s.cross(arm_m);
        let mut in_parent = InParent {
            pose: Pose {
                rotation: (rotation.conjugate() * state.pose.rotation).normalize(),
                position_m: from.pose.to_local(state.pose.position_m),
            },
            spin_rad_s: state.pose.rotation.conjugate() * (state.angular_rad_s - angular),
            slide_m_s: rotation.conjugate() * slide_m_s,
        };
        let joint = Joint::new(body, &in_parent).map(Box::new);
        match body.joint {
            JointModel::Free => {}
            JointModel::Revolute(_) | JointModel::Prismatic(_) | JointModel::Universal(_) => {
                if let Some(joint) = &joint {
                    in_parent = joint.in_parent();
                }
            }
            JointModel::Fixed if parent.is_some() => {
                in_parent.pose = Pose { rotation: body.rotation, position_m: body.position_m };
                (in_parent.spin_rad_s, in_parent.slide_m_s) = (DVec3::ZERO, DVec3::ZERO);
            }
            JointModel::Fixed | JointModel::Spherical => {
                (in_parent.pose.position_m, in_parent.slide_m_s) = (body.position_m, DVec3::ZERO);
            }
        }
        Self {
            parent: body.parent,
            mass_kg: body.mass_kg,
            first_moment_kg_m: first_moment,
            rotational_kg_m2: body.inertia_kg_m2 + about_joint,
            in_parent,
            spin_rate_rad_s2: DVec3::ZERO,
            slide_rate_m_s2: DVec3::ZERO,
            torque_nm: DVec3::ZERO,
            joint,
            world: World::default(),
            articulated: Articulated::default(),
        }
    }
}

impl Tree {
    /// Creates the mechanism in the given state. `start` has one state per body.
    pub(super) fn new(mechanism: &Mechanism, start: &[MovingPose]) -> Self {
        let mut start = start.to_vec();
        let root = match mechanism.bodies[0].joint {
            JointModel::Fixed => RootMount::Fixed,
            JointModel::Free => RootMount::Driven,
            _ => RootMount::ByJoint,
        };
        if root == RootMount::Fixed {
            (start[0].angular_rad_s, start[0].linear_m_s) = (DVec3::ZERO, DVec3::ZERO);
        }
        let links = mechanism.bodies.iter().zip(&start).map(|(body, state)| {
            let parent = body.parent.map(|parent| &start[parent]);
            Link::new(body, state, parent)
        });
        let mut links: Vec<Link> = links.collect();
        let (root_position_m, root_velocity_m_s) = if root == RootMount::ByJoint {
            let InParent { pose, slide_m_s, .. } = links[0].in_parent;
            (pose.position_m, slide_m_s)
        } else {
            links[0].joint = None;
            (start[0].pose.position_m, start[0].linear_m_s)
        };
        let mut tree = Self {
            root,
            gravity_m_s2: GRAVITY_M_S2,
            root_position_m,
            root_velocity_m_s,
            root_acceleration_m_s2: DVec3::ZERO,
            root_force_n: DVec3::ZERO,
            links,
        };
        tree.update_world();
        tree
    }

    /// Converts the drives to the axes of the bodies on which they act.
    pub(super) fn set_drive(&mut self, drive: &Drive) {
        let drives = drive.torque_nm.iter().zip(&drive.force_n);
        for (link, (torque_nm, force_n)) in self.links.iter_mut().zip(drives) {
            link.torque_nm = link.world.axes.transpose() * *torque_nm;
            if let Some(joint) = &mut link.joint {
                joint.force_n = link.world.axes.transpose() * *force_n;
            }
        }
        self.root_force_n = self.links[0].world.axes.transpose() * drive.force_n[0];
    }

    /// Integrates by semi-implicit Euler over `h` seconds: velocities first, then rotations by the exponential map
    /// of the new velocities.
    pub(super) fn advance(&mut self, h: f64) {
        for link in &mut self.links {
            if let Some(joint) = &mut link.joint {
                joint.advance(h, &mut link.in_parent);
                continue;
            }
            let at = &mut link.in_parent;
            at.spin_rad_s += h * link.spin_rate_rad_s2;
            let turn = DQuat::from_scaled_axis(h * at.spin_rad_s);
            at.pose.rotation = (at.pose.rotation * turn).normalize();
        }
        match self.root {
            RootMount::ByJoint => {
                let InParent { pose, slide_m_s, .. } = self.links[0].in_parent;
                (self.root_position_m, self.root_velocity_m_s) = (pose.position_m, slide_m_s);
            }
            RootMount::Fixed | RootMount::Driven => {
                self.root_velocity_m_s += h * self.root_acceleration_m_s2;
                self.root_position_m += h * self.root_velocity_m_s;
            }
        }
        self.update_world();
    }

    fn update_world(&mut self) {
        for index in 0..self.links.len() {
            let (above, below) = self.links.split_at_mut(index);
            let link = &mut below[0];
            let parent = link.parent.map(|parent| &above[parent].world);
            link.world = link.in_world(parent);
            if let Some(joint) = &mut link.joint {
                let still = World { axes: DMat3::IDENTITY, ..World::default() };
                joint.update_motion_axes(
                    &link.in_parent.pose,
                    parent.unwrap_or(&still),
                    &link.world,
                );
                link.world.angular_bias_rad_s2 += joint.bias_rad_s2();
            }
        }
    }

    /// Reads the poses of all bodies into `poses`.
    pub(super) fn poses(&self, poses: &mut Vec<Pose>) {
        poses.clear();
        for Link { parent, world, .. } in &self.links {
            let position_m = match parent {
                Some(parent) => poses[*parent].position_m + world.arm_m,
                None => self.root_position_m,
            };
            poses.push(Pose { rotation: world.rotation, position_m });
        }
    }

    /// Returns the poses and velocities of all bodies, from their `poses`.
    pub(super) fn motions(&self, poses: &[Pose]) -> Vec<MovingPose> {
        let mut motions: Vec<MovingPose> = Vec::with_capacity(poses.len());
        for (Link { parent, world, .. }, pose) in self.links.iter().zip(poses) {
            let linear_m_s = parent.map_or(self.root_velocity_m_s, |parent| {
                let parent = &motions[parent];
                parent.linear_m_s + parent.angular_rad_s.cross(world.arm_m) + world.slide_m_s
            });
            motions.push(MovingPose {
                pose: *pose,
                angular_rad_s: world.angular_rad_s,
                linear_m_s,
            });
        }
        motions
    }
}

impl Link {
    fn in_world(&self, parent: Option<&World>) -> World {
        let InParent { pose, spin_rad_s, slide_m_s } = self.in_parent;
        let Some(parent) = parent else {
            let axes = DMat3::from_quat(pose.rotation);
            let angular_rad_s = axes * spin_rad_s;
            let rotation = pose.rotation;
            return World { rotation, axes, angular_rad_s, spin_rad_s, ..World::default() };
        };
        let rotation = parent.rotation * pose.rotation;
        let axes = DMat3::from_quat(rotation);
        let arm_m = parent.axes * pose.position_m;
        let spin = axes * spin_rad_s;
        let mut world = World {
            rotation,
            axes,
            arm_m,
            angular_rad_s: parent.angular_rad_s + spin,
            slide_m_s: DVec3::ZERO,
            angular_bias_rad_s2: parent.angular_rad_s.cross(spin),
            linear_bias_m_s2: parent.angular_rad_s.cross(parent.angular_rad_s.cross(arm_m)),
            spin_rad_s,
        };
        if self.joint.is_some() {
            world.slide_m_s = parent.axes * slide_m_s;
            world.linear_bias_m_s2 += 2.0 * parent.angular_rad_s.cross(world.slide_m_s);
        }
        world
    }
}
