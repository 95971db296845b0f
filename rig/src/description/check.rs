//! What of a description cannot be.

use std::collections::BTreeSet;
use std::fmt;

use super::{Description, Joint, JointType};

/// Where a value stands in a rig's file: `joint[2].axis`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Path(pub Vec<Step>);

/// One step of a [`Path`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Step {
    /// A key of a table, as in the file.
    Key(&'static str),
    /// A place in an array, from 0.
    Index(usize),
}

impl fmt::Display for Path {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, step) in self.0.iter().enumerate() {
            match step {
                Step::Key(key) if place == 0 => f.write_str(key)?,
                Step::Key(key) => write!(f, ".{key}")?,
                Step::Index(index) => write!(f, "[{index}]")?,
            }
        }
        Ok(())
    }
}

/// Why a description cannot be a rig.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{path}: {item}: expected {expected}, found {found}")]
pub struct DescriptionError {
    /// Where the value stands.
    pub path: Path,
    /// The part that it belongs to, by name: `joint "elbow"`.
    pub item: String,
    /// What would be right.
    pub expected: String,
    /// What is there.
    pub found: String,
}

/// Refuses one value.
pub(crate) fn refuse(
    path: &[Step],
    item: impl Into<String>,
    expected: impl Into<String>,
    found: impl fmt::Display,
) -> DescriptionError {
    DescriptionError {
        path: Path(path.to_vec()),
        item: item.into(),
        expected: expected.into(),
        found: found.to_string(),
    }
}
