//! What a rig's numbers come to: loads, speeds, inertias, stable gains, resolution, current; and what of it is
//! doubtful.
//!
//! Collisions are out of scope.

mod finding;
mod gain;
mod gravity;
mod reach;
mod servos;
#[cfg(test)]
mod tests;

use serde::Serialize;
use sinew_core::coordinates::CoordinatesError;
use sinew_core::dynamics::{OuterJoints, ReflectedInertia, reflected_inertia};
use sinew_core::{JointStates, TreeError};

use crate::mechanism::{BODY_COUNT_MAX, JointModel, Link, Mechanism};
use crate::number::single;

pub use finding::{Finding, KG_M2_PER_G_MM2, Severity};
pub use gain::largest_stable_angle;
pub use gravity::{WorstLoad, holding_effort, worst_load};
pub use reach::reach_m;

/// The control loop that gains are judged for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Loop {
    /// Ticks a second.
    pub rate_hz: f64,
    /// Ticks that a torque acts late.
    pub latency_ticks: usize,
}

/// What the servos of one dof can do there, through their drive.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Capability {
    /// Names of the servos.
    pub servos: Vec<String>,
    /// Effort for long, N m or N.
    pub continuous: f64,
    /// Effort at standstill, N m or N.
    pub stall: f64,
    /// Speed without load, rad/s or m/s.
    pub no_load_speed: f64,
    /// Least step, rad or m.
    pub resolution: f64,
    /// Current of all of them for an effort, A per N m or A per N.
    pub current_per_effort: f64,
    /// Whether a value is a guess of the servo's data.
    pub guessed: bool,
}

/// One dof of one joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DofReview {
    /// Name of the dof, see [`Mechanism::dof_names`].
    pub name: String,
    /// Whether it slides: forces in N and ways in m, else torques in N m and angles in rad.
    pub slides: bool,
    /// What gravity asks for in the worst pose found, N m or N.
    pub gravity_effort: f64,
    /// That pose: joint coordinates by the rig's order.
    pub gravity_pose: Vec<f64>,
    /// The file's own limit, N m or N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effort_limit: Option<f64>,
    /// What its servos can do, if it has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub servo: Option<Capability>,
    /// The file's own limit of speed, rad/s or m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_limit: Option<f64>,
    /// Inertia against the drive in the home pose with all joints beyond held: kg m² or kg, the rotor's included.
    pub inertia: f64,
    /// The same with all joints beyond free to give way: what a torque meets first.
    pub inertia_free: f64,
    /// The rotor's part.
    pub rotor_inertia: f64,
    /// The largest stable stiffness of a critically damped loop, N m/rad or N/m.
    pub stable_stiffness: f64,
    /// The farthest that a point beyond the joint can be from it, m; an upper bound.
    pub reach_m: f64,
    /// What the servo's least step is at that distance, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resolution_mm: Option<f64>,
}

/// Current of all servos together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CurrentReview {
    /// Where every joint holds its own worst pose, A: more than any one pose takes.
    pub holding_a: f64,
    /// Where all servos stall, A.
    pub stall_a: f64,
    /// What the supply gives, A.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub supply_a: Option<f64>,
}

/// All of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Review {
    /// Mass of the whole rig, kg.
    pub mass_kg: f64,
    /// Number of bodies, fixed joints merged; the base is one.
    pub bodies: usize,
    /// Number of degrees of freedom.
    #[serde(rename = "freedoms")]
    pub dofs: usize,
    /// The loop that stiffness is judged for.
    pub control: Loop,
    /// Largest stable gain of a critically damped loop, 1/s²: stiffness over inertia.
    pub stable_kp_per_s2: f64,
    /// By dof, in the order of efforts.
    #[serde(rename = "by_freedom")]
    pub by_dof: Vec<DofReview>,
    /// If servos are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub current: Option<CurrentReview>,
    /// What feeds each kind of servo; empty if the supply is not known.
    pub voltages: Vec<Voltage>,
    /// What is wrong or doubtful, the worst first.
    pub findings: Vec<Finding>,
}

/// What feeds the servos of one kind.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Voltage {
    /// Names of the servos.
    pub servos: Vec<String>,
    /// Their kind.
    pub model: String,
    /// What the supply gives, V.
    pub supply_v: f64,
    /// What the kind's values are for, V.
    pub model_v: f64,
}

