//! Reads limits of joints, and finds values that look like placeholders.

use roxmltree::Node;

use super::super::note::Notes;
use super::super::{none, xml};
use crate::description::{Joint, JointType};
use crate::import::error::ImportError;
use crate::import::note::NoteKind;

/// Limit of speed (rad/s, m/s) or effort (N m, N) from which the value means "no limit", because no servo reaches
/// it.
const PLACEHOLDER: f64 = 1000.0;

/// End of a rotation's range, rad, beyond which the file probably contains degrees: more than a whole turn to one
/// side, with a tolerance for a turn that was rounded up.
const MORE_THAN_A_TURN: f64 = 1.05 * std::f64::consts::TAU;

/// Reads the `limit` element into the joint.
pub(super) fn read(
    node: Node<'_, '_>,
    joint: &mut Joint,
    notes: &mut Notes,
) -> Result<(), ImportError> {
    let slides = match joint.kind {
        JointType::Revolute => false,
        JointType::Prismatic => true,
        _ => return Ok(()),
    };
    let continuous = node.attribute("type") == Some("continuous");
    let Some(limit) = xml::child(node, "limit")? else {
        if !continuous {
            let text = "has no `limit`: a range, and speed and effort, are open in the rig";
            notes.add_of(NoteKind::Doubtful, text, &joint.name);
        }
        return Ok(());
    };
    let (lower, upper) = (xml::any_number(limit, "lower")?, xml::any_number(limit, "upper")?);
    if !continuous && let Some(range) = range(limit, lower, upper, joint, notes)? {
        if slides {
            joint.range_m = Some(range);
        } else {
            if range.iter().any(|end| end.abs() > MORE_THAN_A_TURN) {
                let text = "its range is more than a turn to one side: URDF has radians; are these degrees?";
                notes.add_of(NoteKind::Doubtful, text, &joint.name);
            }
            joint.range_rad = vec![range];
        }
    }
    let speed = largest(limit, "velocity", joint, notes)?;
    if slides {
        joint.speed_m_s = speed;
    } else {
        joint.speed_rad_s = speed;
    }
    joint.effort = largest(limit, "effort", joint, notes)?;
    Ok(())
}

fn range(
    limit: Node<'_, '_>,
    lower: Option<f64>,
    upper: Option<f64>,
    joint: &Joint,
    notes: &mut Notes,
) -> Result<Option<[f64; 2]>, ImportError> {
    if lower.is_none() && upper.is_none() {
        // URDF's default of both is zero: a joint that cannot move, which is certainly not intended.
        let text = "`limit` gives neither `lower` nor `upper`: the range is open in the rig";
        notes.add_of(NoteKind::Doubtful, text, &joint.name);
        return Ok(None);
    }
    let (least, most) = (lower.unwrap_or(0.0), upper.unwrap_or(0.0));
    let is_zero = least.abs() <= 0.0 && most.abs() <= 0.0;
    if is_zero && lower.is_some() && upper.is_some() {
        let text =
            "`lower` and `upper` are both 0, which stands for none: the range is open in the rig";
        notes.add_of(NoteKind::LeftOut, text, &joint.name);
        return Ok(None);
    }
    if [least, most].into_iter().any(none::is_endless) {
        return Ok(none::range("the range", [least, most], &joint.name, notes));
    }
    if lower.is_none() || upper.is_none() {
        let text = "`limit` gives one end of the range: the other is 0, URDF's default";
        notes.add_of(NoteKind::Filled, text, &joint.name);
    }
    if least > most {
        let expected = format!("an end of at least `lower`, which is {least}");
        return Err(xml::refuse_value(limit, "upper", expected));
    }
    if least >= most {
        let text = "`lower` and `upper` are equal: the joint cannot move";
        notes.add_of(NoteKind::Doubtful, text, &joint.name);
    }
    Ok(Some([least, most]))
}

/// Reads a limit of speed or effort. Zero, -1, infinity and very large values mean "no limit".
fn largest(
    limit: Node<'_, '_>,
    name: &'static str,
    joint: &Joint,
    notes: &mut Notes,
) -> Result<Option<f64>, ImportError> {
    let Some(text) = limit.attribute(name) else { return Ok(None) };
    // Exporters write -1 where they know no limit.
    let is_none = |value: f64| value >= 0.0 || (value + 1.0).abs() <= 0.0;
    let value: Option<f64> = text.trim().parse().ok().filter(|value| is_none(*value));
    let value = value.ok_or_else(|| xml::refuse_value(limit, name, "a number of zero or more"))?;
    if value > 0.0 && value < PLACEHOLDER {
        return Ok(Some(value));
    }
    let text = format!("the limit {name} = {} means no limit: the rig has none there", text.trim());
    notes.add_of(NoteKind::LeftOut, text, &joint.name);
    Ok(None)
}

/// Number of joints from which one common value is suspicious.
const ALIKE_MIN: usize = 4;

/// Adds a note for each kind of limit (effort, speed) that is equal at all joints that have it, at least [`ALIKE_MIN`].
pub(super) fn doubt(joints: &mut [Joint], notes: &mut Notes) {
    let speed = |joint: &Joint| joint.speed_rad_s.or(joint.speed_m_s);
    let values: [(&str, Vec<f64>); 2] = [
        ("effort", joints.iter().filter_map(|joint| joint.effort).collect()),
        ("velocity", joints.iter().filter_map(speed).collect()),
    ];
    for (name, values) in values {
        let Some(first) = values.first().filter(|_| values.len() >= ALIKE_MIN) else { continue };
        if values.iter().all(|value| value.total_cmp(first).is_eq()) {
            let text = format!(
                "all {} joints have the limit {name} = {first}: look whether somebody measured it",
                values.len()
            );
            notes.add(NoteKind::Doubtful, text);
        }
    }
}
