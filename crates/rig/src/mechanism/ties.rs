//! Joints that follow others: `q = factor · q_leader + offset`. A tie is not a limit: follower and leader are one
//! coordinate.

use super::{JointModel, LinkedRange, Mechanism};

/// Difference of the ends of a range, rad or m, below which the range ties its joints.
const TIED: f64 = 1e-9;

/// A joint that follows its leader; the leader follows no other joint. If one of the joints turns and the other
/// slides, the factor is in rad/m or m/rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tie {
    /// Index of the body that the follower moves.
    pub body: usize,
    /// Index of the body that the leader moves.
    pub leader: usize,
    /// Motion of the follower for a motion of the leader, not zero.
    pub factor: f64,
    /// Position of the follower with the leader at zero, rad or m.
    pub offset: f64,
    /// Coordinates of follower and leader in `q`.
    places: [usize; 2],
    /// Dofs of follower and leader in `qd`.
    dofs: [usize; 2],
}

/// All ties of a mechanism. Chains of ties lead to one leader.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Ties {
    list: Vec<Tie>,
    /// Limits on two joints that do not tie them, in terms of leaders.
    limits: Vec<LinkedRange>,
    /// Ranges of leaders, from limits on two joints that have the same leader.
    ranges: Vec<(usize, [f64; 2])>,
}

impl Mechanism {
    /// Returns the ties of the mechanism. If a joint has several ties, only the first is a tie. The others, and a tie
    /// that would close a circle, count as limits. O(ties²).
    pub fn ties(&self) -> Ties {
        let mut ties: Vec<Tie> = Vec::new();
        let mut limits: Vec<LinkedRange> = Vec::new();
        let places = self.coordinate_ranges();
        let dofs = self.first_dofs();
        for limit in &self.linked {
            let [least, most] = limit.range;
            let is_tie = least.is_finite() && most - least < TIED && limit.factor.abs() > 0.0;
            let is_new = !ties.iter().any(|tie| tie.body == limit.body);
            let tie = Tie {
                body: limit.body,
                leader: limit.other,
                factor: -limit.other_factor / limit.factor,
                offset: least / limit.factor,
                places: [limit.body, limit.other].map(|body| places[body].start),
                dofs: [limit.body, limit.other].map(|body| dofs[body]),
            };
            let is_circle = || chain(&ties, tie).leader == tie.body;
            let follows = tie.factor.is_finite() && tie.factor.abs() > 0.0;
            if is_tie && is_new && follows && tie.body != tie.leader && !is_circle() {
                ties.push(tie);
            } else {
                limits.push(*limit);
            }
        }
        let ties: Vec<Tie> = ties.iter().map(|tie| chain(&ties, *tie)).collect();
        let mut all = Ties { list: ties, limits: Vec::new(), ranges: Vec::new() };
        let slides = |body: usize| matches!(self.bodies[body].joint, JointModel::Prismatic(_));
        for limit in limits {
            all.add(limit, slides);
        }
        all
    }

    /// Returns the first dof of each body's joint.
    fn first_dofs(&self) -> Vec<usize> {
        let counts = self.bodies.iter().map(|link| link.joint.kind().dof_count());
        counts
            .scan(0, |next, count| {
                let first = *next;
                *next += count;
                Some(first)
            })
            .collect()
    }

    /// Narrows the range, the speed and the acceleration of each leader to values that its followers allow.
    pub(crate) fn narrow_leaders(&mut self) {
        let ties = self.ties();
        for tie in &ties.list {
            let own = &self.bodies[tie.body];
            let (range, factor) = (own.ranges.first().copied(), tie.factor.abs());
            let (speed, acceleration) = (own.speed / factor, own.acceleration / factor);
            let leader = &mut self.bodies[tie.leader];
            if let Some(range) = range {
                leader.narrow(tie.of_leader(range));
            }
            leader.speed = leader.speed.min(speed);
            leader.acceleration = leader.acceleration.min(acceleration);
        }
        for (leader, range) in &ties.ranges {
            self.bodies[*leader].narrow(*range);
        }
    }
}

impl super::Link {
    /// Narrows the range of a joint of one dof. A range that would be empty stays.
    fn narrow(&mut self, [least, most]: [f64; 2]) {
        if !matches!(self.joint, JointModel::Revolute(_) | JointModel::Prismatic(_)) {
            return;
        }
        let [low, high] =
            self.ranges.first().copied().unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        let range = [low.max(least), high.min(most)];
        if range[0] <= range[1] && range.iter().all(|end| end.is_finite()) {
            self.ranges = vec![range];
        }
    }
}