/// What is known of the servos.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Servos {
    /// By dof; `None` where no servo moves it.
    pub by_dof: Vec<Option<Capability>>,
    /// Where all stall, A.
    pub stall_current_a: f64,
    /// What the supply gives, A.
    pub supply_a: Option<f64>,
    /// What feeds each kind; empty if the supply is not known.
    pub voltages: Vec<Voltage>,
}

impl Review {
    /// Reviews a rig. O(n³), for one sitting at a desk.
    ///
    /// # Errors
    /// [`ReviewError`] if the rig does not fit `sinew-core`.
    pub fn of(mechanism: &Mechanism, servos: &Servos, control: Loop) -> Result<Self, ReviewError> {
        let tree = mechanism.tree::<BODY_COUNT_MAX>()?;
        let home: Vec<f32> = mechanism.home().into_iter().map(single).collect();
        let mut pose = JointStates::rest(&tree);
        let still = vec![0.0; tree.dof_count()];
        pose.set_coordinates(&tree, &home, &still)?;
        let [locked, free] = [OuterJoints::Locked, OuterJoints::Free]
            .map(|outer| reflected_inertia(&tree, &pose, outer));
        let omega = largest_stable_angle(control.latency_ticks) * control.rate_hz;
        let mut names = mechanism.dof_names().into_iter();
        let mut capabilities = servos.by_dof.iter().cloned();
        let mut by_dof = Vec::new();
        for (joint, link) in mechanism.bodies.iter().enumerate() {
            let [locked, free] =
                [&locked, &free].map(|all| all.get(joint).copied().unwrap_or_default());
            for axis in 0..link.joint.kind().dof_count() {
                let servo = capabilities.next().flatten();
                let worst = worst_load(mechanism, joint, axis);
                let inertia_free = along(&free, link, axis);
                let reach_m = reach_m(mechanism, joint);
                let slides = slides(link, axis);
                by_dof.push(DofReview {
                    name: names.next().unwrap_or_default(),
                    slides,
                    gravity_effort: worst.effort,
                    gravity_pose: worst.q,
                    effort_limit: finite(link.effort),
                    speed_limit: finite(link.speed),
                    inertia: along(&locked, link, axis),
                    inertia_free,
                    rotor_inertia: link.rotor_inertia,
                    stable_stiffness: inertia_free * omega * omega,
                    reach_m,
                    resolution_mm: servo.as_ref().map(|servo| {
                        servo.resolution * 1000.0 * if slides { 1.0 } else { reach_m }
                    }),
                    servo,
                });
            }
        }
        let known = by_dof.iter().any(|dof| dof.servo.is_some());
        let current = known.then(|| CurrentReview {
            holding_a: by_dof.iter().filter_map(holding_current_a).sum(),
            stall_a: servos.stall_current_a,
            supply_a: servos.supply_a,
        });
        let voltages = servos.voltages.clone();
        let mut review = Self {
            mass_kg: mechanism.bodies.iter().map(|link| link.mass_kg).sum(),
            bodies: mechanism.bodies.len(),
            dofs: by_dof.len(),
            control,
            stable_kp_per_s2: omega * omega,
            by_dof,
            current,
            voltages,
            findings: Vec::new(),
        };
        review.findings = finding::findings(mechanism, &review);
        Ok(review)
    }
}

/// Why a rig was not reviewed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ReviewError {
    /// Its bodies are no tree of `sinew-core`.
    #[error(transparent)]
    Tree(#[from] TreeError),
    /// Its home pose is not one of that tree.
    #[error("home pose: {0}")]
    Home(#[from] CoordinatesError),
}

fn holding_current_a(dof: &DofReview) -> Option<f64> {
    // No servo takes more than what it stalls with.
    let held = |stall: f64| dof.gravity_effort.min(stall);
    dof.servo.as_ref().map(|servo| servo.current_per_effort * held(servo.stall))
}

fn finite(limit: f64) -> Option<f64> {
    limit.is_finite().then_some(limit)
}

fn slides(link: &Link, axis: usize) -> bool {
    match link.joint {
        JointModel::Prismatic(_) => true,
        JointModel::Free => axis >= 3,
        _ => false,
    }
}

/// Inertia along one dof, in the home pose.
fn along(inertia: &ReflectedInertia, link: &Link, axis: usize) -> f64 {
    if slides(link, axis) {
        return f64::from(inertia.linear_kg);
    }
    let (turns, _) = link.joint.axes(&link.home);
    turns.get(axis).map_or(0.0, |turn| {
        let turn = turn.as_vec3();
        f64::from(turn.dot(inertia.angular_kg_m2.mul_vec3(turn)))
    })
}
