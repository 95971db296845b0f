//! The bodies of the figure in regular numbering.

use serde::{Deserialize, Serialize};

/// Number of bodies of the figure.
pub const BODY_COUNT: usize = 18;

/// One body of the figure, as a place in the tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Body {
    /// Name, as tables and mapping files use it.
    pub name: &'static str,
    /// Index of the parent body; `None` for the pelvis.
    pub parent: Option<usize>,
}

/// The way body 0, the pelvis, is connected to the world.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Root {
    /// The pelvis moves freely, driven by an external force and torque.
    #[default]
    Driven,
    /// The pelvis is bolted to the world at its initial position.
    Fixed,
}

const fn body(name: &'static str, parent: usize) -> Body {
    Body { name, parent: Some(parent) }
}

/// The figure: the pelvis on a free joint (6 dofs) and 17 bodies on spherical joints. Head, hands and feet are its
/// leaves.
pub const BODIES: [Body; BODY_COUNT] = [
    Body { name: "pelvis", parent: None },
    body("abdomen", 0),
    body("thorax", 1),
    body("head", 2),
    body("clavicle_l", 2),
    body("upper_arm_l", 4),
    body("forearm_l", 5),
    body("hand_l", 6),
    body("clavicle_r", 2),
    body("upper_arm_r", 8),
    body("forearm_r", 9),
    body("hand_r", 10),
    body("thigh_l", 0),
    body("shank_l", 12),
    body("foot_l", 13),
    body("thigh_r", 0),
    body("shank_r", 15),
    body("foot_r", 16),
];

/// Returns whether no joint is attached to this body. True for the head, the hands and the feet.
pub fn is_leaf(body: usize) -> bool {
    BODIES.iter().all(|other| other.parent != Some(body))
}
