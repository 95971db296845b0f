//! Rows within the ranges of their joints, and within those that join two joints.

use std::ops::Range;

use sinew_rig::Mechanism;

use super::joint::turn_within;
use crate::feasibility::limits::Limits;

/// The most of a range that is left free at each end.
const MOST_ROOM: f64 = 0.02;

/// Where the joints may be, and what was done for it.
pub(super) struct Within {
    /// The numbers of each joint in a row, and its dofs.
    joints: Vec<[Range<usize>; 2]>,
    /// How far from the ends of its range each joint stays, rad or m.
    pub(super) room: Vec<f64>,
    /// The most that a joint was brought back, beyond its room.
    pub(super) clamped: Vec<f64>,
}

impl Within {
    pub(super) fn new(mechanism: &Mechanism, room: f64) -> Self {
        let mut first = 0;
        let joints: Vec<_> = mechanism
            .bodies
            .iter()
            .zip(mechanism.coordinate_ranges())
            .map(|(link, numbers)| {
                let dofs = first..first + link.joint.kind().dof_count();
                first = dofs.end;
                [numbers, dofs]
            })
            .collect();
        let count = joints.len();
        Self { joints, room: vec![room; count], clamped: vec![0.0; count] }
    }

    /// Stays farther from the ends, since a curve through the rows went beyond by so much.
    pub(super) fn widen(&mut self, joint: usize, beyond: f64) {
        self.room[joint] += 2.0 * beyond + 1e-6;
    }

    /// Brings a row within the limits.
    pub(super) fn bring(&mut self, limits: &Limits, row: &mut [f64]) {
        for (joint, [numbers, dofs]) in self.joints.iter().enumerate() {
            let of_joint = &mut row[numbers.clone()];
            let (mut change, mut room) = (0.0_f64, self.room[joint]);
            if let Some((_, most_rad)) = limits.turns.iter().find(|(body, _)| *body == joint) {
                room = room.min(MOST_ROOM * most_rad);
                change = turn_within(of_joint, most_rad - room);
            } else if of_joint.len() == dofs.len() {
                for (position, dof) in of_joint.iter_mut().zip(dofs.clone()) {
                    let [least, most] = limits.dofs[dof].range;
                    let own = room.min(MOST_ROOM * (most - least));
                    let kept = position.max(least + own).min(most - own);
                    // What is only the room at the ends is no news.
                    if (kept - *position).abs() > own + 1e-9 {
                        change = change.max((kept - *position).abs());
                    }
                    *position = kept;
                }
                room = 0.0;
            }
            if change > room + 1e-9 {
                self.clamped[joint] = self.clamped[joint].max(change);
            }
        }
        for linked in &limits.linked {
            let [own, other] = [linked.body, linked.other].map(|body| self.joints[body][0].start);
            let [least, most] = linked.range;
            let rest = linked.other_factor * row[other];
            let sum = linked.factor * row[own] + rest;
            // Equal ends tie them: there is no room.
            let room = self.room[linked.body] * linked.factor.abs();
            let room = room.min(MOST_ROOM * (most - least));
            let kept = sum.max(least + room).min(most - room);
            if (kept - sum).abs() > 1e-12 {
                let change = ((kept - sum) / linked.factor).abs();
                row[own] = (kept - rest) / linked.factor;
                // Ties are computed anew in every row: only limits tell news.
                if most > least && change > room + 1e-9 {
                    self.clamped[linked.body] = self.clamped[linked.body].max(change);
                }
            }
        }
    }
}
