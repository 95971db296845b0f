//! The nodes of a file as a forest.

use ::gltf::scene::Transform;
use ::gltf::{Document, Node};
use glam::{DMat4, DVec3, DVec4, Mat4, Quat, Vec3};

use crate::character::error::{Refusal, refuse};

/// Every node's parent, and its pose in the world.
pub(super) struct Nodes {
    parents: Vec<Option<usize>>,
    world: Vec<DMat4>,
    /// What is wrong with nodes that flatten what is in them.
    flat: Vec<Option<Refusal>>,
}

/// More than a character has, and few enough that one chain of them takes a moment.
const NODE_COUNT_MAX: usize = 10_000;

/// How far a rotation's length may be from 1: what it is rounded by where it is stored in 16 bits is far less.
const LENGTH_TOLERANCE: f64 = 1e-3;

/// Volume of a cube of sides 1 along a node's axes, below which f32's digits do not tell it from a flat one.
const VOLUME_MIN: f64 = 1e-6;

impl Nodes {
    /// The nodes of a file.
    ///
    /// # Errors
    /// [`Refusal`] for a node that has two parents or is its own ancestor, and for a rotation that is none.
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

    /// From a node's parent to its root.
    pub(super) fn ancestors(&self, node: usize) -> impl Iterator<Item = usize> + '_ {
        // A loop has no end; nobody is deeper than there are nodes.
        std::iter::successors(self.parents[node], |node| self.parents[*node])
            .take(self.parents.len())
    }

    /// From a node's frame to the world.
    ///
    /// # Errors
    /// [`Refusal`] if it has no inverse. Only nodes that are used need one: a scale of zero is how scenes hide things.
    pub(super) fn world(&self, node: usize) -> Result<DMat4, Refusal> {
        let mut way = std::iter::once(node).chain(self.ancestors(node));
        match way.find_map(|node| self.flat[node].clone()) {
            Some(refusal) => Err(refusal),
            None => Ok(self.world[node]),
        }
    }
}

/// From a node's frame to its parent's.
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

/// What is wrong with a node whose axes span no space.
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

/// A node in messages.
fn name(node: &Node<'_>) -> String {
    match node.name() {
        Some(name) => format!("node {} `{name}`", node.index()),
        None => format!("node {}", node.index()),
    }
}
