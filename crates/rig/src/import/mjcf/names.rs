//! Names of bodies and joints: checked to be unique, and created for parts without one.

use std::collections::BTreeSet;

use roxmltree::Node;

use super::super::xml;
use crate::import::error::ImportError;
use crate::import::options::Options;

/// Names in use.
pub(super) struct Names {
    pub(super) bodies: BTreeSet<String>,
    pub(super) joints: BTreeSet<String>,
}

impl Names {
    pub(super) fn read(root: Node<'_, '_>) -> Result<Self, ImportError> {
        let mut names = Self { bodies: BTreeSet::new(), joints: BTreeSet::new() };
        let in_world = xml::children(root, "worldbody").flat_map(|world| world.descendants());
        for node in in_world.filter(Node::is_element) {
            let taken = match node.tag_name().name() {
                "body" => &mut names.bodies,
                "joint" | "freejoint" => &mut names.joints,
                _ => continue,
            };
            let Some(name) = node.attribute("name").filter(|name| !name.is_empty()) else {
                continue;
            };
            if !taken.insert(name.to_owned()) {
                return Err(xml::refuse_value(node, "name", "a name that no other one has"));
            }
        }
        Ok(names)
    }

    pub(super) fn refuse_unknown_cuts(
        &self,
        root: Node<'_, '_>,
        options: &Options,
    ) -> Result<(), ImportError> {
        let is_there = |cut: &String| self.bodies.contains(cut) || self.joints.contains(cut);
        match options.cut.iter().find(|cut| !is_there(cut)) {
            None => Ok(()),
            Some(unknown) => {
                let expected = "joints or bodies of the file as those to cut";
                Err(xml::refuse(root, expected, format!("`{unknown}`")))
            }
        }
    }

    /// Returns an unused name based on `like`, and marks it as used.
    pub(super) fn fresh(taken: &mut BTreeSet<String>, like: &str) -> String {
        let mut name = like.to_owned();
        let mut count = taken.len();
        while !taken.insert(name.clone()) {
            count += 1;
            name = format!("{like}_{count}");
        }
        name
    }
}
