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
pub use library::{Library, LibraryClip, Query, ReadError};
pub use reference::{ClipPart, ClipTime, Reference, ReferenceError};
pub use search::{Found, Limits, Moment, Search, SearchStats};
pub use table::{csv, json, text};
