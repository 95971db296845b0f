//! The nodes of a file as a forest.

use ::gltf::Document;
use glam::{DMat4, Mat4};

use crate::character::error::{Refusal, refuse};

/// Every node's parent, and its pose in the world.
pub(super) struct Nodes {
    parents: Vec<Option<usize>>,
    world: Vec<DMat4>,
}

impl Nodes {
    /// The nodes of a file.
    ///
    /// # Errors
    /// [`Refusal`] for a node that has two parents or is its own ancestor.
    pub(super) fn new(document: &Document) -> Result<Self, Refusal> {
        let local: Vec<DMat4> = document
            .nodes()
            .map(|node| Mat4::from_cols_array_2d(&node.transform().matrix()).as_dmat4())
            .collect();
        let mut parents = vec![None; local.len()];
        for node in document.nodes() {
            for child in node.children() {
                if let Some(first) = parents[child.index()].replace(node.index()) {
                    let found = format!("{first} and {}", node.index());
                    return Err(refuse(format!("node {}", child.index()), "one parent", found));
                }
            }
        }
        let mut nodes = Self { parents, world: Vec::new() };
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
    pub(super) fn world(&self, node: usize) -> DMat4 {
        self.world[node]
    }
}
