//! Arranges links and joints as a tree.

use std::collections::{BTreeMap, BTreeSet};

use roxmltree::Node;

use super::super::note::{Notes, list};
use super::super::xml;
use super::joint::UrdfJoint;
use crate::import::error::ImportError;
use crate::import::note::NoteKind;
use crate::import::options::Options;

/// Links from the base outwards, depth first in the order of the file; joint `i` moves link `i + 1`.
pub(super) struct Tree<'a, 'd> {
    pub(super) links: Vec<Node<'a, 'd>>,
    pub(super) joints: Vec<UrdfJoint<'a, 'd>>,
}

/// Arranges the links and joints of a robot.
pub(super) fn tree<'a, 'd>(
    robot: Node<'a, 'd>,
    links: &[Node<'a, 'd>],
    joints: Vec<UrdfJoint<'a, 'd>>,
    options: &Options,
    notes: &mut Notes,
) -> Result<Tree<'a, 'd>, ImportError> {
    let (kept, cut) = cut(robot, joints, options, notes)?;
    let movers = movers(&kept)?;
    let name = |link: usize| links[link].attribute("name").unwrap_or_default();

    let free: BTreeSet<usize> =
        (0..links.len()).filter(|link| !movers.contains_key(link)).collect();
    let (cut_off, roots): (Vec<usize>, Vec<usize>) =
        free.iter().partition(|link| cut.iter().any(|joint| joint.child == **link));
    let root = match *roots.as_slice() {
        [root] => root,
        [] if free.is_empty() => {
            let found = circle(links, &kept, &movers);
            return Err(xml::refuse(robot, "a link that no joint moves", found));
        }
        _ => {
            let roots: Vec<&str> = roots.iter().map(|link| name(*link)).collect();
            let expected = "one link that no joint moves; a fixed joint welds another one to it";
            let found = format!("{}: {}", roots.len(), list(&roots));
            return Err(xml::refuse(robot, expected, found));
        }
    };

    let mut on_link: Vec<Vec<usize>> = vec![Vec::new(); links.len()];
    for (place, joint) in kept.iter().enumerate() {
        on_link[joint.parent].push(place);
    }
    let in_tree = outwards(root, &on_link, &kept);
    let mut left_out = 0;
    for link in cut_off {
        let beyond = outwards(link, &on_link, &kept);
        left_out += beyond.len();
        let text = "links that are not connected without the joints left out";
        notes.add_of(NoteKind::LeftOut, text, name(link));
        for place in beyond {
            notes.add_of(NoteKind::LeftOut, text, name(kept[place].child));
        }
    }
    if in_tree.len() + left_out < kept.len() {
        let found = circle(links, &kept, &movers);
        return Err(xml::refuse(robot, "links that are all connected to the root", found));
    }

    let tree_links: Vec<Node<'a, 'd>> = std::iter::once(root)
        .chain(in_tree.iter().map(|place| kept[*place].child))
        .map(|link| links[link])
        .collect();
    let mut kept: Vec<Option<UrdfJoint<'a, 'd>>> = kept.into_iter().map(Some).collect();
    let joints = in_tree.iter().filter_map(|place| kept[*place].take()).collect();
    Ok(Tree { links: tree_links, joints })
}

/// Separates the joints that the user cuts from the others.
fn cut<'a, 'd>(
    robot: Node<'a, 'd>,
    joints: Vec<UrdfJoint<'a, 'd>>,
    options: &Options,
    notes: &mut Notes,
) -> Result<(Vec<UrdfJoint<'a, 'd>>, Vec<UrdfJoint<'a, 'd>>), ImportError> {
    let names: BTreeSet<&str> = joints.iter().map(|joint| joint.name).collect();
    if let Some(unknown) = options.cut.iter().find(|cut| !names.contains(cut.as_str())) {
        let expected = "joints of the file as those to cut";
        return Err(xml::refuse(robot, expected, format!("`{unknown}`")));
    }
    let wanted: BTreeSet<&str> = options.cut.iter().map(String::as_str).collect();
    let (cut, kept): (Vec<_>, Vec<_>) =
        joints.into_iter().partition(|joint| wanted.contains(joint.name));
    for joint in &cut {
        notes.add_of(NoteKind::LeftOut, "joints, by the user's word", joint.name);
    }
    Ok((kept, cut))
}

/// Returns the joint that moves each link; fails if two joints move a link.
fn movers(joints: &[UrdfJoint<'_, '_>]) -> Result<BTreeMap<usize, usize>, ImportError> {
    let mut movers = BTreeMap::new();
    for (place, joint) in joints.iter().enumerate() {
        if let Some(first) = movers.insert(joint.child, place) {
            let found = format!("`{}` and `{}`: a closed loop", joints[first].name, joint.name);
            let expected = format!(
                "one joint that moves the link `{}`; leave the other out by the option cut",
                joint.joint.child
            );
            return Err(xml::refuse(joint.node, expected, found));
        }
    }
    Ok(movers)
}

/// Returns the joints beyond a link, depth first in the order of the file.
fn outwards(link: usize, on_link: &[Vec<usize>], joints: &[UrdfJoint<'_, '_>]) -> Vec<usize> {
    let mut order = Vec::new();
    let mut to_come: Vec<usize> = on_link[link].iter().rev().copied().collect();
    while let Some(place) = to_come.pop() {
        order.push(place);
        to_come.extend(on_link[joints[place].child].iter().rev());
    }
    order
}

/// Describes a loop of links in words; the caller has ensured that there is one.
fn circle(
    links: &[Node<'_, '_>],
    joints: &[UrdfJoint<'_, '_>],
    movers: &BTreeMap<usize, usize>,
) -> String {
    let inwards = |link: &usize| movers.get(link).map(|place| joints[*place].parent);
    // Each link is visited once. A walk that returns to its own links is on a loop; a walk that reaches the links
    // of another walk is not.
    let mut walks: Vec<Option<usize>> = vec![None; links.len()];
    let on_loop = (0..links.len()).find_map(|walk| {
        let mut link = Some(walk);
        while let Some(here) = link {
            match walks[here].replace(walk) {
                None => link = inwards(&here),
                Some(earlier) => return (earlier == walk).then_some(here),
            }
        }
        None
    });
    let Some(start) = on_loop else { return "a loop".to_owned() };
    let mut names = vec![links[start].attribute("name").unwrap_or_default()];
    for link in std::iter::successors(inwards(&start), inwards).take_while(|link| *link != start) {
        names.push(links[link].attribute("name").unwrap_or_default());
    }
    names.reverse();
    format!("a closed loop: {}", list(&names))
}
