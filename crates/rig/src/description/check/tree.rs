//! Checks that the bodies are a tree: one base, and every other body moved by exactly one joint.

use super::names::Names;
use super::part::Part;
use crate::description::error::{DescriptionError, Path, Step};
use crate::description::{Description, Joint, JointType};
use crate::mechanism::BODY_COUNT_MAX;

/// Tree of bodies, by index.
pub(in crate::description) struct Shape {
    /// Body that no joint moves.
    pub(in crate::description) base: usize,
    /// Joints on each body, in the order of the file.
    pub(in crate::description) joints_on: Vec<Vec<usize>>,
    /// Body that each joint moves.
    pub(in crate::description) child: Vec<usize>,
}

pub(super) fn shape(rig: &Description, bodies: &Names<'_>) -> Result<Shape, DescriptionError> {
    // For each body: the joint that moves it, and its parent body.
    let mut held_by: Vec<Option<(usize, usize)>> = vec![None; rig.bodies.len()];
    let mut joints_on = vec![Vec::new(); rig.bodies.len()];
    let mut child = Vec::new();
    for (index, joint) in rig.joints.iter().enumerate() {
        let part = part(index, joint);
        let on = bodies.find(part, &[Step::Key("parent")], &joint.parent)?;
        let moved = bodies.find(part, &[Step::Key("child")], &joint.child)?;
        if let Some((first, _)) = held_by[moved] {
            let expected =
                "a body that no other joint moves: a rig is a tree, without closed loops";
            let found = format!(
                "{:?}, which joint {:?} moves already",
                joint.child, rig.joints[first].name
            );
            return Err(part.refuse(&[Step::Key("child")], expected, found));
        }
        held_by[moved] = Some((index, on));
        joints_on[on].push(index);
        child.push(moved);
    }
    let base = base(rig, &held_by)?;
    refuse_loop(rig, &held_by, base)?;
    let fixed = rig.joints.iter().filter(|joint| joint.kind == JointType::Fixed).count();
    let count = rig.bodies.len() - fixed;
    if count > BODY_COUNT_MAX {
        return Err(of_rig(
            "body",
            format!("at most {BODY_COUNT_MAX} bodies, those on fixed joints not counted"),
            count.to_string(),
        ));
    }
    Ok(Shape { base, joints_on, child })
}

fn part(index: usize, joint: &Joint) -> Part<'_> {
    Part::of("joint", index, &joint.name)
}

/// Creates the error for a value of the rig as a whole.
pub(super) fn of_rig(key: &'static str, expected: String, found: String) -> DescriptionError {
    DescriptionError {
        path: Path(vec![Step::Key(key)]),
        item: "the rig".to_owned(),
        expected,
        found,
    }
}

fn base(rig: &Description, held_by: &[Option<(usize, usize)>]) -> Result<usize, DescriptionError> {
    let bases: Vec<usize> = (0..held_by.len()).filter(|body| held_by[*body].is_none()).collect();
    match bases[..] {
        [base] => Ok(base),
        [_, second, ..] => {
            let names: Vec<_> =
                bases.iter().map(|body| format!("{:?}", rig.bodies[*body].name)).collect();
            let expected =
                "one body that no joint moves, the base, and a joint for every other body";
            let found = format!("{} that no joint moves: {}", bases.len(), names.join(", "));
            Err(Part::of("body", second, &rig.bodies[second].name).refuse(&[], expected, found))
        }
        [] if held_by.is_empty() => {
            Err(of_rig("body", "at least one body".to_owned(), "none".to_owned()))
        }
        // Every body has a parent, therefore the path from any body towards the base never ends.
        [] => Err(loop_through(rig, held_by, 0)),
    }
}

/// Refuses bodies that are not connected to the base: each has a parent, therefore they form a loop.
fn refuse_loop(
    rig: &Description,
    held_by: &[Option<(usize, usize)>],
    base: usize,
) -> Result<(), DescriptionError> {
    let mut hangs_on_base = vec![false; held_by.len()];
    hangs_on_base[base] = true;
    for start in 0..held_by.len() {
        let mut way = Vec::new();
        let mut body = start;
        while !hangs_on_base[body] {
            if way.len() > held_by.len() {
                return Err(loop_through(rig, held_by, start));
            }
            way.push(body);
            let Some((_, parent)) = held_by[body] else { break };
            body = parent;
        }
        for body in way {
            hangs_on_base[body] = true;
        }
    }
    Ok(())
}

/// Creates the error that names the loop at the end of the path from a body towards its parents.
fn loop_through(
    rig: &Description,
    held_by: &[Option<(usize, usize)>],
    start: usize,
) -> DescriptionError {
    let up = |body: usize| held_by[body].map_or(body, |(_, parent)| parent);
    // After as many steps as there are bodies, the path is inside the loop.
    let inside = (0..held_by.len()).fold(start, |body, _| up(body));
    let mut names = vec![rig.bodies[inside].name.as_str()];
    let mut body = up(inside);
    while body != inside {
        names.push(&rig.bodies[body].name);
        body = up(body);
    }
    names.push(&rig.bodies[inside].name);
    let joint = held_by[inside].map_or(0, |(joint, _)| joint);
    part(joint, &rig.joints[joint]).refuse(
        &[Step::Key("parent")],
        "a tree in which every body is connected to the base",
        format!("the loop {}", names.join(" on ")),
    )
}