/// Returns a tie to the joint at the end of its chain. A chain that returns to its own joint ends there.
fn chain(ties: &[Tie], tie: Tie) -> Tie {
    let mut end = tie;
    for _ in 0..ties.len() {
        let Some(next) = ties.iter().find(|next| next.body == end.leader && end.leader != tie.body)
        else {
            break;
        };
        end = Tie {
            leader: next.leader,
            factor: end.factor * next.factor,
            offset: end.factor * next.offset + end.offset,
            places: [end.places[0], next.places[1]],
            dofs: [end.dofs[0], next.dofs[1]],
            ..end
        };
    }
    end
}

impl Tie {
    /// Returns the leader's range for a range of the follower.
    pub fn of_leader(&self, [least, most]: [f64; 2]) -> [f64; 2] {
        let [a, b] = [least, most].map(|end| self.leader_position(end));
        [a.min(b), a.max(b)]
    }

    /// Returns the leader's position for a position of the follower.
    pub fn leader_position(&self, position: f64) -> f64 {
        (position - self.offset) / self.factor
    }

    /// Returns the indices of follower and leader in `q`.
    pub fn places(&self) -> [usize; 2] {
        self.places
    }

    /// Returns the indices of follower and leader in `qd`.
    pub fn dofs(&self) -> [usize; 2] {
        self.dofs
    }
}

