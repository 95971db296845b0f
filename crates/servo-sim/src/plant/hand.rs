//! A hand that guides a joint.

use super::mechanics::Mechanics;
use crate::load::{STOP_N_M, STOP_NM_RAD};
use sinew_rig::mechanism::JointModel;

/// Stiffness of a hand, as a part of a stop's stiffness.
const FIRM: f64 = 0.25;
/// Ratio of a hand's damping to its stiffness, s: a hand does not swing.
const DAMPING_S: f64 = 0.02;

/// A hand on one joint: a spring and a damper to the position that it wants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hand {
    /// Wanted position, rad or m.
    pub position: f64,
    /// Speed of the wanted position, rad/s or m/s.
    pub velocity: f64,
}

/// The grip of a hand on one dof of a joint.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grip {
    pub(super) dof: usize,
    coordinate: usize,
    stiffness: f64,
}

/// A hand with its grip.
#[derive(Debug, Clone, Copy)]
pub(super) struct Holds {
    pub(super) grip: Grip,
    pub(super) hand: Hand,
}

impl Grip {
    /// Returns the grip on a dof. Returns `None` for a ball joint or the free base, which hands cannot guide, and if
    /// there is no such dof.
    pub(super) fn new(mechanics: &Mechanics, dof: usize) -> Option<Self> {
        let bodies = &mechanics.mechanism.bodies;
        let body = (0..bodies.len()).find(|at| mechanics.dofs_of(*at).contains(&dof))?;
        let stiffness = match bodies[body].joint {
            JointModel::Spherical | JointModel::Free | JointModel::Fixed => return None,
            JointModel::Prismatic(_) => FIRM * STOP_N_M,
            _ => FIRM * STOP_NM_RAD,
        };
        let [first, coordinate] = mechanics.places[body];
        Some(Self { dof, coordinate: coordinate + dof - first, stiffness })
    }
}

impl Holds {
    /// Returns the force of the hand, and the decrease of the force per unit of speed.
    pub(super) fn push(&self, dt_s: f64, q: &[f64], qd: &[f64]) -> (f64, f64) {
        let Grip { dof, coordinate, stiffness } = self.grip;
        let (at, speed) = (q[coordinate], qd[dof]);
        let damping = stiffness * DAMPING_S;
        let slope = damping + stiffness * dt_s;
        let Hand { position, velocity } = self.hand;
        (stiffness * (position - at) + damping * velocity - slope * speed, slope)
    }
}
