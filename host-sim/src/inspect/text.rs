//! Formats a file's facts as a block of lines.

use std::fmt::Write as _;

use super::inspected::{Inspected, Kind, TreeJoint};

pub(super) fn block(it: &Inspected) -> String {
    let mut text = String::new();
    let mut line = |name: &str, what: &str| {
        // Writing into a string cannot fail.
        let _ = writeln!(text, "  {name:<10}{what}");
    };
    let kind = match it.kind {
        Kind::Motion => "motion",
        Kind::Character => "character",
        Kind::Rig => "rig",
    };
    let maker = it.maker.as_ref().map_or_else(String::new, |maker| format!(", by {maker}"));
    line("what", &format!("{kind}, {}{maker}", it.format));
    line("joints", &it.joints.to_string());
    if let Some(frames) = it.frames {
        let rate = it.rate_hz.map_or_else(
            || "the file does not state their rate".to_owned(),
            |rate_hz| {
                format!("{rate_hz:.3} a second, {:.2} s", frames.saturating_sub(1) as f64 / rate_hz)
            },
        );
        line("frames", &format!("{frames}, {rate}"));
    }
    let unit = it.metres_per_unit.map_or("not known".to_owned(), |unit| format!("{unit:.6} m"));
    line("unit", &format!("{unit}: {}", it.unit_reason));
    line("up", &format!("{}: {}", it.up, it.up_reason));
    if let (Some(height_m), Some(span_m)) = (it.height_m, it.span_m) {
        line("size", &format!("{height_m:.3} m high, {span_m:.3} m across"));
    }
    let nearest = match &it.nearest {
        Some(name) if it.missing.is_empty() => format!("`{name}`, all of its joints are there"),
        Some(name) => format!("nearest to `{name}`; lacks its {}", it.missing.join(", ")),
        None => "none of the known ones".to_owned(),
    };
    if it.kind != Kind::Rig {
        line("skeleton", &nearest);
        let lacks = match &it.landmarks_missing[..] {
            [] => "human, all parts found".to_owned(),
            missing => format!("not found: {}", missing.join(", ")),
        };
        line("body", &lacks);
        line("T-pose", it.t_pose.unwrap_or("none"));
    }
    if it.kind == Kind::Motion {
        line(
            "gaps",
            &if it.gaps == 0 { "none".to_owned() } else { format!("{} samples", it.gaps) },
        );
        line("flips", it.flips.as_deref().unwrap_or("none"));
    }
    for note in &it.notes {
        line("note", note);
    }
    text.push_str(&tree(&it.tree));
    text
}

/// Formats all joints as an indented tree.
fn tree(joints: &[TreeJoint]) -> String {
    let mut children = vec![Vec::new(); joints.len()];
    let mut to_come: Vec<(usize, usize)> = Vec::new();
    for (index, joint) in joints.iter().enumerate() {
        match joint.parent {
            Some(parent) => children[parent].push(index),
            None => to_come.push((index, 0)),
        }
    }
    to_come.reverse();
    let mut text = String::new();
    while let Some((index, depth)) = to_come.pop() {
        let joint = &joints[index];
        let moves = joint.moves.map_or_else(String::new, |moves| format!(", {moves}"));
        let length =
            joint.length_m.map_or_else(String::new, |length_m| format!("  {length_m:.3} m"));
        // Deeper than a screen is wide: the depth is printed as a number.
        let indent =
            if depth <= 40 { "  ".repeat(depth) } else { format!("{}({depth}) ", "  ".repeat(40)) };
        let _ = writeln!(text, "  {indent}{}{length}{moves}", joint.name);
        to_come.extend(children[index].iter().rev().map(|child| (*child, depth + 1)));
    }
    text
}
