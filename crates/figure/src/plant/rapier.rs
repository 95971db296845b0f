//! The paper's kind of plant: the game engine rapier in maximal coordinates, where constraints hold the bodies
//! together.
//!
//! The engine's defaults are made for contacts and stacks, not for torques that cancel the dynamics at the same
//! instant: see [`EngineSettings`].

mod settings;

use ::nalgebra as na;
use glam::{DMat3, DQuat, DVec3};
use rapier3d_f64::prelude::{
    BroadPhaseBvh, CCDSolver, ColliderSet, GenericJoint, GenericJointBuilder, ImpulseJointSet,
    IntegrationParameters, IslandManager, JointAxesMask, JointAxis, MassProperties as EngineMass,
    MotorModel, MultibodyJointSet, NarrowPhase, PhysicsPipeline, Pose, RigidBodyBuilder,
    RigidBodyHandle, RigidBodySet, RigidBodyType, Rotation, SoftBodySet, SphericalJointBuilder,
    Vector,
};

use super::check::check;
use super::{
    Drive, GRAVITY_M_S2, JointModel, Link as Given, Mechanism, MovingPose, Plant, PlantError,
    Pose as BodyPose,
};
pub use settings::EngineSettings;
use settings::GyroscopicTerm;

/// A mechanism in rapier, in f64.
pub struct RapierPlant {
    settings: EngineSettings,
    pipeline: PhysicsPipeline,
    parameters: IntegrationParameters,
    islands: IslandManager,
    broad_phase: BroadPhaseBvh,
    narrow_phase: NarrowPhase,
    bodies: RigidBodySet,
    colliders: ColliderSet,
    joints: ImpulseJointSet,
    multibody_joints: MultibodyJointSet,
    soft_bodies: SoftBodySet,
    ccd_solver: CCDSolver,
    links: Vec<Link>,
    poses: Vec<BodyPose>,
}

/// A body as the engine represents it.
struct Link {
    handle: RigidBodyHandle,
    parent: Option<usize>,
    joint: JointModel,
    /// Rotation of the joint frame in the parent's frame.
    placement: DQuat,
    /// Rotational inertia about the centre of mass, body axes.
    rotational_kg_m2: DMat3,
}

impl RapierPlant {
    /// Builds the mechanism in the given state.
    ///
    /// `start` contains one state per body. The poses must fit the joints; otherwise the first step pulls them
    /// together with a jump. The engine keeps the torques constant in world axes over all substeps.
    ///
    /// # Errors
    /// [`PlantError`] if this is not a tree with a state for each body, a number is physically impossible, the step or
    /// the substeps are not positive, or the engine does not simulate a joint or a body or does not reproduce a body's
    /// inertia.
    pub fn new(
        mechanism: &Mechanism,
        start: &[MovingPose],
        dt_s: f64,
        substeps: usize,
        settings: EngineSettings,
    ) -> Result<Self, PlantError> {
        check(mechanism, start, dt_s, substeps)?;
        let bodies = &mechanism.bodies;
        let parameters = IntegrationParameters {
            dt: dt_s,
            num_solver_iterations: substeps * settings.solver_iterations,
            num_internal_pgs_iterations: settings.sweeps,
            max_ccd_substeps: 0,
            ..IntegrationParameters::default()
        };
        let mut plant = Self {
            settings,
            pipeline: PhysicsPipeline::new(),
            parameters,
            islands: IslandManager::new(),
            broad_phase: BroadPhaseBvh::new(),
            narrow_phase: NarrowPhase::new(),
            bodies: RigidBodySet::new(),
            colliders: ColliderSet::new(),
            joints: ImpulseJointSet::new(),
            multibody_joints: MultibodyJointSet::new(),
            soft_bodies: SoftBodySet::new(),
            ccd_solver: CCDSolver::new(),
            links: Vec::with_capacity(bodies.len()),
            poses: Vec::with_capacity(bodies.len()),
        };
        for (index, (body, start)) in bodies.iter().zip(start).enumerate() {
            plant.insert(index, body, start)?;
        }
        if mechanism.bodies[0].joint == JointModel::Fixed
            && let Some(root) = plant.links.first()
        {
            plant.bodies[root.handle].set_body_type(RigidBodyType::Fixed, true);
        }
        plant.read_poses();
        Ok(plant)
    }

