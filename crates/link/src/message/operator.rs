//! Operators at a host.

use serde::{Deserialize, Serialize};

/// An operator at a terminal, by a number of the host's choice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Operator(pub u8);
