//! Converts states of joints to states of bodies, and back.

use super::link::Link;
use super::states::{Joint, State};

impl Joint {
    /// Returns the joints converted to world states and back, as in a plant that stores states in the world.
    pub fn through_world(links: &[Link], joints: &[Self]) -> Vec<Self> {
        let states = body_states(links, joints);
        let joint = |(link, state): (&Link, &State)| {
            state.joint(&link.parent.map_or_else(State::world, |parent| states[parent]))
        };
        links.iter().zip(&states).map(joint).collect()
    }
}

/// Returns the states of all bodies in the world.
pub fn body_states(links: &[Link], joints: &[Joint]) -> Vec<State> {
    let mut states: Vec<State> = Vec::with_capacity(links.len());
    for (link, joint) in links.iter().zip(joints) {
        let parent = link.parent.map_or_else(State::world, |parent| states[parent]);
        states.push(parent.child(joint));
    }
    states
}
