//! Maximum distance of bodies from a joint that moves them.

use crate::mechanism::{JointModel, Mechanism};

/// Returns an upper bound of the distance of any joint or centre of mass beyond joint `joint` from that joint, m:
/// the sum of the link lengths, with slides at the far end of their range.
pub fn reach_m(mechanism: &Mechanism, joint: usize) -> f64 {
    let mut reach_m = vec![None; mechanism.bodies.len()];
    let mut farthest: f64 = 0.0;
    for (body, link) in mechanism.bodies.iter().enumerate() {
        let here = if body == joint {
            Some(0.0)
        } else {
            let parent = link.parent.and_then(|parent| reach_m.get(parent).copied().flatten());
            parent.map(|parent: f64| parent + link.position_m.length() + slide_m(link))
        };
        if let (Some(slot), Some(here)) = (reach_m.get_mut(body), here) {
            *slot = Some(here);
            farthest = farthest.max(here + link.center_of_mass_m.length());
            for part in &link.merged {
                farthest = farthest.max(here + part.position_m.length());
            }
        }
    }
    farthest
}

fn slide_m(link: &crate::mechanism::Link) -> f64 {
    match (link.joint, link.ranges.first()) {
        (JointModel::Prismatic(_), Some([least, most])) => least.abs().max(most.abs()),
        _ => 0.0,
    }
}
