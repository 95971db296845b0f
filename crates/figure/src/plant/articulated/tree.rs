//! The tree of bodies, its state, and the integration of the state.

use glam::{DMat3, DQuat, DVec3};

use super::articulated_body::{ArticulatedLanes, ReleasedLanes};
use super::joint::Joint;
use super::lanes::{Matrices, Rotations, Vectors};
use super::spatial::{InParent, InParents, Motions, World, Worlds, skew};
use super::turn::{small_turn, unit};
use crate::plant::{Drive, GRAVITY_M_S2, JointModel, Link as Given, Mechanism, MovingPose, Pose};

/// Trees of bodies in reduced coordinates, with the same joints. Parents precede their children.
#[derive(Debug, Clone)]
pub(super) struct Tree<const L: usize> {
    pub(super) root: RootMount,
    pub(super) gravity_m_s2: DVec3,
    /// Position of the root's origin, in the world.
    root_position_m: Vectors<L>,
    /// Velocity of the root's origin, world axes.
    root_velocity_m_s: Vectors<L>,
    /// Classical acceleration of the root's origin, world axes.
    pub(super) root_acceleration_m_s2: Vectors<L>,
    /// Force on the root's origin, in the root's axes.
    pub(super) root_force_n: Vectors<L>,
    pub(super) links: Vec<Link<L>>,
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

/// A body and its joint in each tree. The root moves relative to the world.
#[derive(Debug, Clone)]
pub(super) struct Link<const L: usize> {
    pub(super) parent: Option<usize>,
    pub(super) mass_kg: [f64; L],
    /// Mass times centre of mass, body axes.
    pub(super) first_moment_kg_m: Vectors<L>,
    /// Rotational inertia about the joint, body axes.
    pub(super) rotational_kg_m2: Matrices<L>,

    pub(super) in_parent: InParents<L>,
    /// Acceleration of the spin along the joint's dofs, body axes.
    pub(super) spin_rate_rad_s2: Vectors<L>,
    /// Acceleration of the slide along the joint's dofs, body axes.
    pub(super) slide_rate_m_s2: Vectors<L>,
    /// Torque of the joint on the body, body axes.
    pub(super) torque_nm: Vectors<L>,
    /// The joints, unless they are ball joints that turn freely.
    ///
    /// Boxed since they are large: trees of ball joints then fit the processor's nearest cache.
    pub(super) joints: Option<Box<[Joint; L]>>,

    pub(super) world: Worlds<L>,
    pub(super) articulated: ArticulatedLanes<L>,
    pub(super) released: ReleasedLanes<L>,
    /// Angular acceleration, and acceleration of the joint minus gravity.
    pub(super) acceleration: Motions<L>,
}

impl Link<1> {
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
        let joint = Joint::new(body, &in_parent);
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
        let mut link = Self {
            parent: body.parent,
            mass_kg: [body.mass_kg],
            joints: joint.map(|joint| Box::new([joint])),
            ..Self::STILL
        };
        link.first_moment_kg_m.set(0, first_moment);
        link.rotational_kg_m2.set(0, body.inertia_kg_m2 + about_joint);
        link.in_parent.set(0, &in_parent);
        link
    }
}

impl<const L: usize> Link<L> {
    /// A body without a mass that is fixed to the world.
    const STILL: Self = Self {
        parent: None,
        mass_kg: [0.0; L],
        first_moment_kg_m: Vectors::ZERO,
        rotational_kg_m2: Matrices::ZERO,
        in_parent: InParents::STILL,
        spin_rate_rad_s2: Vectors::ZERO,
        slide_rate_m_s2: Vectors::ZERO,
        torque_nm: Vectors::ZERO,
        joints: None,
        world: Worlds::STILL,
        articulated: ArticulatedLanes::ZERO,
        released: ReleasedLanes::ZERO,
        acceleration: Motions::ZERO,
    };

    /// Returns the joints of the trees; none for ball joints that turn freely.
    pub(super) fn joints(&self) -> &[Joint] {
        self.joints.as_deref().map_or(&[], <[Joint; L]>::as_slice)
    }

    /// Returns the joint of a tree; `None` for a ball joint that turns freely.
    pub(super) fn joint_mut(&mut self, lane: usize) -> Option<&mut Joint> {
        self.joints.as_mut().map(|joints| &mut joints[lane])
    }
}

