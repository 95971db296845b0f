//! The tree of bodies, its state, and how the state goes on.

use glam::{DMat3, DQuat, DVec3};

use super::dynamics::{Articulated, skew};
use crate::plant::{Drive, GRAVITY_M_S2, Mechanism, MovingPose, PlantBody, Pose, Root};

/// A tree of bodies in reduced coordinates; parents come before children.
#[derive(Debug, Clone)]
pub(super) struct Tree {
    pub(super) root: Root,
    pub(super) gravity_m_s2: DVec3,
    /// Of the root's origin, in the world.
    root_position_m: DVec3,
    /// Of the root's origin, world axes.
    root_velocity_m_s: DVec3,
    /// Classical acceleration of the root's origin, world axes.
    pub(super) root_acceleration_m_s2: DVec3,
    /// Force on the root's origin, in the root's axes.
    pub(super) root_force_n: DVec3,
    pub(super) links: Vec<Link>,
}

/// A body and the joint that it turns on; the root turns against the world.
#[derive(Debug, Clone)]
pub(super) struct Link {
    pub(super) parent: Option<usize>,
    /// Position of the joint in the parent's frame.
    offset_m: DVec3,
    pub(super) mass_kg: f64,
    /// Mass times centre of mass, body axes.
    pub(super) first_moment_kg_m: DVec3,
    /// Rotational inertia about the joint, body axes.
    pub(super) rotational_kg_m2: DMat3,

    /// Rotation from the body to its parent, unit.
    rotation: DQuat,
    /// Angular velocity against the parent, body axes.
    spin_rad_s: DVec3,
    /// Derivative of the components of `spin_rad_s`.
    pub(super) spin_rate_rad_s2: DVec3,
    /// Torque of the joint on the body, body axes.
    pub(super) torque_nm: DVec3,

    pub(super) world: World,
    pub(super) articulated: Articulated,
}

/// Where a body is and how it turns, world axes: what follows from the joints.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct World {
    rotation: DQuat,
    /// The rotation as a matrix.
    pub(super) axes: DMat3,
    /// From the parent's joint to this one.
    pub(super) arm_m: DVec3,
    pub(super) angular_rad_s: DVec3,
    /// Angular acceleration less the parent's, if the components of the spin stay.
    pub(super) angular_bias_rad_s2: DVec3,
    /// Acceleration of the joint less the parent's, if the parent turns steadily.
    pub(super) linear_bias_m_s2: DVec3,
}

impl Link {
    /// The body on its joint, in the state that the body and its parent are in.
    fn new(body: &PlantBody, state: &MovingPose, parent: Option<&MovingPose>) -> Self {
        let (rotation, angular) = parent.map_or((DQuat::IDENTITY, DVec3::ZERO), |parent| {
            (parent.pose.rotation, parent.angular_rad_s)
        });
        let first_moment = body.mass.mass_kg * body.mass.center_of_mass_m;
        let about_joint = skew(first_moment) * skew(body.mass.center_of_mass_m).transpose();
        Self {
            parent: body.parent,
            offset_m: body.offset_m,
            mass_kg: body.mass.mass_kg,
            first_moment_kg_m: first_moment,
            rotational_kg_m2: body.mass.rotational_kg_m2 + about_joint,
            rotation: (rotation.conjugate() * state.pose.rotation).normalize(),
            spin_rad_s: state.pose.rotation.conjugate() * (state.angular_rad_s - angular),
            spin_rate_rad_s2: DVec3::ZERO,
            torque_nm: DVec3::ZERO,
            world: World::default(),
            articulated: Articulated::default(),
        }
    }
}

impl Tree {
    /// The mechanism in the given state, one of `start` per body.
    pub(super) fn new(mechanism: &Mechanism, start: &[MovingPose]) -> Self {
        let mut start = start.to_vec();
        if mechanism.root == Root::Fixed {
            (start[0].angular_rad_s, start[0].linear_m_s) = (DVec3::ZERO, DVec3::ZERO);
        }
        let links = mechanism.bodies.iter().zip(&start).map(|(body, state)| {
            let parent = body.parent.map(|parent| &start[parent]);
            Link::new(body, state, parent)
        });
        let mut tree = Self {
            root: mechanism.root,
            gravity_m_s2: GRAVITY_M_S2,
            root_position_m: start[0].pose.position_m,
            root_velocity_m_s: start[0].linear_m_s,
            root_acceleration_m_s2: DVec3::ZERO,
            root_force_n: DVec3::ZERO,
            links: links.collect(),
        };
        tree.update_world();
        tree
    }

    /// Takes the drives to the axes of the bodies that they act on.
    pub(super) fn set_drive(&mut self, drive: &Drive) {
        for (link, torque_nm) in self.links.iter_mut().zip(&drive.torque_nm) {
            link.torque_nm = link.world.axes.transpose() * *torque_nm;
        }
        self.root_force_n = self.links[0].world.axes.transpose() * drive.root_force_n;
    }

    /// Semi-implicit Euler over `h` seconds: the velocities first, then the rotations by the exponential map
    /// of the new ones.
    pub(super) fn advance(&mut self, h: f64) {
        for link in &mut self.links {
            link.spin_rad_s += h * link.spin_rate_rad_s2;
            let turn = DQuat::from_scaled_axis(h * link.spin_rad_s);
            link.rotation = (link.rotation * turn).normalize();
        }
        self.root_velocity_m_s += h * self.root_acceleration_m_s2;
        self.root_position_m += h * self.root_velocity_m_s;
        self.update_world();
    }

    fn update_world(&mut self) {
        for index in 0..self.links.len() {
            let (above, below) = self.links.split_at_mut(index);
            let link = &mut below[0];
            let parent = link.parent.map(|parent| &above[parent].world);
            link.world = link.in_world(parent);
        }
    }

    /// Reads the poses of all bodies.
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

    /// Reads how the bodies move, their `poses` being known.
    pub(super) fn motions(&self, poses: &[Pose]) -> Vec<MovingPose> {
        let mut motions: Vec<MovingPose> = Vec::with_capacity(poses.len());
        for (Link { parent, world, .. }, pose) in self.links.iter().zip(poses) {
            let linear_m_s = parent.map_or(self.root_velocity_m_s, |parent| {
                let parent = &motions[parent];
                parent.linear_m_s + parent.angular_rad_s.cross(world.arm_m)
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
        let Some(parent) = parent else {
            let axes = DMat3::from_quat(self.rotation);
            let angular_rad_s = axes * self.spin_rad_s;
            return World { rotation: self.rotation, axes, angular_rad_s, ..World::default() };
        };
        let rotation = parent.rotation * self.rotation;
        let axes = DMat3::from_quat(rotation);
        let arm_m = parent.axes * self.offset_m;
        let spin = axes * self.spin_rad_s;
        World {
            rotation,
            axes,
            arm_m,
            angular_rad_s: parent.angular_rad_s + spin,
            angular_bias_rad_s2: parent.angular_rad_s.cross(spin),
            linear_bias_m_s2: parent.angular_rad_s.cross(parent.angular_rad_s.cross(arm_m)),
        }
    }
}
