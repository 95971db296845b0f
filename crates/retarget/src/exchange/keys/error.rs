//! Reasons why a table is not a motion of a rig.

use crate::feasibility::MotionError;

/// The reason why a table is not a valid motion of a rig.
#[derive(Debug, thiserror::Error)]
pub enum KeyError {
    /// The text is not CSV.
    #[error(transparent)]
    Csv(#[from] csv::Error),
    /// No column is the time.
    #[error("the header has no column `time` (s) or `time_ms`; its columns are {0}")]
    NoTime(String),
    /// A column does not belong to the rig.
    #[error(
        "column {number} of the header, `{found}`: expected `time`, `easing` or one of {expected}"
    )]
    Column {
        /// Number of the column, from 1.
        number: usize,
        /// Name of the column.
        found: String,
        /// Names of the valid columns.
        expected: String,
    },
    /// A column has no unit.
    #[error("column {number} of the header, `{name}`: it has no unit: name it {repairs}")]
    NoUnit {
        /// Number of the column, from 1.
        number: usize,
        /// Name of the column, which is that of a joint.
        name: String,
        /// Names with a unit.
        repairs: String,
    },
    /// A column has the unit of another quantity.
    #[error(
        "column {number} of the header, `{found}`: joint `{name}` is not measured in {unit}: name it {repairs}"
    )]
    WrongUnit {
        /// Number of the column, from 1.
        number: usize,
        /// Name of the column.
        found: String,
        /// Name without unit.
        name: String,
        /// The unit that was found.
        unit: &'static str,
        /// Valid names.
        repairs: String,
    },
    /// A coordinate has two columns.
    #[error("`{0}` has two columns")]
    Twice(String),
    /// A column has no key.
    #[error("column `{0}`: it has no value in any row")]
    Empty(String),
    /// A ball joint does not have all four numbers.
    #[error(
        "line {line}, joint `{joint}`: expected all of its four columns x, y, z, w in each row that has one of them"
    )]
    PartOfBall {
        /// Line of the file.
        line: u64,
        /// Name of the joint.
        joint: String,
    },
    /// A field is not a number.
    #[error(
        "line {line}, column `{column}`, {what}: expected a number from -1e6 to 1e6, found `{found}`"
    )]
    Number {
        /// Line of the file.
        line: u64,
        /// Name of the column.
        column: String,
        /// Joint and unit.
        what: String,
        /// Text that was found.
        found: String,
    },
    /// A word is not an easing.
    #[error(
        "line {line}, column `{column}`: expected step, linear, ease in, ease out, ease both or cubic, found `{found}`"
    )]
    Easing {
        /// Line of the file.
        line: u64,
        /// Name of the column.
        column: String,
        /// Text that was found.
        found: String,
    },
    /// A time is not after the previous time.
    #[error("line {line}, column `time`: expected a time after {before} s, found {found} s")]
    Order {
        /// Line of the file.
        line: u64,
        /// Time of the previous row, s.
        before: f64,
        /// Time that was found, s.
        found: f64,
    },
    /// The motion is too long.
    #[error("the last time is {0} s after the first: expected 7200 s at most")]
    TooLong(f64),
    /// The rig's base travels. No table is read for it, because an exported table has the pose of the base in another
    /// world.
    #[error("the rig's base travels (`root_x` ..): hold it with `--base stand`")]
    Travels,
    /// The numbers are not a valid motion.
    #[error(transparent)]
    Motion(#[from] MotionError),
}
