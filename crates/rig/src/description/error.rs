//! Why a description cannot be a rig, and where that stands.

use std::fmt;

/// Where a value stands in a rig's file: `joint[2].axis`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Path(pub Vec<Step>);

/// One step of a [`Path`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
#[error("{path} of {item}: expected {expected}, found {found}")]
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