    fn insert(&mut self, index: usize, body: &Given, start: &MovingPose) -> Result<(), PlantError> {
        if let Some(what) = not_simulated(body) {
            return Err(PlantError::Engine { body: index, what });
        }
        let mass = mass_properties(body);
        let relative = inertia_difference(&mass, &body.inertia_kg_m2);
        if relative > 1e-12 {
            return Err(PlantError::Inertia { body: index, relative });
        }
        // The engine's velocity is that of the centre of mass.
        let arm = start.pose.rotation * body.center_of_mass_m;
        let center_velocity = start.linear_m_s + start.angular_rad_s.cross(arm);
        let rigid_body = RigidBodyBuilder::dynamic()
            .pose(Pose::from_parts(vector(start.pose.position_m), rotation(start.pose.rotation)))
            .linvel(vector(center_velocity))
            .angvel(vector(start.angular_rad_s))
            .additional_mass_properties(mass)
            // A figure must not fall asleep at the turning point of a swing.
            .can_sleep(false)
            .allow_fast_rotation(self.settings.fast_rotation)
            .gyroscopic_forces_enabled(self.settings.gyroscopic_term == GyroscopicTerm::Engine)
            .build();
        let handle = self.bodies.insert(rigid_body);
        // Until the first step the engine has no mass and no centre of mass, but the first force acts before.
        self.bodies[handle].recompute_mass_properties_from_colliders(&self.colliders);
        if let (Some(parent), Some(joint)) = (body.parent, engine_joint(body)) {
            self.joints.insert(self.links[parent].handle, handle, joint, true);
        }
        self.links.push(Link {
            handle,
            parent: body.parent,
            joint: body.joint,
            placement: body.rotation,
            rotational_kg_m2: body.inertia_kg_m2,
        });
        Ok(())
    }

    fn read_poses(&mut self) {
        self.poses.clear();
        self.poses.extend(self.links.iter().map(|link| {
            let pose = self.bodies[link.handle].position();
            let [x, y, z, w] = pose.rotation.to_array();
            BodyPose {
                rotation: DQuat::from_xyzw(x, y, z, w),
                position_m: DVec3::from_array(pose.translation.to_array()),
            }
        }));
    }
}

impl Plant for RapierPlant {
    fn step(&mut self, drive: &Drive) {
        for link in &self.links {
            // Without the reset, forces would accumulate from step to step.
            let body = &mut self.bodies[link.handle];
            body.reset_forces(true);
            body.reset_torques(true);
        }
        let drives = drive.torque_nm.iter().zip(&drive.force_n);
        for (index, (link, (torque_nm, force_n))) in self.links.iter().zip(drives).enumerate() {
            let (torque_nm, force_n) = link.followed(*torque_nm, *force_n, &self.poses);
            let body = &mut self.bodies[link.handle];
            body.add_torque(vector(torque_nm), true);
            if self.settings.gyroscopic_term == GyroscopicTerm::Plant {
                let spin = DVec3::from_array(body.angvel().to_array());
                let axes = DMat3::from_quat(self.poses[index].rotation);
                let momentum = axes * (link.rotational_kg_m2 * (axes.transpose() * spin));
                body.add_torque(vector(-spin.cross(momentum)), true);
            }
            if let Some(parent) = link.parent {
                let parent = self.links[parent].handle;
                self.bodies[parent].add_torque(vector(-torque_nm), true);
                if force_n != DVec3::ZERO {
                    let origin = self.bodies[link.handle].translation();
                    self.bodies[link.handle].add_force_at_point(vector(force_n), origin, true);
                    self.bodies[parent].add_force_at_point(vector(-force_n), origin, true);
                }
            } else {
                let origin = body.translation();
                body.add_force_at_point(vector(force_n), origin, true);
            }
        }
        self.pipeline.step(
            vector(GRAVITY_M_S2),
            &self.parameters,
            &mut self.islands,
            &mut self.broad_phase,
            &mut self.narrow_phase,
            &mut self.bodies,
            &mut self.colliders,
            &mut self.joints,
            &mut self.multibody_joints,
            &mut self.soft_bodies,
            &mut self.ccd_solver,
            &(),
            &(),
        );
        self.read_poses();
    }

    fn poses(&self) -> &[BodyPose] {
        &self.poses
    }
}

impl Link {
    /// Returns the components of a torque and a force (world axes) along which the joint can move. For the root, both
    /// are returned unchanged.
    fn followed(&self, torque_nm: DVec3, force_n: DVec3, poses: &[BodyPose]) -> (DVec3, DVec3) {
        let Some(parent) = self.parent.map(|parent| poses[parent].rotation) else {
            return (torque_nm, force_n);
        };
        let along = |axis: DVec3, v: DVec3| {
            let axis = parent * (self.placement * axis);
            axis * axis.dot(v)
        };
        match self.joint {
            JointModel::Revolute(axis) => (along(axis, torque_nm), DVec3::ZERO),
            JointModel::Prismatic(axis) => (DVec3::ZERO, along(axis, force_n)),
            JointModel::Fixed => (DVec3::ZERO, DVec3::ZERO),
            // Universal joints are refused.
            JointModel::Spherical | JointModel::Universal(_) => (torque_nm, DVec3::ZERO),
            JointModel::Free => (torque_nm, force_n),
        }
    }
}

