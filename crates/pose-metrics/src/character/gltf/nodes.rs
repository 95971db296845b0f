//! The nodes of a file as a forest.

use ::gltf::scene::Transform;
use ::gltf::{Document, Node};
use glam::{DMat4, DVec3, DVec4, Mat4, Quat, Vec3};

use crate::character::error::{Refusal, refuse};

/// Parent and world pose of every node.
pub(super) struct Nodes {
    parents: Vec<Option<usize>>,
    world: Vec<DMat4>,
    /// Fault of each node whose transform is flat, which would flatten all that it contains.
    flat: Vec<Option<Refusal>>,
}

/// Maximum number of nodes: more than a character has, and few enough to process a single chain quickly.
const NODE_COUNT_MAX: usize = 10_000;

/// Maximum deviation of a rotation's length from 1. The rounding of 16-bit storage is far smaller.
const LENGTH_TOLERANCE: f64 = 1e-3;

/// Minimum volume of a unit cube along a node's axes. Below it, f32 cannot distinguish the cube from a flat one.
const VOLUME_MIN: f64 = 1e-6;

impl Nodes {
    /// Reads the nodes of a file.
    ///
    /// # Errors
    /// [`Refusal`] for too many nodes, for a node that has two parents or is its own ancestor, and for an invalid
    /// rotation.
    pub(super) fn new(document: &Document) -> Result<Self, Refusal> {
        let count = document.nodes().count();
        if count > NODE_COUNT_MAX {
            return Err(refuse("the file", format!("at most {NODE_COUNT_MAX} nodes"), count));
        }
        let local: Vec<DMat4> =
            document.nodes().map(|node| local(&node)).collect::<Result<_, _>>()?;
        let flat = document.nodes().zip(&local).map(|(node, local)| flat(&node, local)).collect();
        let mut parents = vec![None; local.len()];
        for node in document.nodes() {
            for child in node.children() {
                if let Some(first) = parents[child.index()].replace(node.index()) {
                    let found = format!("{first} and {}", node.index());
                    return Err(refuse(format!("node {}", child.index()), "one parent", found));
                }
            }
        }
        let mut nodes = Self { parents, world: Vec::new(), flat };
        for node in 0..local.len() {
            if nodes.ancestors(node).count() >= local.len() {
                let item = format!("node {node}");
                return Err(refuse(item, "ancestors that end at a root", "a loop"));
            }
            let way = nodes.ancestors(node);
            let world = way.fold(local[node], |pose, above| local[above] * pose);
            nodes.world.push(world);
        }
        Ok(nodes)
    }

    /// Returns the ancestors of a node, from its parent to its root.
    pub(super) fn ancestors(&self, node: usize) -> impl Iterator<Item = usize> + '_ {
        // Limited, since a cycle has no end. The depth of a node is at most the number of nodes.
        std::iter::successors(self.parents[node], |node| self.parents[*node])
            .take(self.parents.len())
    }

    /// Returns the transform from a node's frame to the world.
    ///
    /// # Errors
    /// [`Refusal`] if the transform has no inverse. Only used nodes need one: scenes hide things with a scale of
    /// zero.
    pub(super) fn world(&self, node: usize) -> Result<DMat4, Refusal> {
        let mut way = std::iter::once(node).chain(self.ancestors(node));
        match way.find_map(|node| self.flat[node].clone()) {
            Some(refusal) => Err(refusal),
            None => Ok(self.world[node]),
        }
    }
}

/// Returns the transform from a node's frame to its parent's.
fn local(node: &Node<'_>) -> Result<DMat4, Refusal> {
    match node.transform() {
        Transform::Matrix { matrix } => Ok(Mat4::from_cols_array_2d(&matrix).as_dmat4()),
        Transform::Decomposed { translation, rotation, scale } => {
            let unit = Quat::from_array(rotation).as_dquat();
            let length = unit.length();
            if !(1.0 - LENGTH_TOLERANCE..=1.0 + LENGTH_TOLERANCE).contains(&length) {
                let item = format!("{}: rotation", name(node));
                let found = format!("{rotation:?} of length {length}");
                return Err(refuse(item, "a quaternion of length 1", found));
            }
            let (scale, translation) = (Vec3::from(scale), Vec3::from(translation));
            Ok(DMat4::from_scale_rotation_translation(
                scale.as_dvec3(),
                unit.normalize(),
                translation.as_dvec3(),
            ))
        }
    }
}

/// Returns the fault of a node whose axes are linearly dependent.
fn flat(node: &Node<'_>, local: &DMat4) -> Option<Refusal> {
    let axes = [local.x_axis, local.y_axis, local.z_axis].map(DVec4::truncate);
    let [x, y, z] = axes.map(DVec3::normalize_or_zero);
    if x.cross(y).dot(z).abs() >= VOLUME_MIN {
        return None;
    }
    let (item, expected, found) = match node.transform() {
        Transform::Matrix { matrix } => {
            ("matrix", "one that has an inverse", format!("{matrix:?}"))
        }
        Transform::Decomposed { scale, .. } => {
            ("scale", "three numbers other than 0", format!("{scale:?}"))
        }
    };
    Some(refuse(format!("{}: {item}", name(node)), expected, found))
}

/// Returns a node's name for messages.
fn name(node: &Node<'_>) -> String {
    match node.name() {
        Some(name) => format!("node {} `{name}`", node.index()),
        None => format!("node {}", node.index()),
    }
}
