//! Dynamics in f64, derived only from poses.
//!
//! The joints' coordinates move along a path in time, the poses of all bodies are multiplied together, and everything
//! else (velocities, accelerations, momenta, energies) is a numerical derivative of those poses. No formula for a
//! relative velocity, a Coriolis term or a recursion of forces is used, so an error in the core's formulas cannot be
//! repeated here.

use glam::{DMat3, DQuat, DVec3};
use sinew_core::{Body, JointKind, Wrench};

use crate::rig::{Coordinates, Rig};

/// Step of the derivatives, s. With four neighbours the error is about `(ω h)⁴` of the result, 1e-8 at 10 rad/s;
/// rounding is `1e-16 / h²`, 1e-10.
const STEP_S: f64 = 1e-3;

/// Pose of a body in the world.
#[derive(Debug, Clone, Copy)]
pub struct Pose {
    /// Rotation from body axes to world axes.
    pub rotation: DQuat,
    /// Position of the origin, m.
    pub position_m: DVec3,
}

/// Motion of a body's centre of mass at one instant, in world axes.
#[derive(Debug, Clone, Copy)]
struct CenterMotion {
    /// Position of the centre of mass, m.
    position_m: DVec3,
    velocity_m_s: DVec3,
    acceleration_m_s2: DVec3,
    omega_rad_s: DVec3,
    alpha_rad_s2: DVec3,
    /// Inertia about the centre of mass.
    inertia_kg_m2: DMat3,
    mass_kg: f64,
}

/// Wrench on a body in world axes; the moment is about the body's origin.
#[derive(Debug, Clone, Copy)]
pub struct WorldWrench {
    /// Moment, N m.
    pub moment_nm: DVec3,
    /// Force, N.
    pub force_n: DVec3,
}

/// Returns the poses of all bodies at `time_s` from now, with constant accelerations of their coordinates.
pub fn poses(rig: &Rig, time_s: f64) -> Vec<Pose> {
    let mut poses: Vec<Pose> = Vec::new();
    for (body, motion) in rig.tree.bodies().iter().zip(&rig.motions) {
        let joint = joint_pose(body, motion, time_s);
        let parent = body.parent.map_or(Pose::WORLD, |parent| poses[parent]);
        poses.push(parent.times(&joint));
    }
    poses
}

impl Pose {
    /// The world's own frame.
    pub const WORLD: Self = Self { rotation: DQuat::IDENTITY, position_m: DVec3::ZERO };

    /// Returns the pose in the world of a frame with the pose `inner` relative to this one.
    #[must_use]
    pub fn times(&self, inner: &Self) -> Self {
        Self {
            rotation: (self.rotation * inner.rotation).normalize(),
            position_m: self.position_m + self.rotation * inner.position_m,
        }
    }
}

fn joint_pose(body: &Body, motion: &Coordinates, time_s: f64) -> Pose {
    let placement = Pose {
        rotation: body.placement.rotation.as_dquat().normalize(),
        position_m: body.placement.translation_m.as_dvec3(),
    };
    let way = |k: usize| {
        f64::from(motion.speed[k]) * time_s
            + 0.5 * f64::from(motion.acceleration[k]) * time_s * time_s
    };
    let along = |k: usize| f64::from(motion.along[k]) + way(k);
    let ways = |first: usize| DVec3::new(way(first), way(first + 1), way(first + 2));
    let about = |axis: DVec3, angle: f64| DQuat::from_scaled_axis(axis.normalize() * angle);
    // The turn from the start is in body axes: its derivative there equals the components of the angular velocity.
    let rotation = motion.rotation.as_dquat().normalize();
    let turned = || rotation * DQuat::from_scaled_axis(ways(0));
    let (rotation, position_m) = match body.joint {
        JointKind::Fixed => (DQuat::IDENTITY, DVec3::ZERO),
        JointKind::Revolute { axis } => (about(axis.as_dvec3(), along(0)), DVec3::ZERO),
        JointKind::Prismatic { axis } => (DQuat::IDENTITY, axis.as_dvec3().normalize() * along(0)),
        JointKind::Universal { first, second } => {
            (about(first.as_dvec3(), along(0)) * about(second.as_dvec3(), along(1)), DVec3::ZERO)
        }
        JointKind::Spherical => (turned(), DVec3::ZERO),
        // The speeds are in the present body axes.
        JointKind::Free => (turned(), motion.position_m.as_dvec3() + rotation * ways(3)),
    };
    placement.times(&Pose { rotation, position_m })
}

