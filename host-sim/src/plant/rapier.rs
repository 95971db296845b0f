//! The paper's kind of plant: a game engine in maximal coordinates, rapier, whose bodies are held together
//! by constraints.
//!
//! The engine's defaults are made for contacts and stacks, not for torques that cancel the dynamics of the
//! same instant: see [`EngineSettings`].

mod settings;

use ::nalgebra as na;
use glam::{DMat3, DQuat, DVec3};
use rapier3d_f64::prelude::{
    BroadPhaseBvh, CCDSolver, ColliderSet, ImpulseJointSet, IntegrationParameters, IslandManager,
    MassProperties as EngineMass, MultibodyJointSet, NarrowPhase, PhysicsPipeline, Pose,
    RigidBodyBuilder, RigidBodyHandle, RigidBodySet, RigidBodyType, Rotation, SoftBodySet,
    SphericalJointBuilder, Vector,
};

use super::{
    Drive, GRAVITY_M_S2, Mechanism, MovingPose, Plant, PlantBody, PlantError, Pose as BodyPose,
    Root,
};
use crate::figure::MassProperties;
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

/// A body as the engine has it.
struct Link {
    handle: RigidBodyHandle,
    parent: Option<usize>,
    /// About the centre of mass, body axes.
    rotational_kg_m2: DMat3,
}

impl RapierPlant {
    /// Builds the mechanism in the given state.
    ///
    /// `start` holds a state per body; the poses must fit the joints, else the first step snaps them. The
    /// engine holds the torques over all substeps in world axes.
    ///
    /// # Errors
    /// [`PlantError`] if this is no tree with a state for each body, a number is one that no machine has, or the
    /// engine does not hold a body's inertia as given.
    pub fn new(
        mechanism: &Mechanism,
        start: &[MovingPose],
        dt_s: f64,
        substeps: usize,
        settings: EngineSettings,
    ) -> Result<Self, PlantError> {
        mechanism.check(start, dt_s, substeps)?;
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
        if mechanism.root == Root::Fixed
            && let Some(root) = plant.links.first()
        {
            plant.bodies[root.handle].set_body_type(RigidBodyType::Fixed, true);
        }
        plant.read_poses();
        Ok(plant)
    }

    fn insert(
        &mut self,
        index: usize,
        body: &PlantBody,
        start: &MovingPose,
    ) -> Result<(), PlantError> {
        let mass = mass_properties(&body.mass);
        let relative = inertia_difference(&mass, &body.mass.rotational_kg_m2);
        if relative > 1e-12 {
            return Err(PlantError::Inertia { body: index, relative });
        }
        // The engine's velocity is that of the centre of mass.
        let arm = start.pose.rotation * body.mass.center_of_mass_m;
        let center_velocity = start.linear_m_s + start.angular_rad_s.cross(arm);
        let rigid_body = RigidBodyBuilder::dynamic()
            .pose(Pose::from_parts(vector(start.pose.position_m), rotation(start.pose.rotation)))
            .linvel(vector(center_velocity))
            .angvel(vector(start.angular_rad_s))
            .additional_mass_properties(mass)
            // A figure must not freeze at the turning point of a swing.
            .can_sleep(false)
            .allow_fast_rotation(self.settings.fast_rotation)
            .gyroscopic_forces_enabled(self.settings.gyroscopic_term == GyroscopicTerm::Engine)
            .build();
        let handle = self.bodies.insert(rigid_body);
        // Until the first step the engine has no mass and no centre of mass, but the first force acts before.
        self.bodies[handle].recompute_mass_properties_from_colliders(&self.colliders);
        if let Some(parent) = body.parent {
            let joint = SphericalJointBuilder::new()
                .local_anchor1(vector(body.offset_m))
                .local_anchor2(Vector::ZERO)
                .contacts_enabled(false);
            self.joints.insert(self.links[parent].handle, handle, joint, true);
        }
        self.links.push(Link {
            handle,
            parent: body.parent,
            rotational_kg_m2: body.mass.rotational_kg_m2,
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
            // Forces would add up from step to step.
            let body = &mut self.bodies[link.handle];
            body.reset_forces(true);
            body.reset_torques(true);
        }
        for (index, (link, torque_nm)) in self.links.iter().zip(&drive.torque_nm).enumerate() {
            let body = &mut self.bodies[link.handle];
            body.add_torque(vector(*torque_nm), true);
            if self.settings.gyroscopic_term == GyroscopicTerm::Plant {
                let spin = DVec3::from_array(body.angvel().to_array());
                let axes = DMat3::from_quat(self.poses[index].rotation);
                let momentum = axes * (link.rotational_kg_m2 * (axes.transpose() * spin));
                body.add_torque(vector(-spin.cross(momentum)), true);
            }
            if let Some(parent) = link.parent {
                let parent = self.links[parent].handle;
                self.bodies[parent].add_torque(vector(-*torque_nm), true);
            } else {
                let origin = body.translation();
                body.add_force_at_point(vector(drive.root_force_n), origin, true);
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

/// The engine has its own version of glam: arrays lead from one to the other.
fn vector(v: DVec3) -> Vector {
    Vector::from_array(v.to_array())
}

fn rotation(q: DQuat) -> Rotation {
    Rotation::from_xyzw(q.x, q.y, q.z, q.w)
}

/// Mass properties by an eigen-decomposition of our own: the engine's conversion of an inertia matrix is
/// wrong for tilted bodies whose smaller principal moments are equal.
fn mass_properties(body: &MassProperties) -> EngineMass {
    let matrix = na::Matrix3::from_fn(|row, column| body.rotational_kg_m2.col(column)[row]);
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

/// Largest difference between the engine's inertia and the given one, over the largest element.
fn inertia_difference(mass: &EngineMass, rotational_kg_m2: &DMat3) -> f64 {
    let held = DMat3::from_cols_array(&mass.reconstruct_inertia_matrix().to_cols_array());
    let largest = |m: &DMat3| m.to_cols_array().iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    largest(&(held - *rotational_kg_m2)) / largest(rotational_kg_m2)
}

#[cfg(test)]
mod tests;
