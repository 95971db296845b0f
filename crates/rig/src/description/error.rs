//! The reason why a description is invalid, and the place of the invalid value.

use std::fmt;

/// Path of a value in a rig's file, such as `joint[2].axis`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Path(pub Vec<Step>);

/// One step of a [`Path`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// Key of a table, as in the file.
    Key(&'static str),
    /// Index in an array, from 0.
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

/// The reason why a description is invalid.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{path} of {item}: expected {expected}, found {found}")]
pub struct DescriptionError {
    /// Path of the value.
    pub path: Path,
    /// Part that the value belongs to, by name: `joint "elbow"`.
    pub item: String,
    /// Description of a valid value.
    pub expected: String,
    /// Value that was found.
    pub found: String,
}
