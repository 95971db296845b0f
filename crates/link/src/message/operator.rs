//! Operators at a host.

use serde::{Deserialize, Serialize};

/// An operator at a terminal, identified by a number that the host chooses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Operator(pub u8);
