//! Values that stand for "none" in files of robots: writers have no other word for a limit that is not there.

use roxmltree::Node;

use super::error::ImportError;
use super::note::{NoteKind, Notes};
use super::xml;

/// Size from which a range (rad, m or degrees), a force (N m, N) or a damping means "none", because no robot has it.
pub(super) const LARGEST: f64 = 1e6;

/// Damping, N m s/rad or N s/m, from which the value is doubtful: at 1 rad/s it takes more than any servo gives.
const DAMPING_DOUBTFUL: f64 = 1000.0;

/// Returns whether an end of a range means that there is no end.
pub(super) fn is_endless(end: f64) -> bool {
    end.abs() >= LARGEST
}

/// Returns the range, or `None` with a note if an end of it means "none". The whole range is left out then, because
/// a joint has either both ends or neither.
pub(super) fn range(
    name: &str,
    range: [f64; 2],
    item: &str,
    notes: &mut Notes,
) -> Option<[f64; 2]> {
    if !range.into_iter().any(is_endless) {
        return Some(range);
    }
    let [least, most] = range.map(short);
    let text = format!("{name} {least} to {most} stands for none: the rig has none there");
    notes.add_of(NoteKind::LeftOut, text, item);
    None
}

/// Reads a damping; zero without the attribute. A damping that no joint can have is left out.
pub(super) fn damping(
    node: Node<'_, '_>,
    name: &str,
    count: usize,
    item: &str,
    notes: &mut Notes,
) -> Result<f64, ImportError> {
    let value = xml::any_numbers(node, name, count)?.and_then(|numbers| numbers.first().copied());
    let value = value.unwrap_or(0.0);
    if value < 0.0 {
        return Err(xml::refuse_value(node, name, "a number of zero or more"));
    }
    if value >= LARGEST {
        let text = format!(
            "{name} = {}, which nothing has: a joint that the file locks by it is free in the rig",
            short(value)
        );
        notes.add_of(NoteKind::LeftOut, text, item);
        return Ok(0.0);
    }
    if value >= DAMPING_DOUBTFUL {
        let text = format!("{name} = {}: no servo moves a joint against it", short(value));
        notes.add_of(NoteKind::Doubtful, text, item);
    }
    Ok(value)
}

/// Formats a number with an exponent if it is large.
pub(super) fn short(value: f64) -> String {
    if value.abs() < LARGEST { value.to_string() } else { format!("{value:e}") }
}
