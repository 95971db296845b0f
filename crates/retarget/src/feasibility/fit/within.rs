//! Limits rows to the ranges of their joints, and to limits that join two joints.

use std::ops::Range;

use sinew_rig::Mechanism;

use super::joint::turn_within;
use crate::feasibility::limits::Limits;

/// Maximum margin at each end, as a share of the range.
const MOST_ROOM: f64 = 0.02;

/// Ranges of the joints, and the changes made for them.
pub(super) struct Within {
    /// Ranges of each joint's coordinates in a row, and of its dofs.
    joints: Vec<[Range<usize>; 2]>,
    /// Margin of each joint to the ends of its range, rad or m.
    pub(super) room: Vec<f64>,
    /// Largest change of each joint beyond its margin, rad or m.
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

    /// Increases the margin, because a curve through the rows exceeded the range by `beyond`.
    pub(super) fn widen(&mut self, joint: usize, beyond: f64) {
        self.room[joint] += 2.0 * beyond + 1e-6;
    }

    /// Returns the range of a joint's dof, reduced by the joint's margin at both ends.
    pub(super) fn inner(&self, joint: usize, [least, most]: [f64; 2]) -> [f64; 2] {
        let own = self.room[joint].min(MOST_ROOM * (most - least));
        [least + own, most - own]
    }

    /// Limits a row to all ranges.
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
                    // A change within the margin is not recorded.
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
            // Equal ends leave no margin.
            let room = self.room[linked.body] * linked.factor.abs();
            let room = room.min(MOST_ROOM * (most - least));
            let kept = sum.max(least + room).min(most - room);
            if (kept - sum).abs() > 1e-12 {
                let change = ((kept - sum) / linked.factor).abs();
                row[own] = (kept - rest) / linked.factor;
                // Equal ends are restored in every row, therefore only changes by others are recorded.
                if most > least && change > room + 1e-9 {
                    self.clamped[linked.body] = self.clamped[linked.body].max(change);
                }
            }
        }
        limits.ties.follow(row);
    }
}