/// Returns a description of a feature of the body or of its joint that the engine does not simulate, if there is any.
fn not_simulated(body: &Given) -> Option<&'static str> {
    let held = body.friction > 0.0 || body.damping > 0.0 || !body.ranges.is_empty();
    if body.rotor_inertia > 0.0 {
        // Maximal coordinates have no coordinate for the rotor's rotation.
        return Some("a rotor has inertia");
    }
    let bolted = body.joint == JointModel::Fixed && body.parent.is_none();
    if !bolted && (body.mass_kg == 0.0 || body.inertia_kg_m2.determinant() <= 0.0) {
        return Some("a body without mass or extent");
    }
    match (body.joint, body.parent) {
        (JointModel::Universal(_), _) => Some("a universal joint"),
        (JointModel::Fixed | JointModel::Free, None) => None,
        (_, None) => Some("a root that is neither bolted nor free"),
        (JointModel::Spherical | JointModel::Free, _) if held => {
            Some("friction or a range of a joint of more than one axis")
        }
        (JointModel::Revolute(_) | JointModel::Prismatic(_), _)
            if body.friction > 0.0 && body.damping > 0.0 =>
        {
            Some("a joint has both kinds of friction")
        }
        _ => None,
    }
}

/// Returns the joint of a body in the engine's form. Ranges become its limits. Friction becomes its motor, which
/// resists motion with a bounded force or a force proportional to the speed. `None` for a free joint, for which the
/// engine needs no joint.
fn engine_joint(body: &Given) -> Option<GenericJoint> {
    let at = vector(body.position_m);
    let (axis, locked, free) = match body.joint {
        JointModel::Free => return None,
        JointModel::Spherical | JointModel::Universal(_) => {
            let joint = SphericalJointBuilder::new()
                .local_anchor1(at)
                .local_anchor2(Vector::ZERO)
                .contacts_enabled(false);
            return Some(joint.build().into());
        }
        JointModel::Fixed => (DVec3::X, JointAxesMask::LOCKED_FIXED_AXES, None),
        JointModel::Revolute(axis) => {
            (axis, JointAxesMask::LOCKED_REVOLUTE_AXES, Some(JointAxis::AngX))
        }
        JointModel::Prismatic(axis) => {
            (axis, JointAxesMask::LOCKED_PRISMATIC_AXES, Some(JointAxis::LinX))
        }
    };
    // The engine's axis is the x axis of a frame of the joint.
    let frame = DQuat::from_rotation_arc(DVec3::X, axis);
    let mut joint = GenericJointBuilder::new(locked)
        .local_frame1(Pose::from_parts(at, rotation(body.rotation * frame)))
        .local_frame2(Pose::from_parts(Vector::ZERO, rotation(frame)))
        .contacts_enabled(false);
    if let Some(free) = free {
        if let Some([least, most]) = body.ranges.first() {
            joint = joint.limits(free, [*least, *most]);
        }
        if body.friction > 0.0 {
            joint = joint
                .motor_model(free, MotorModel::ForceBased)
                .motor_velocity(free, 0.0, STIFF)
                .motor_max_force(free, body.friction);
        } else if body.damping > 0.0 {
            joint = joint.motor_model(free, MotorModel::ForceBased).motor_velocity(
                free,
                0.0,
                body.damping,
            );
        }
    }
    Some(joint.build())
}

/// Friction per rad/s or m/s, high enough for a motor with a bounded force to reach its bound: N m s, or N s/m.
const STIFF: f64 = 1e6;

/// Converts through arrays, since the engine has its own version of glam.
fn vector(v: DVec3) -> Vector {
    Vector::from_array(v.to_array())
}

fn rotation(q: DQuat) -> Rotation {
    Rotation::from_xyzw(q.x, q.y, q.z, q.w)
}

/// Computes mass properties by our own eigen-decomposition: the engine's conversion of an inertia matrix is wrong
/// for tilted bodies whose smaller principal moments are equal.
fn mass_properties(body: &Given) -> EngineMass {
    let matrix = na::Matrix3::from_fn(|row, column| body.inertia_kg_m2.col(column)[row]);
    let mut axes = matrix.symmetric_eigen().eigenvectors;
    if axes.determinant() < 0.0 {
        axes.swap_columns(0, 1);
    }
    let moments = axes.transpose() * matrix * axes;
    let axes = na::Rotation3::from_matrix_unchecked(axes);
    let frame = na::UnitQuaternion::from_rotation_matrix(&axes);
    EngineMass::with_principal_inertia_frame(
        vector(body.center_of_mass_m),
        body.mass_kg,
        Vector::new(moments[(0, 0)], moments[(1, 1)], moments[(2, 2)]),
        Rotation::from_xyzw(frame.i, frame.j, frame.k, frame.w),
    )
}

/// Returns the largest difference between the engine's inertia and the given one, divided by the largest element.
fn inertia_difference(mass: &EngineMass, rotational_kg_m2: &DMat3) -> f64 {
    let held = DMat3::from_cols_array(&mass.reconstruct_inertia_matrix().to_cols_array());
    let largest = |m: &DMat3| m.to_cols_array().iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    largest(&(held - *rotational_kg_m2)) / largest(rotational_kg_m2)
}

#[cfg(test)]
mod tests;