impl Tree<1> {
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
        let mut links: Vec<Link<1>> = links.collect();
        let (root_position_m, root_velocity_m_s) = if root == RootMount::ByJoint {
            let InParent { pose, slide_m_s, .. } = links[0].in_parent.at(0);
            (pose.position_m, slide_m_s)
        } else {
            links[0].joints = None;
            (start[0].pose.position_m, start[0].linear_m_s)
        };
        let mut tree = Self::empty(root, GRAVITY_M_S2);
        tree.root_position_m.set(0, root_position_m);
        tree.root_velocity_m_s.set(0, root_velocity_m_s);
        tree.links = links;
        tree.update_world();
        tree
    }
}

impl<const L: usize> Tree<L> {
    const fn empty(root: RootMount, gravity_m_s2: DVec3) -> Self {
        Self {
            root,
            gravity_m_s2,
            root_position_m: Vectors::ZERO,
            root_velocity_m_s: Vectors::ZERO,
            root_acceleration_m_s2: Vectors::ZERO,
            root_force_n: Vectors::ZERO,
            links: Vec::new(),
        }
    }

    /// Joins trees of ball joints that turn freely, each in its state; `None` if a tree has another joint, or if the
    /// trees or their gravity differ. Other joints decide so much that vector instructions would gain nothing.
    pub(super) fn join(trees: [&Tree<1>; L]) -> Option<Self> {
        let first = trees[0];
        let alike = |tree: &&Tree<1>| {
            let links = tree.links.iter().zip(&first.links);
            tree.root == first.root
                && tree.gravity_m_s2 == first.gravity_m_s2
                && tree.links.len() == first.links.len()
                && links
                    .into_iter()
                    .all(|(link, first)| link.parent == first.parent && link.joints.is_none())
        };
        if !trees.iter().all(alike) {
            return None;
        }
        let mut joined = Self::empty(first.root, first.gravity_m_s2);
        for (lane, tree) in trees.iter().enumerate() {
            joined.root_position_m.set(lane, tree.root_position_m.at(0));
            joined.root_velocity_m_s.set(lane, tree.root_velocity_m_s.at(0));
        }
        for (index, first) in first.links.iter().enumerate() {
            let mut link = Link { parent: first.parent, ..Link::STILL };
            let of_trees = trees.map(|tree| &tree.links[index]);
            for (lane, of_tree) in of_trees.iter().enumerate() {
                link.mass_kg[lane] = of_tree.mass_kg[0];
                link.first_moment_kg_m.set(lane, of_tree.first_moment_kg_m.at(0));
                link.rotational_kg_m2.set(lane, of_tree.rotational_kg_m2.at(0));
                link.in_parent.set(lane, &of_tree.in_parent.at(0));
            }
            joined.links.push(link);
        }
        joined.update_world();
        Some(joined)
    }

    /// Converts the drives to the axes of the bodies on which they act.
    #[inline(always)]
    pub(super) fn set_drives(&mut self, drives: &[&Drive; L]) {
        for (index, link) in self.links.iter_mut().enumerate() {
            for (lane, drive) in drives.iter().enumerate() {
                let to_body = link.world.axes.at(lane).transpose();
                link.torque_nm.set(lane, to_body * drive.torque_nm[index]);
                if let Some(joint) = link.joint_mut(lane) {
                    joint.force_n = to_body * drive.force_n[index];
                }
            }
        }
        for (lane, drive) in drives.iter().enumerate() {
            let to_body = self.links[0].world.axes.at(lane).transpose();
            self.root_force_n.set(lane, to_body * drive.force_n[0]);
        }
    }

    /// Integrates by semi-implicit Euler over `h` seconds: velocities first, then rotations by the exponential map
    /// of the new velocities.
    #[inline(always)]
    pub(super) fn advance(&mut self, h: f64) {
        for link in &mut self.links {
            let at = &mut link.in_parent;
            if let Some(joints) = &mut link.joints {
                for (lane, joint) in joints.iter_mut().enumerate() {
                    let mut one = at.at(lane);
                    joint.advance(h, &mut one);
                    at.set(lane, &one);
                }
                continue;
            }
            let mut turns = Rotations::<L>::IDENTITY;
            let mut all_are_small = true;
            for lane in 0..L {
                let spin_rad_s = at.spin_rad_s.at(lane) + h * link.spin_rate_rad_s2.at(lane);
                at.spin_rad_s.set(lane, spin_rad_s);
                let (turn, is_small) = small_turn(h * spin_rad_s);
                turns.set(lane, turn);
                all_are_small &= is_small;
            }
            if !all_are_small {
                for lane in 0..L {
                    turns.set(lane, DQuat::from_scaled_axis(h * at.spin_rad_s.at(lane)));
                }
            }
            for lane in 0..L {
                at.rotation.set(lane, unit(at.rotation.at(lane) * turns.at(lane)));
            }
        }
        for lane in 0..L {
            let (position_m, velocity_m_s) = if self.root == RootMount::ByJoint {
                let InParent { pose, slide_m_s, .. } = self.links[0].in_parent.at(lane);
                (pose.position_m, slide_m_s)
            } else {
                let rate_m_s2 = self.root_acceleration_m_s2.at(lane);
                let velocity_m_s = self.root_velocity_m_s.at(lane) + h * rate_m_s2;
                (self.root_position_m.at(lane) + h * velocity_m_s, velocity_m_s)
            };
            self.root_position_m.set(lane, position_m);
            self.root_velocity_m_s.set(lane, velocity_m_s);
        }
        self.update_world();
    }

