//! The joints of a file's skins, and the binding of each skin to them.

use ::gltf::{Document, Skin};
use glam::{DMat4, DVec3};

use super::accessor::Elements;
use super::buffers::Buffers;
use super::nodes::Nodes;
use crate::character::error::{Refusal, refuse};
use crate::character::limits::JOINT_COUNT_MAX;
use crate::character::model::Joint;

/// The joints of all skins that a mesh uses.
pub(super) struct Skeleton {
    /// Node of each joint.
    pub(super) nodes: Vec<usize>,
    /// Transform from each joint's frame to the world, in the pose in which the mesh is modelled.
    pub(super) world: Vec<DMat4>,
    /// Binding of each skin; `None` for a skin that no mesh uses.
    pub(super) skins: Vec<Option<Binding>>,
}

/// The binding of a skin's meshes to joints.
pub(super) struct Binding {
    /// Joint of each entry of the skin.
    pub(super) joints: Vec<usize>,
    /// Transform from the skin's meshes to the world; `None` if each joint's transform is used instead.
    pub(super) world: Option<DMat4>,
}

/// Maximum distance between the positions of a joint in two skins, m.
const SAME_PLACE_M: f64 = 1e-3;

impl Skeleton {
    pub(super) fn new(
        document: &Document,
        nodes: &Nodes,
        buffers: &Buffers,
    ) -> Result<Self, Refusal> {
        let mut skeleton = Self { nodes: Vec::new(), world: Vec::new(), skins: Vec::new() };
        for skin in document.skins() {
            let index = Some(skin.index());
            let is_used = document
                .nodes()
                .any(|node| node.mesh().is_some() && node.skin().map(|skin| skin.index()) == index);
            let binding = is_used.then(|| skeleton.bind(&skin, nodes, buffers)).transpose();
            let binding =
                binding.map_err(|refusal| refusal.of(format!("skin {}", skin.index())))?;
            skeleton.skins.push(binding);
        }
        if skeleton.nodes.is_empty() {
            return Err(refuse("the file", "a node with a mesh and a skin", "none"));
        }
        Ok(skeleton)
    }

    /// Returns the joint that corresponds to a node.
    pub(super) fn joint(&self, node: usize) -> Option<usize> {
        self.nodes.iter().position(|joint| *joint == node)
    }

    /// Returns the nearest ancestor of a node that is a joint.
    pub(super) fn joint_above(&self, node: usize, nodes: &Nodes) -> Option<usize> {
        nodes.ancestors(node).find_map(|node| self.joint(node))
    }

    fn bind(
        &mut self,
        skin: &Skin<'_>,
        nodes: &Nodes,
        buffers: &Buffers,
    ) -> Result<Binding, Refusal> {
        let of_skin: Vec<usize> = skin.joints().map(|node| node.index()).collect();
        if of_skin.is_empty() || of_skin.len() > JOINT_COUNT_MAX {
            let expected = format!("1 to {JOINT_COUNT_MAX}");
            return Err(refuse("joints", expected, of_skin.len()));
        }
        let inverse = skin
            .inverse_bind_matrices()
            .map(|accessor| {
                let elements = Elements::matrices(&accessor, buffers)?;
                if elements.count() < of_skin.len() {
                    let expected = format!("{} inverse bind matrices", of_skin.len());
                    return Err(refuse("joints", expected, elements.count()));
                }
                Ok(elements)
            })
            .transpose()?;
        let root = of_skin
            .iter()
            .position(|node| !nodes.ancestors(*node).any(|above| of_skin.contains(&above)))
            .ok_or_else(|| refuse("joints", "one that is below no other", "none"))?;
        let meshes = match &inverse {
            Some(inverse) => Some(nodes.world(of_skin[root])? * inverse.matrix(root)),
            None => None,
        };
        let mut joints = Vec::with_capacity(of_skin.len());
        for (entry, node) in of_skin.into_iter().enumerate() {
            let world = match (&meshes, &inverse) {
                (Some(meshes), Some(inverse)) => *meshes * inverse.matrix(entry).inverse(),
                _ => nodes.world(node)?,
            };
            if !world.is_finite() {
                let found = "one that has no inverse";
                return Err(refuse(format!("joint {entry}"), "an inverse bind matrix", found));
            }
            joints.push(self.add(node, world)?);
        }
        Ok(Binding { joints, world: meshes })
    }

    /// Returns the joint of a node, and adds it unless an earlier skin has it.
    fn add(&mut self, node: usize, world: DMat4) -> Result<usize, Refusal> {
        let Some(joint) = self.joint(node) else {
            self.nodes.push(node);
            self.world.push(world);
            return Ok(self.nodes.len() - 1);
        };
        let (first_m, second_m) = (place_m(&self.world[joint]), place_m(&world));
        if first_m.distance(second_m) > SAME_PLACE_M {
            let item = format!("the joint of node {node}");
            return Err(refuse(item, format!("it at {first_m} as in a skin before"), second_m));
        }
        Ok(joint)
    }

    /// Returns the joints for a character, with a single root.
    pub(super) fn joints(&self, document: &Document, nodes: &Nodes) -> Result<Vec<Joint>, Refusal> {
        let names = names(document);
        let mut parents: Vec<Option<usize>> =
            self.nodes.iter().map(|node| self.joint_above(*node, nodes)).collect();
        let mut joints = Vec::new();
        let roots: Vec<usize> =
            (0..parents.len()).filter(|joint| parents[*joint].is_none()).collect();
        if let [first, others @ ..] = &roots[..]
            && !others.is_empty()
        {
            let is_above = |above: &usize, joint: &usize| {
                nodes.ancestors(self.nodes[*joint]).any(|node| node == *above)
            };
            let common = nodes
                .ancestors(self.nodes[*first])
                .find(|above| others.iter().all(|joint| is_above(above, joint)));
            let common = common.ok_or_else(|| {
                let found = format!("`{}` and {} others", names[self.nodes[*first]], others.len());
                refuse("the joints", "one root, or a node above all of them", found)
            })?;
            for root in &roots {
                parents[*root] = Some(parents.len());
            }
            joints.push((common, None, place_m(&nodes.world(common)?)));
        }
        let of_skins = self.nodes.iter().zip(parents).zip(&self.world);
        let of_skins = of_skins.map(|((node, parent), world)| (*node, parent, place_m(world)));
        Ok(of_skins
            .chain(joints)
            .map(|(node, parent, position_m)| Joint {
                name: names[node].clone(),
                parent,
                position_m,
            })
            .collect())
    }
}

fn place_m(world: &DMat4) -> DVec3 {
    world.w_axis.truncate()
}

/// Returns a unique name for every node.
fn names(document: &Document) -> Vec<String> {
    let given: Vec<Option<&str>> = document.nodes().map(|node| node.name()).collect();
    let name = |(index, name): (usize, Option<&str>)| match name {
        Some(name) if given.iter().filter(|other| **other == Some(name)).count() == 1 => {
            name.to_owned()
        }
        Some(name) => format!("{name} (node {index})"),
        None => format!("node {index}"),
    };
    given.iter().copied().enumerate().map(name).collect()
}