/// Returns first and second derivative at the middle of five samples, with fourth order.
fn derivatives(samples: [DVec3; 5]) -> (DVec3, DVec3) {
    let [a, b, c, d, e] = samples;
    let first = (a - b * 8.0 + d * 8.0 - e) / (12.0 * STEP_S);
    let second = (-a + b * 16.0 - c * 30.0 + d * 16.0 - e) / (12.0 * STEP_S * STEP_S);
    (first, second)
}

/// Returns the motion of every body's centre of mass at `time_s`.
fn motions(rig: &Rig, time_s: f64) -> Vec<CenterMotion> {
    let at = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|k| poses(rig, time_s + k * STEP_S));
    let of_body = |(index, body): (usize, &Body)| {
        let inertia = &body.inertia;
        let center = inertia.center_of_mass_m.as_dvec3();
        let positions = [0, 1, 2, 3, 4].map(|k: usize| {
            let pose = &at[k][index];
            pose.position_m + pose.rotation * center
        });
        let now = at[2][index].rotation;
        let turns = [0, 1, 2, 3, 4].map(|k: usize| turn(now, at[k][index].rotation));
        let (velocity_m_s, acceleration_m_s2) = derivatives(positions);
        let (omega_rad_s, alpha_rad_s2) = derivatives(turns);
        let i = &inertia.rotational_kg_m2;
        let in_body = DMat3::from_cols_array(
            &[i.xx, i.xy, i.xz, i.xy, i.yy, i.yz, i.xz, i.yz, i.zz].map(f64::from),
        );
        let axes = DMat3::from_quat(now);
        CenterMotion {
            position_m: positions[2],
            velocity_m_s,
            acceleration_m_s2,
            omega_rad_s,
            alpha_rad_s2,
            inertia_kg_m2: axes * in_body * axes.transpose(),
            mass_kg: f64::from(inertia.mass_kg),
        }
    };
    rig.tree.bodies().iter().enumerate().map(of_body).collect()
}

/// Returns the wrench that each joint passes to its body: the sum over all bodies beyond it, by Newton's and Euler's
/// laws, minus gravity, about the joint.
pub fn joint_wrenches(rig: &Rig, gravity_m_s2: DVec3) -> Vec<WorldWrench> {
    let (poses, motions) = (poses(rig, 0.0), motions(rig, 0.0));
    let of_joint = |joint: usize| {
        let origin = poses[joint].position_m;
        let zero = WorldWrench { moment_nm: DVec3::ZERO, force_n: DVec3::ZERO };
        rig.tree.subtree(joint).iter().fold(zero, |sum, body| {
            let m = &motions[body];
            let force = (m.acceleration_m_s2 - gravity_m_s2) * m.mass_kg;
            let spin = m.inertia_kg_m2 * m.omega_rad_s;
            let moment = m.inertia_kg_m2 * m.alpha_rad_s2 + m.omega_rad_s.cross(spin);
            WorldWrench {
                moment_nm: sum.moment_nm + moment + (m.position_m - origin).cross(force),
                force_n: sum.force_n + force,
            }
        })
    };
    (0..rig.tree.len()).map(of_joint).collect()
}

/// Returns kinetic and potential energy, J, including that of the drives' rotors.
pub fn energy_j(rig: &Rig, gravity_m_s2: DVec3, time_s: f64) -> f64 {
    let of_body = |m: &CenterMotion| {
        let turning = m.omega_rad_s.dot(m.inertia_kg_m2 * m.omega_rad_s);
        0.5 * (m.mass_kg * m.velocity_m_s.length_squared() + turning)
            - m.mass_kg * gravity_m_s2.dot(m.position_m)
    };
    let of_bodies: f64 = motions(rig, time_s).iter().map(of_body).sum();
    of_bodies + rotor_energy_j(rig, time_s)
}