    #[inline(always)]
    fn update_world(&mut self) {
        for index in 0..self.links.len() {
            let (above, below) = self.links.split_at_mut(index);
            let link = &mut below[0];
            let Some(parent) = link.parent else {
                for lane in 0..L {
                    let InParent { pose, spin_rad_s, .. } = link.in_parent.at(lane);
                    let axes = DMat3::from_quat(pose.rotation);
                    let angular_rad_s = axes * spin_rad_s;
                    let rotation = pose.rotation;
                    let world = World { rotation, axes, angular_rad_s, ..World::default() };
                    link.world.set(lane, &world);
                }
                if link.joints.is_some() {
                    let still = World { axes: DMat3::IDENTITY, ..World::default() };
                    for lane in 0..L {
                        link.update_motion_axes(lane, &still);
                    }
                }
                continue;
            };
            let parent = &above[parent].world;
            // A variable of this function: the compiler then knows that it overlaps nothing.
            let mut worlds = Worlds::<L>::STILL;
            for lane in 0..L {
                let world = in_world(&parent.at(lane), &link.in_parent.at(lane));
                worlds.set(lane, &world);
            }
            link.world = worlds;
            if link.joints.is_some() {
                for lane in 0..L {
                    let parent = parent.at(lane);
                    let mut world = link.world.at(lane);
                    world.slide_m_s = parent.axes * link.in_parent.slide_m_s.at(lane);
                    world.linear_bias_m_s2 += 2.0 * parent.angular_rad_s.cross(world.slide_m_s);
                    link.world.set(lane, &world);
                    link.update_motion_axes(lane, &parent);
                }
            }
        }
    }

    /// Reads the poses of all bodies of each tree into `poses`.
    #[inline(always)]
    pub(super) fn poses(&self, poses: &mut [Vec<Pose>; L]) {
        for (lane, poses) in poses.iter_mut().enumerate() {
            poses.clear();
            for Link { parent, world, .. } in &self.links {
                let position_m = match parent {
                    Some(parent) => poses[*parent].position_m + world.arm_m.at(lane),
                    None => self.root_position_m.at(lane),
                };
                poses.push(Pose { rotation: world.rotation.at(lane), position_m });
            }
        }
    }
}

impl Tree<1> {
    /// Returns the poses and velocities of all bodies, from their `poses`.
    pub(super) fn motions(&self, poses: &[Pose]) -> Vec<MovingPose> {
        let mut motions: Vec<MovingPose> = Vec::with_capacity(poses.len());
        for (Link { parent, world, .. }, pose) in self.links.iter().zip(poses) {
            let world = world.at(0);
            let linear_m_s = parent.map_or(self.root_velocity_m_s.at(0), |parent| {
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

impl<const L: usize> Link<L> {
    /// Updates the motion axes of a joint, if it has any, and the bias that they cause.
    fn update_motion_axes(&mut self, lane: usize, parent: &World) {
        let (in_parent, mut world) = (self.in_parent.at(lane), self.world.at(lane));
        let Some(joint) = self.joint_mut(lane) else { return };
        joint.update_motion_axes(&in_parent, parent, &world);
        world.angular_bias_rad_s2 += joint.bias_rad_s2();
        self.world.set(lane, &world);
    }
}

/// Returns the motion of a body whose joint does not slide.
#[inline(always)]
fn in_world(parent: &World, in_parent: &InParent) -> World {
    let InParent { pose, spin_rad_s, .. } = *in_parent;
    let rotation = parent.rotation * pose.rotation;
    let axes = DMat3::from_quat(rotation);
    let arm_m = parent.axes * pose.position_m;
    let spin = axes * spin_rad_s;
    World {
        rotation,
        axes,
        arm_m,
        angular_rad_s: parent.angular_rad_s + spin,
        slide_m_s: DVec3::ZERO,
        angular_bias_rad_s2: parent.angular_rad_s.cross(spin),
        linear_bias_m_s2: parent.angular_rad_s.cross(parent.angular_rad_s.cross(arm_m)),
    }
}
