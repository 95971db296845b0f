//! Limits that link two joints. A tied joint follows the other joint; a range is divided among its joints.

use sinew_rig::mechanism::Mechanism;

use super::axis::Axis;
use super::profile::Profile;

/// The axis of a joint that is tied to another joint. Its position is `factor · leader + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Follower {
    body: usize,
    leader: usize,
    factor: f64,
    offset: f64,
}

/// Narrows the ranges of the axes so that no independent motion of the axes exceeds a limit that links two of them.
/// Returns the tied axes, which do not move independently; [`follow`] sets their motion.
pub(super) fn tie(mechanism: &Mechanism, axes: &mut [Vec<Axis>]) -> Vec<Follower> {
    let mut followers: Vec<Follower> = Vec::new();
    for one in &mechanism.linked {
        let [least, most] = one.range;
        let tied = least.to_bits() == most.to_bits();
        let follows = |body: usize| followers.iter().any(|other| other.body == body);
        // Each joint of the pair may follow the other. The second possibility is used if the first joint already
        // follows a third joint, or has the factor 0.
        let ends = [
            (one.body, one.factor, one.other, one.other_factor),
            (one.other, one.other_factor, one.body, one.factor),
        ];
        let free = ends.into_iter().find(|(body, factor, ..)| *factor != 0.0 && !follows(*body));
        if tied && let Some((body, factor, leader, of_leader)) = free {
            let one = Follower { body, leader, factor: -of_leader / factor, offset: most / factor };
            followers.push(one);
        }
    }
    let followers: Vec<Follower> = followers
        .iter()
        .filter_map(|one| {
            // Follow the chain to its end. A cyclic chain has no end.
            let mut end = *one;
            for _ in 0..followers.len() {
                let Some(next) = followers.iter().find(|other| other.body == end.leader) else {
                    return Some(end);
                };
                let (factor, offset) =
                    (end.factor * next.factor, end.factor * next.offset + end.offset);
                end = Follower { leader: next.leader, factor, offset, ..end };
            }
            None
        })
        .collect();
    for one in &followers {
        let [Some(own), Some(leader)] = [one.body, one.leader]
            .map(|body| axes.get(body).and_then(|axes| axes.first().copied()))
        else {
            continue;
        };
        let [a, b] = [own.least, own.most].map(|end| (end - one.offset) / one.factor);
        let led = Axis {
            speed: leader.speed.min(own.speed / one.factor.abs()),
            acceleration: leader.acceleration.min(own.acceleration / one.factor.abs()),
            ..leader
        };
        put(axes, one.leader, led.within(a.min(b), a.max(b)));
        put(axes, one.body, own.within(own.home, own.home));
    }
    for one in &mechanism.linked {
        let mut terms: Vec<(usize, f64)> = Vec::new();
        let mut offset = 0.0;
        for (body, factor) in [(one.body, one.factor), (one.other, one.other_factor)] {
            let follower = followers.iter().find(|other| other.body == body);
            let (body, of_leader) =
                follower.map_or((body, 1.0), |other| (other.leader, other.factor));
            offset += factor * follower.map_or(0.0, |other| other.offset);
            let factor = factor * of_leader;
            match terms.iter_mut().find(|(other, _)| *other == body) {
                Some((_, sum)) => *sum += factor,
                None => terms.push((body, factor)),
            }
        }
        share_out(axes, &terms, one.range.map(|end| end - offset));
    }
    followers
}

/// Divides the room that the limit leaves on both sides of home equally among the axes of the sum.
fn share_out(axes: &mut [Vec<Axis>], terms: &[(usize, f64)], [least, most]: [f64; 2]) {
    let of =
        |axes: &[Vec<Axis>], body: usize| axes.get(body).and_then(|axes| axes.first().copied());
    let home: f64 =
        terms.iter().filter_map(|(body, factor)| Some(factor * of(axes, *body)?.home)).sum();
    let parts = terms.len() as f64;
    for (body, factor) in terms {
        // This axis has cancelled in the sum, so the limit does not narrow it.
        if factor.abs() < 1e-9 {
            continue;
        }
        let Some(axis) = of(axes, *body) else { continue };
        let [a, b] = [(least - home).min(0.0), (most - home).max(0.0)]
            .map(|room| axis.home + room / parts / factor);
        put(axes, *body, axis.within(a.min(b), a.max(b)));
    }
}

fn put(axes: &mut [Vec<Axis>], body: usize, axis: Axis) {
    if let Some(slot) = axes.get_mut(body).and_then(|axes| axes.first_mut()) {
        *slot = axis;
    }
}

/// Gives tied axes the profile of their leaders.
pub(super) fn follow(followers: &[Follower], profiles: &mut [Vec<Profile>]) {
    for one in followers {
        let Some(leader) = profiles.get(one.leader).and_then(|profiles| profiles.first()).cloned()
        else {
            continue;
        };
        let at = |position: f64| one.factor * position + one.offset;
        let mut own = leader;
        own.home = at(own.home);
        for step in &mut own.moves {
            step.to = at(step.to);
        }
        if let Some(slot) = profiles.get_mut(one.body).and_then(|profiles| profiles.first_mut()) {
            *slot = own;
        }
    }
}
