//! The pose of a shape: `{ jaw = 25, lid = -5 }`, in degrees, or in mm for joints that slide.

use toml::de::DeValue;

use super::error::UnlocatedError;
use super::item::{Item, in_file};
use super::value::Value;
use crate::description::{Joint, JointType};

/// Positions of joints, in deg or mm.
#[derive(PartialEq)]
pub(super) struct Pose(Vec<(String, f64)>);

impl Pose {
    /// Converts positions from rad and m. An unknown joint is treated as a joint that turns.
    pub(super) fn of_si(pose: &[(String, f64)], joints: &[Joint]) -> Self {
        let of = |(name, position): &(String, f64)| {
            let in_file = if slides(name, joints) {
                in_file(&[1000.0 * position], false)
            } else {
                in_file(&[*position], true)
            };
            (name.clone(), in_file.into_iter().next().unwrap_or_default())
        };
        Self(pose.iter().map(of).collect())
    }

    /// Converts positions to rad and m.
    pub(super) fn into_si(self, joints: &[Joint]) -> Vec<(String, f64)> {
        let of = |(name, position): (String, f64)| {
            let slides = slides(&name, joints);
            (name, if slides { position / 1000.0 } else { position.to_radians() })
        };
        self.0.into_iter().map(of).collect()
    }
}

fn slides(name: &str, joints: &[Joint]) -> bool {
    let joint = joints.iter().find(|joint| joint.name == name);
    joint.is_some_and(|joint| joint.kind == JointType::Prismatic)
}

impl Value for Pose {
    const EXPECTED: &'static str =
        "joints with their positions in deg (mm of slides), { jaw = -20, .. }";

    fn read(item: &Item<'_>) -> Result<Self, UnlocatedError> {
        let DeValue::Table(table) = item.value() else { return Err(item.wrong(Self::EXPECTED)) };
        let mut positions = Vec::new();
        // Entries are read in the order of the file.
        let mut entries: Vec<_> = table.iter().collect();
        entries.sort_by_key(|(key, _)| key.span().start);
        for (key, value) in entries {
            let name: &str = key.get_ref();
            let number = Item::new(value, format!("{}.{name}", item.path()), false).number()?;
            positions.push((name.to_owned(), number));
        }
        Ok(Self(positions))
    }

    fn text(&self, _: bool) -> String {
        let entry = |(name, position): &(String, f64)| {
            let is_bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
            let key = if !name.is_empty() && name.chars().all(is_bare) {
                name.clone()
            } else {
                quoted(name)
            };
            format!("{key} = {}", position.text(false))
        };
        match &self.0[..] {
            [] => "{}".to_owned(),
            all => format!("{{ {} }}", all.iter().map(entry).collect::<Vec<_>>().join(", ")),
        }
    }
}

/// Returns a name as a quoted key. Keys have no strings of several lines, which a value may have.
fn quoted(name: &str) -> String {
    let mut key = "\"".to_owned();
    for letter in name.chars() {
        match letter {
            '"' | '\\' => key.extend(['\\', letter]),
            _ if letter.is_control() => key.extend(format!("\\u{:04X}", u32::from(letter)).chars()),
            _ => key.push(letter),
        }
    }
    key + "\""
}
