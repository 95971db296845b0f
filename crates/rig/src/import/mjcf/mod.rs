//! Reads MJCF, the format of MuJoCo: nested bodies, with classes of defaults.

mod actuator;
mod actuator_force;
mod body;
mod compiler;
mod defaults;
mod equality;
mod include;
mod joint;
mod mass;
mod model;
mod names;
mod parts;
mod pose;
mod shapes;
mod tendon;

use std::collections::BTreeMap;

use glam::DVec3;
use roxmltree::Node;

use super::error::ImportError;
use super::imported::Imported;
use super::note::{NoteKind, Notes};
use super::options::Options;
use super::world::World;
use super::{tie, xml};
use crate::import::imported;
use compiler::{MassRules, flag};
use defaults::Defaults;
use model::Model;
use pose::Angles;

pub use include::LoadPart;

/// Reads an MJCF with parts in other files.
pub(super) fn read_with_parts(
    text: &str,
    options: &Options,
    load: LoadPart<'_>,
) -> Result<Imported, ImportError> {
    read(&include::expand(text, load)?, options)
}

pub(super) fn read(text: &str, options: &Options) -> Result<Imported, ImportError> {
    let text = xml::with_declaration_first(text);
    let document = xml::document(&text)?;
    let root = document.root_element();
    if !root.has_tag_name("mujoco") {
        let found = format!("`{}`", root.tag_name().name());
        return Err(xml::refuse(root, "`mujoco`, the first element of an MJCF", found));
    }
    refuse_parts(root)?;
    let mut notes = Notes::default();
    // Sections may be repeated: a later value overrides an earlier one.
    let compilers: Vec<Node<'_, '_>> = xml::children(root, "compiler").rev().collect();
    let model = Model {
        defaults: Defaults::read(root)?,
        angles: Angles::read(&compilers)?,
        masses: MassRules::read(&compilers)?,
        auto_limits: flag(&compilers, "autolimits")?.unwrap_or(true),
        options,
    };
    let world = World::of(options, gravity(root, &mut notes)?);

    let mut description = imported::empty(root.attribute("model"));
    world.stand(&mut description, &mut notes);
    body::read(root, &model, &mut description, &mut notes)?;
    model.masses.settle(&mut description, &mut notes);
    actuator::read(root, &model, &mut description, &mut notes)?;
    let ties = equality::read(root, &model, &description, &mut notes)?;
    tendon::limits(root, &model, &mut description, &mut notes)?;
    tie::tie(&ties, &mut description, &mut notes);
    imported::tell_massless(&description, &mut notes);
    tell_unread(root, &mut notes);
    imported::finish(root, world, description, notes)
}

/// Refuses elements that MuJoCo expands first: parts from other files, and repeated parts.
fn refuse_parts(root: Node<'_, '_>) -> Result<(), ImportError> {
    const PARTS: [&str; 6] = ["include", "attach", "replicate", "composite", "flexcomp", "plugin"];
    let in_bodies = |node: &Node<'_, '_>| {
        node.ancestors().any(|outer| outer.has_tag_name("worldbody"))
            || node.has_tag_name("include")
    };
    let part = root
        .descendants()
        .find(|node| PARTS.iter().any(|part| node.has_tag_name(*part)) && in_bodies(node));
    match part {
        None => Ok(()),
        Some(node) => {
            let expected = "one file with all bodies written out: load it in MuJoCo, then mujoco.mj_saveLastXML";
            Err(xml::refuse(node, expected, format!("`{}`", node.tag_name().name())))
        }
    }
}

/// Reads the file's gravity, and adds a note if it is not 9.81 m/s² along -z. Returns `None` if the file does not set
/// it: MuJoCo's default is this value.
fn gravity(root: Node<'_, '_>, notes: &mut Notes) -> Result<Option<DVec3>, ImportError> {
    let mut gravity = None;
    for option in xml::children(root, "option") {
        let Some([x, y, z]) = xml::vector(option, "gravity")? else { continue };
        if x.abs().max(y.abs()).max((z + 9.81).abs()) > 0.02 {
            let text =
                format!("gravity is {x} {y} {z} in the file, and 9.81 m/s² downwards in a rig");
            notes.add(NoteKind::Changed, text);
        }
        gravity = Some(DVec3::new(x, y, z));
    }
    Ok(gravity)
}

/// Adds notes on sections without meaning for a rig, counted by name.
fn tell_unread(root: Node<'_, '_>, notes: &mut Notes) {
    const READ: [&str; 10] = [
        "compiler",
        "option",
        "default",
        "worldbody",
        "actuator",
        "equality",
        "asset",
        "visual",
        "statistic",
        "tendon",
    ];
    let mut unread: BTreeMap<&str, usize> = BTreeMap::new();
    for section in root.children().filter(Node::is_element) {
        let tag = section.tag_name().name();
        if !READ.contains(&tag) {
            *unread.entry(tag).or_default() += section.children().filter(Node::is_element).count();
        }
    }
    for (section, count) in unread {
        let text = "sections that say nothing a rig has";
        notes.add_of(NoteKind::LeftOut, text, format!("{}: {count}", xml::shortened(section)));
    }
}
