//! Finds the moments in a library of clips that are nearest to a pose or a clip, with any of the measures of
//! [`crate::spatial`].
//!
//! All poses are converted to the query's skeleton, joints matched by name: the comparison is between poses, not
//! between bodies. Moments that cannot be among the nearest are skipped by lower bounds, never by approximation:
//! see [`Search`].

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
