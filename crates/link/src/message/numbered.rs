//! Numbered messages.

use serde::{Deserialize, Serialize};

/// An item of a session, with its number.
///
/// Numbers start at 0 in each session, rise by one, and wrap from 65535 to 0. Commands and streams are numbered
/// separately.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Numbered<T> {
    /// Session number from the controller's [`Welcome`](super::Welcome).
    pub session: u16,
    /// Number of the item.
    pub seq: u16,
    /// The numbered item.
    pub item: T,
}
