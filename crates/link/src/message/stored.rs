//! What a controller stores, and how it gets there.

use heapless::{String, Vec};
use serde::{Deserialize, Serialize};

use crate::finite;

/// The longest name in a setting, in bytes.
pub const NAME_MAX: usize = 24;

/// The longest name of who approved something, in bytes.
pub const APPROVER_MAX: usize = 60;

/// The most bytes of a block: a page of common flash chips.
pub const BLOCK_MAX: usize = 256;

/// A name in UTF-8.
pub type Name = String<NAME_MAX>;

/// The name of who approved something, in UTF-8.
pub type Approver = String<APPROVER_MAX>;

/// The value of a setting.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Value {
    /// Yes or no.
    Flag(bool),
    /// A count, or one of a list.
    Count(u32),
    /// A number, in SI units.
    Number(#[serde(with = "finite")] f32),
    /// A name.
    Text(Name),
}

/// What something stored is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Kind {
    /// All settings of the controller.
    Settings,
    /// A rig in its compact form.
    Rig,
    /// A show.
    Show,
}

/// Where something is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Location {
    /// The settings in use.
    Settings,
    /// The rig in use.
    Rig,
    /// The slot of a show.
    Show {
        /// Which one.
        slot: u8,
    },
}

/// Something to be stored, or stored: what it is, and who stands for it. A show goes into a free slot.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Item {
    /// Its kind.
    pub kind: Kind,
    /// Version of what the content means.
    pub schema: u16,
    /// Bytes of content.
    pub length: u32,
    /// SHA-256 of the content.
    pub hash: [u8; 32],
    /// The rig it belongs to: the CRC at the end of the rig's compact form; 0 for any.
    pub rig: u32,
    /// Who approved it: at least one byte, and no control characters, or it is refused.
    pub approver: Approver,
}

/// Bytes of an upload.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Block {
    /// Where they are in the whole.
    pub offset: u32,
    /// The bytes.
    pub bytes: Vec<u8, BLOCK_MAX>,
}