impl Ties {
    /// Returns the ties one by one.
    pub fn each(&self) -> std::slice::Iter<'_, Tie> {
        self.list.iter()
    }

    /// Returns the tie of the joint that moves a body, if it follows another joint.
    pub fn of(&self, body: usize) -> Option<&Tie> {
        self.list.iter().find(|tie| tie.body == body)
    }

    /// Returns the body of the joint that a body's joint follows; otherwise the body itself.
    pub fn leader_of(&self, body: usize) -> usize {
        self.of(body).map_or(body, |tie| tie.leader)
    }

    /// Returns the limits on two joints that do not tie them, in terms of joints that follow no other joint.
    pub fn limits(&self) -> &[LinkedRange] {
        &self.limits
    }

    /// Sets the positions of the followers in `q` from those of their leaders. O(ties).
    pub fn follow(&self, q: &mut [f64]) {
        for Tie { factor, offset, places: [own, leader], .. } in &self.list {
            q[*own] = factor * q[*leader] + offset;
        }
    }

    /// Sets the speeds or accelerations of the followers in `qd` from those of their leaders.
    pub fn follow_rates(&self, qd: &mut [f64]) {
        for Tie { factor, dofs: [own, leader], .. } in &self.list {
            qd[*own] = factor * qd[*leader];
        }
    }

    /// Adds a limit on two joints, rewritten as a limit on their leaders. The sum is in the unit of its first joint.
    /// `slides`: whether the joint of a body slides.
    fn add(&mut self, limit: LinkedRange, slides: impl Fn(usize) -> bool) {
        let of = |body: usize| {
            self.of(body).map_or((body, 1.0, 0.0), |t| (t.leader, t.factor, t.offset))
        };
        let [own, other] = [of(limit.body), of(limit.other)];
        let constant = limit.factor * own.2 + limit.other_factor * other.2;
        let unit = if slides(own.0) == slides(limit.body) { 1.0 } else { own.1.abs() };
        let range = limit.range.map(|end| (end - constant) / unit);
        let [factor, other_factor] =
            [limit.factor * own.1, limit.other_factor * other.1].map(|factor| factor / unit);
        if own.0 != other.0 {
            let (body, other) = (own.0, other.0);
            self.limits.push(LinkedRange { body, other, factor, other_factor, range });
            return;
        }
        let sum = factor + other_factor;
        // A limit that always or never holds says nothing of the leader.
        if sum.abs() > TIED {
            let [a, b] = range.map(|end| end / sum);
            self.ranges.push((own.0, [a.min(b), a.max(b)]));
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use proptest::prelude::*;

    use super::*;
    use crate::mechanism::Link;

    /// A row of hinges on a base, joined by these ties: follower, leader, factor, offset.
    fn tied(count: usize, ties: &[(usize, usize, f64, f64)]) -> Mechanism {
        let hinge = Link::on(Some(0), JointModel::Revolute(DVec3::X), DVec3::ZERO);
        let mut bodies = vec![Link::on(None, JointModel::Fixed, DVec3::ZERO)];
        bodies.resize(count + 1, hinge);
        let limit = |&(body, other, factor, offset): &(usize, usize, f64, f64)| LinkedRange {
            body,
            other,
            factor: 1.0,
            other_factor: -factor,
            range: [offset, offset],
        };
        Mechanism { bodies, linked: ties.iter().map(limit).collect() }
    }

    #[test]
    fn a_circle_of_ties_is_no_tie() {
        let mechanism = tied(3, &[(1, 2, 2.0, 0.0), (2, 3, 1.0, 0.1), (3, 1, 0.5, 0.0)]);
        let ties = mechanism.ties();
        assert_eq!(
            ties.each().map(|tie| (tie.body, tie.leader)).collect::<Vec<_>>(),
            [(1, 3), (2, 3)]
        );
        // The third one holds for every position of the leader, or for none.
        assert!(ties.limits().is_empty());
    }

    #[test]
    fn a_limit_of_a_follower_is_one_of_its_leader() {
        let mut mechanism = tied(3, &[(2, 1, -2.0, 0.5)]);
        let limit =
            LinkedRange { body: 2, other: 3, factor: 3.0, other_factor: 1.0, range: [0.0, 2.0] };
        mechanism.linked.push(limit);
        let expected =
            LinkedRange { body: 1, other: 3, factor: -6.0, other_factor: 1.0, range: [-1.5, 0.5] };
        assert_eq!(mechanism.ties().limits(), [expected]);
        // 2 q1 - 2 q1 + 0.5 is no limit; 5 (-2 q1 + 0.5) + 2 q1 from -1.5 to 2.5 is a range of q1.
        mechanism.linked.push(LinkedRange {
            body: 2,
            other: 1,
            factor: 5.0,
            other_factor: 2.0,
            range: [-1.5, 2.5],
        });
        mechanism.narrow_leaders();
        assert_eq!(mechanism.bodies[1].ranges, [[0.0, 0.5]]);
    }

    #[test]
    fn a_limit_of_a_slide_that_follows_a_hinge_is_in_the_hinges_unit() {
        let mut mechanism = tied(3, &[(2, 1, 0.02, 0.01)]);
        for body in [2, 3] {
            mechanism.bodies[body].joint = JointModel::Prismatic(DVec3::X);
        }
        let limit =
            LinkedRange { body: 2, other: 3, factor: 1.0, other_factor: -1.0, range: [0.0, 0.03] };
        mechanism.linked.push(limit);
        let ties = mechanism.ties();
        let [found] = ties.limits() else { panic!("one limit") };
        assert_eq!((found.body, found.other), (1, 3));
        // The sum 0.02 q1 + 0.01 - q3 from 0 to 0.03 m, converted to rad of q1.
        let numbers = [found.factor, found.other_factor, found.range[0], found.range[1]];
        for (found, expected) in numbers.into_iter().zip([1.0, -50.0, -0.5, 1.0]) {
            assert!((found - expected).abs() < 1e-9, "{numbers:?}");
        }
    }

    proptest! {
        /// Chains of ties in any order lead to one leader. Within its range, all followers are within theirs.
        #[test]
        fn random_chains_follow(
            factors in prop::collection::vec((0.4..2.0_f64, any::<bool>()), 4),
            offsets in prop::collection::vec(-0.1..0.1_f64, 4),
            ends in prop::collection::vec(0.5..2.0_f64, 5),
            order in Just([0, 1, 2, 3]).prop_shuffle(),
            at in -2.0..2.0_f64,
        ) {
            let factor = |k: usize| if factors[k].1 { -factors[k].0 } else { factors[k].0 };
            // Joint k + 2 follows joint k + 1.
            let all = [0, 1, 2, 3].map(|k| (k + 2, k + 1, factor(k), offsets[k]));
            let mut mechanism = tied(5, &order.map(|k| all[k]));
            for (body, end) in ends.iter().enumerate() {
                mechanism.bodies[body + 1].ranges = vec![[-5.0 * end, 5.0 * end]];
                mechanism.bodies[body + 1].speed = *end;
            }
            mechanism.narrow_leaders();
            let ties = mechanism.ties();
            let [least, most] = mechanism.bodies[1].ranges[0];
            let mut q = vec![at.max(least).min(most), 0.0, 0.0, 0.0, 0.0];
            ties.follow(&mut q);
            let mut qd = vec![mechanism.bodies[1].speed, 0.0, 0.0, 0.0, 0.0];
            ties.follow_rates(&mut qd);
            for k in 0..4 {
                prop_assert!((q[k + 1] - factor(k) * q[k] - offsets[k]).abs() < 1e-9);
                prop_assert!((qd[k + 1] - factor(k) * qd[k]).abs() < 1e-9);
                prop_assert!(ties.leader_of(k + 2) == 1);
            }
            for (k, end) in ends.iter().enumerate() {
                prop_assert!(q[k].abs() <= 5.0 * end + 1e-9, "{k}: {q:?}");
                prop_assert!(qd[k].abs() <= end + 1e-9, "{k}: {qd:?}");
            }
        }
    }
}
