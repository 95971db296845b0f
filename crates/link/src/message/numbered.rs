//! What carries a number.

use serde::{Deserialize, Serialize};

/// Something of a session, with its number.
///
/// Numbers begin at 0 in each session, and rise by one, 65535 to 0 again. Commands and streams have their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Numbered<T> {
    /// The session that the controller gave in its [`Welcome`](super::Welcome).
    pub session: u16,
    /// The number.
    pub seq: u16,
    /// What has it.
    pub item: T,
}
