//! Review of a rig: its loads, speeds, inertias, stable gains, resolution and current, with findings on doubtful
//! values.
//!
//! Collisions are out of scope.

mod finding;
mod flexible_joint;
mod gain;
mod gravity;
mod inertia;
mod loops;
mod reach;
mod results;
mod servos;
#[cfg(test)]
mod tests;

use sinew_core::coordinates::CoordinatesError;
use sinew_core::dynamics::{OuterJoints, ReflectedInertia, reflected_inertia};
use sinew_core::{JointStates, TreeError};

use crate::mechanism::{BODY_COUNT_MAX, JointModel, Link, Mechanism};
use crate::number::single;

pub use finding::{KG_M2_PER_G_MM2, shown};
pub use flexible_joint::{ControlLoop, FlexibleJoint, Margins, Stability};
pub use gain::largest_stable_angle;
pub use gravity::{WorstLoad, holding_effort, worst_load};
pub(crate) use inertia::ranges as inertia_ranges;
pub(crate) use loops::with_worst_gear;
pub use reach::reach_m;
pub use results::{
    Capability, CurrentReview, DofReview, Finding, Loop, LoopReview, Review, Servos, Severity,
    SoftGear, Voltage,
};

impl Review {
    /// Reviews a rig. O(n³): for interactive use on a desktop, not on a board.
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
                    control: None,
                    stable_stiffness: inertia_free * omega * omega,
                    reach_m,
                    resolution_mm: servo.as_ref().map(|servo| {
                        servo.resolution * 1000.0 * if slides { 1.0 } else { reach_m }
                    }),
                    servo,
                });
            }
        }
        loops::review(&mut by_dof, &inertia::ranges(mechanism, &tree)?, control);
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

/// The reason why a rig was not reviewed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ReviewError {
    /// The bodies are not a valid tree of `sinew-core`.
    #[error(transparent)]
    Tree(#[from] TreeError),
    /// The home pose is invalid for that tree.
    #[error("home pose: {0}")]
    Home(#[from] CoordinatesError),
}

fn holding_current_a(dof: &DofReview) -> Option<f64> {
    // A servo takes at most its stall current.
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

/// Returns the inertia along one dof, in the home pose.
fn along(inertia: &ReflectedInertia, link: &Link, axis: usize) -> f64 {
    along_at(inertia, link, axis, &link.home)
}

/// Returns the inertia along one dof, at joint coordinates `q`.
fn along_at(inertia: &ReflectedInertia, link: &Link, axis: usize, q: &[f64]) -> f64 {
    if slides(link, axis) {
        return f64::from(inertia.linear_kg);
    }
    let (turns, _) = link.joint.axes(q);
    turns.get(axis).map_or(0.0, |turn| {
        let turn = turn.as_vec3();
        f64::from(turn.dot(inertia.angular_kg_m2.mul_vec3(turn)))
    })
}
