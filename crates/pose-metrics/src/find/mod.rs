//! The nearest moments in a library of clips to a pose or a clip, under any of the measures of [`crate::spatial`].
//!
//! All poses are put on the query's skeleton, joints by their names: it is poses that are compared, not people. What
//! cannot be among the nearest is left out by lower bounds, never by approximation: see [`Search`].

mod joints;
mod library;
mod reference;
mod search;
mod table;

pub use joints::{Mismatch, same_joints};
pub use library::{Library, Query, ReadError, Shelved};
pub use reference::{At, Part, Reference, ReferenceError};
pub use search::{Found, Limits, Moment, Search, Work};
pub use table::{csv, json, text};
