//! Joints that follow others, in a table that has columns for only some of them.

use sinew_rig::mechanism::Ties;

/// Sets the coordinates of tied joints without a column, from the joints with a column (`given`). A follower without a
/// column follows its leader. The position of a leader without a column is computed from a follower with a column.
pub(super) fn fill_tied(ties: &Ties, given: &[usize], q: &mut [f64]) {
    for tie in ties.each() {
        let [own, leader] = tie.places();
        let other_gives = ties
            .each()
            .find(|other| other.leader == tie.leader && given.contains(&other.places()[0]));
        if !given.contains(&leader)
            && let Some(other) = other_gives
        {
            q[leader] = other.leader_position(q[other.places()[0]]);
        }
        if !given.contains(&own) {
            q[own] = tie.factor * q[leader] + tie.offset;
        }
    }
}
