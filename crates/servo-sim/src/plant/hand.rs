//! A hand that leads a joint.

use super::{RigPlant, STOP_N_M};
use crate::load::STOP_NM_RAD;
use sinew_rig::mechanism::JointModel;

/// Part of a stop's stiffness that a hand has.
const FIRM: f64 = 0.25;
/// Time that its damping is behind its stiffness, s: a hand does not swing.
const DAMPING_S: f64 = 0.02;

/// A hand on one joint: a spring and a damper to where it wants the joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hand {
    /// Where, rad or m.
    pub position: f64,
    /// How fast that moves, rad/s or m/s.
    pub velocity: f64,
}

/// A hand, and the joint that it holds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Holds {
    pub(super) dof: usize,
    coordinate: usize,
    stiffness: f64,
    hand: Hand,
}

impl Holds {
    /// What it pushes with, and how that falls with speed.
    pub(super) fn push(&self, dt_s: f64, q: &[f64], qd: &[f64]) -> (f64, f64) {
        let (at, speed) = (q[self.coordinate], qd[self.dof]);
        let damping = self.stiffness * DAMPING_S;
        let slope = damping + self.stiffness * dt_s;
        let Hand { position, velocity } = self.hand;
        (self.stiffness * (position - at) + damping * velocity - slope * speed, slope)
    }
}

impl RigPlant {
    /// A hand takes a joint's dof, or leads it on; none lets go. Hands do not take ball joints: then nothing
    /// happens, and it says so.
    pub fn lead(&mut self, dof: usize, hand: Option<Hand>) -> bool {
        self.hands.retain(|holds| holds.dof != dof);
        let bodies = &self.mechanics.mechanism.bodies;
        let body = (0..bodies.len()).find(|at| self.mechanics.dofs_of(*at).contains(&dof));
        let Some(body) = body else { return false };
        let stiffness = match bodies[body].joint {
            JointModel::Spherical | JointModel::Free | JointModel::Fixed => return false,
            JointModel::Prismatic(_) => FIRM * STOP_N_M,
            _ => FIRM * STOP_NM_RAD,
        };
        let [first, coordinate] = self.mechanics.places[body];
        let coordinate = coordinate + dof - first;
        self.hands.extend(hand.map(|hand| Holds { dof, coordinate, stiffness, hand }));
        true
    }
}
