//! Stored items of a controller, and their upload.

use heapless::{String, Vec};
use serde::{Deserialize, Serialize};

use crate::finite;

/// Maximum length of a name in a setting, in bytes.
pub const NAME_MAX: usize = 24;

/// Maximum length of an approver's name, in bytes.
pub const APPROVER_MAX: usize = 60;

/// Maximum length of a block, in bytes: a page of common flash chips.
pub const BLOCK_MAX: usize = 256;

/// A name in UTF-8.
pub type Name = String<NAME_MAX>;

/// Name of the person who approved an item, in UTF-8.
pub type Approver = String<APPROVER_MAX>;

/// The value of a setting.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Value {
    /// A flag: yes or no.
    Flag(bool),
    /// A count, or an index into a list.
    Count(u32),
    /// A number, in SI units.
    Number(#[serde(with = "finite")] f32),
    /// A name, as text.
    Text(Name),
}

/// Kind of a stored item.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Kind {
    /// All settings of the controller.
    Settings,
    /// A rig in its compact form.
    Rig,
    /// A show.
    Show,
}

/// Location of a stored item.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Location {
    /// The settings in use.
    Settings,
    /// The rig in use.
    Rig,
    /// A slot for a show.
    Show {
        /// Index of the slot.
        slot: u8,
    },
}

/// Description of an item, stored or to be stored, with the name of its approver. A show goes into a free slot.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Item {
    /// Kind of the item.
    pub kind: Kind,
    /// Version of the content's meaning.
    pub schema: u16,
    /// Length of the content, in bytes.
    pub length: u32,
    /// SHA-256 of the content.
    pub hash: [u8; 32],
    /// Rig that the item belongs to: the CRC at the end of the rig's compact form; 0 for any rig.
    pub rig: u32,
    /// Name of the approver: at least one byte, and no control characters, or the item is refused.
    pub approver: Approver,
}

/// A block of an upload.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Block {
    /// Offset of the block in the item, in bytes.
    pub offset: u32,
    /// Content of the block.
    pub bytes: Vec<u8, BLOCK_MAX>,
}