/// Returns the energy of the rotors. A rotor turns at the speed of its joint's coordinate, independent of the bodies'
/// motion. (For a ball joint the derivative of the rotation vector equals the angular velocity to first order in
/// time, which is enough for a rate.)
fn rotor_energy_j(rig: &Rig, time_s: f64) -> f64 {
    let of_joint = |(body, motion): (&Body, &Coordinates)| {
        let speeds = motion.speed.iter().zip(&motion.acceleration);
        let speeds = speeds.take(body.joint.dof_count());
        let squared = speeds.map(|(v, a)| (f64::from(*v) + f64::from(*a) * time_s).powi(2));
        0.5 * f64::from(body.rotor_inertia) * squared.sum::<f64>()
    };
    rig.tree.bodies().iter().zip(&rig.motions).map(of_joint).sum()
}

/// Returns linear momentum, kg m/s, and angular momentum about the world's origin, kg m²/s.
fn momentum(rig: &Rig, time_s: f64) -> [DVec3; 2] {
    motions(rig, time_s).iter().fold([DVec3::ZERO; 2], |[linear, angular], m| {
        let of_body = m.velocity_m_s * m.mass_kg;
        let spin = m.inertia_kg_m2 * m.omega_rad_s;
        [linear + of_body, angular + m.position_m.cross(of_body) + spin]
    })
}

/// Returns the rate of the energy, W.
pub fn power_w(rig: &Rig, gravity_m_s2: DVec3) -> f64 {
    let at = |k: f64| DVec3::X * energy_j(rig, gravity_m_s2, k * STEP_S);
    derivatives([-2.0, -1.0, 0.0, 1.0, 2.0].map(at)).0.x
}

/// Returns the rates of linear and angular momentum, N and N m.
pub fn momentum_rate(rig: &Rig) -> [DVec3; 2] {
    let at = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|k| momentum(rig, k * STEP_S));
    [0, 1].map(|part| derivatives(at.map(|momentum| momentum[part])).0)
}

/// Returns the weight of all bodies, N, and its moment about the world's origin, N m.
pub fn weight(rig: &Rig, gravity_m_s2: DVec3) -> [DVec3; 2] {
    motions(rig, 0.0).iter().fold([DVec3::ZERO; 2], |[force, moment], m| {
        let of_body = gravity_m_s2 * m.mass_kg;
        [force + of_body, moment + m.position_m.cross(of_body)]
    })
}

/// Converts the core's wrench of a joint to world axes.
pub fn in_world(wrench: &Wrench, pose: &Pose) -> WorldWrench {
    WorldWrench {
        moment_nm: pose.rotation * wrench.moment_nm.as_dvec3(),
        force_n: pose.rotation * wrench.force_n.as_dvec3(),
    }
}

/// Returns the world accelerations of every body: angular in rad/s², and of its origin in m/s².
pub fn accelerations(rig: &Rig) -> Vec<[DVec3; 2]> {
    let at = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|k| poses(rig, k * STEP_S));
    (0..rig.tree.len())
        .map(|body| {
            let now = at[2][body].rotation;
            let turns = [0, 1, 2, 3, 4].map(|k: usize| turn(now, at[k][body].rotation));
            let positions = [0, 1, 2, 3, 4].map(|k: usize| at[k][body].position_m);
            [derivatives(turns).1, derivatives(positions).1]
        })
        .collect()
}

/// Returns the rotation vector from one orientation to another, in world axes. Its derivatives at zero are ω and α.
pub fn turn(from: DQuat, to: DQuat) -> DVec3 {
    let turn = to * from.inverse();
    if turn.w < 0.0 { -turn } else { turn }.to_scaled_axis()
}
