//! A character: its joints at rest, checked.

use std::collections::BTreeMap;

use glam::DVec3;

use super::error::{Refusal, refuse};
use super::limits::{A_PLACE, JOINT_COUNT_MAX, is_place};
use super::mesh::Mesh;

/// A character at rest: joints in the order of the file, and its skin.
#[derive(Debug, Clone, PartialEq)]
pub struct Character {
    pub(super) name: String,
    pub(super) joints: Vec<Joint>,
    pub(super) mesh: Option<Mesh>,
    /// Notes for the user: height, unit, and faults in the file that were tolerated.
    pub(super) notes: Vec<String>,
}

/// A joint at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name of the joint, unique in the character.
    pub name: String,
    /// Index of the parent joint, which may be larger than the joint's own; `None` for the single root.
    pub parent: Option<usize>,
    /// Position in the world, in metres.
    pub position_m: DVec3,
}

impl Character {
    /// Creates a character from its parts, which are checked.
    ///
    /// # Errors
    /// [`Refusal`] for no joint or too many joints, names that are not unique, parents that are not a tree with
    /// one root, numbers that are not finite, and indices of vertices or joints that do not exist.
    pub fn new(name: String, joints: Vec<Joint>, mesh: Option<Mesh>) -> Result<Self, Refusal> {
        check_joints(&joints)?;
        if let Some(mesh) = &mesh {
            mesh.check(joints.len())?;
        }
        Ok(Self { name, joints, mesh, notes: Vec::new() })
    }

    /// Returns the name: the stem of the file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the joints, in the order of the file.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// Returns the skin, if there is one.
    pub fn mesh(&self) -> Option<&Mesh> {
        self.mesh.as_ref()
    }

    /// Returns notes for the user; the first is the character's size.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Returns the two ends of the bone that ends at a joint, from its parent; `None` for the root.
    pub fn bone_m(&self, joint: usize) -> Option<[DVec3; 2]> {
        let Joint { parent, position_m, .. } = self.joints[joint];
        Some([self.joints[parent?].position_m, position_m])
    }

    /// Returns the length of the bone that ends at a joint; 0 for the root.
    pub fn bone_length_m(&self, joint: usize) -> f64 {
        self.bone_m(joint).map_or(0.0, |[from, to]| from.distance(to))
    }

    /// Returns the index of the joint called `name`.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|joint| joint.name == name)
    }
}

/// Maximum length of a name in bytes. Longer names indicate damage, and would make pictures of any width.
const NAME_BYTES_MAX: usize = 256;

fn check_joints(joints: &[Joint]) -> Result<(), Refusal> {
    let count = joints.len();
    if !(1..=JOINT_COUNT_MAX).contains(&count) {
        return Err(refuse("the character", format!("1 to {JOINT_COUNT_MAX} joints"), count));
    }
    let mut places = BTreeMap::new();
    for (index, Joint { name, parent, position_m }) in joints.iter().enumerate() {
        let item = || format!("joint {index} `{name}`");
        if name.len() > NAME_BYTES_MAX {
            let expected = format!("a name of at most {NAME_BYTES_MAX} bytes");
            return Err(refuse(format!("joint {index}"), expected, name.len()));
        }
        if let Some(first) = places.insert(name, index) {
            return Err(refuse(item(), "a name of its own", format!("that of joint {first}")));
        }
        if let Some(parent) = parent.filter(|parent| *parent >= count) {
            return Err(refuse(item(), format!("a parent below {count}"), parent));
        }
        if !is_place(*position_m) {
            return Err(refuse(item(), A_PLACE, position_m));
        }
    }
    let mut roots = joints.iter().filter(|joint| joint.parent.is_none());
    if let (Some(first), Some(second)) = (roots.next(), roots.next()) {
        let found = format!("`{}` and `{}`", first.name, second.name);
        return Err(refuse("the character", "one joint without a parent", found));
    }
    for (index, joint) in joints.iter().enumerate() {
        // A path to the root that is longer than the number of joints contains a cycle. Without a root every path
        // does.
        let way = std::iter::successors(joint.parent, |parent| joints[*parent].parent);
        if way.take(count).count() == count {
            let item = format!("joint {index} `{}`", joint.name);
            return Err(refuse(item, "ancestors that end at a root", "a loop of parents"));
        }
    }
    Ok(())
}
