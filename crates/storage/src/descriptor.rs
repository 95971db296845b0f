//! Description of an item: kind, schema, hash, rig, approver.

use core::fmt;

use heapless::String;
use sha2::{Digest, Sha256};
use thiserror::Error;

use crate::record::Head;

/// Length of a descriptor before the content, in bytes. It is a multiple of every usual granule.
pub(crate) const DESCRIPTOR_LEN: u32 = 96;
const NAME_LEN: usize = 60;

/// Kind of an item.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Settings of the controller, in the log.
    Settings,
    /// The compact form of a rig, in the log.
    Rig,
    /// A show, in a slot.
    Show,
}

impl Kind {
    pub(crate) fn code(self) -> u8 {
        match self {
            Self::Settings => 1,
            Self::Rig => 2,
            Self::Show => 3,
        }
    }

    fn of_code(code: u8) -> Option<Self> {
        [Self::Settings, Self::Rig, Self::Show].into_iter().find(|kind| kind.code() == code)
    }
}

/// A SHA-256 hash.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Hash(pub [u8; 32]);

impl Hash {
    /// Computes the hash of bytes. O(len).
    pub fn of(bytes: &[u8]) -> Self {
        Self::finish(Sha256::new_with_prefix(bytes))
    }

    pub(crate) fn finish(hasher: Sha256) -> Self {
        Self(hasher.finalize().into())
    }
}

impl fmt::Display for Hash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for Hash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// Name of an approver: 1 to 60 bytes of UTF-8, without control characters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Approver(String<NAME_LEN>);

/// An error in an approver's name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("an approver's name has 1 to 60 bytes and no control characters; this one has {len} bytes")]
pub struct ApproverError {
    /// Length of the name, in bytes.
    pub len: usize,
}

/// An error that prevents reading an intact item: its schema is not the expected one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("{kind:?} is of schema {found}; this firmware reads {expected}")]
pub struct SchemaError {
    /// Kind of the item.
    pub kind: Kind,
    /// Schema of the item.
    pub found: u16,
    /// Schema that was requested.
    pub expected: u16,
}

impl Approver {
    /// Validates a name.
    ///
    /// # Errors
    /// [`ApproverError`] if the name is empty, longer than 60 bytes, or has control characters.
    pub fn new(name: &str) -> Result<Self, ApproverError> {
        let refused = ApproverError { len: name.len() };
        if name.is_empty() || name.chars().any(char::is_control) {
            return Err(refused);
        }
        String::try_from(name).map(Self).map_err(|_| refused)
    }

    /// Returns the name.
    pub fn name(&self) -> &str {
        &self.0
    }
}

/// Description of an item, with its approver.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Descriptor {
    /// Kind of the item.
    pub kind: Kind,
    /// Schema version of the content.
    pub schema: u16,
    /// Length of the content, in bytes.
    pub len: u32,
    /// SHA-256 of the content.
    pub hash: Hash,
    /// CRC of the rig that the item belongs to, from the end of the rig's compact form; 0 for any rig.
    pub rig: u32,
    /// Name of the approver.
    pub approver: Approver,
}

impl Descriptor {
    /// Returns the descriptor of a complete content. O(len).
    pub fn of(kind: Kind, schema: u16, content: &[u8], rig: u32, approver: Approver) -> Self {
        let len = u32::try_from(content.len()).unwrap_or(u32::MAX);
        Self { kind, schema, len, hash: Hash::of(content), rig, approver }
    }

    /// Refuses content that this firmware would misinterpret.
    ///
    /// # Errors
    /// [`SchemaError`] with both schemas.
    pub fn check_schema(&self, expected: u16) -> Result<(), SchemaError> {
        let Self { kind, schema: found, .. } = *self;
        if found == expected { Ok(()) } else { Err(SchemaError { kind, found, expected }) }
    }

    pub(crate) fn head(&self) -> Head {
        let len = DESCRIPTOR_LEN.saturating_add(self.len);
        Head { kind: self.kind.code(), schema: self.schema, len }
    }

    /// Encodes hash, rig and name, padded with zeros.
    pub(crate) fn encode(&self) -> [u8; DESCRIPTOR_LEN as usize] {
        let mut raw = [0; DESCRIPTOR_LEN as usize];
        let fields = self.hash.0.into_iter().chain(self.rig.to_le_bytes());
        for (to, from) in raw.iter_mut().zip(fields.chain(self.approver.0.bytes())) {
            *to = from;
        }
        raw
    }

    /// Decodes a descriptor. Returns `None` if a record with this head and these first bytes is not a valid item.
    pub(crate) fn decode(head: Head, raw: &[u8; DESCRIPTOR_LEN as usize]) -> Option<Self> {
        let (hash, rest) = raw.split_first_chunk::<32>()?;
        let (rig, name) = rest.split_first_chunk::<4>()?;
        let end = name.iter().position(|byte| *byte == 0).unwrap_or(name.len());
        let name = core::str::from_utf8(name.get(..end)?).ok()?;
        let descriptor = Self {
            kind: Kind::of_code(head.kind)?,
            schema: head.schema,
            len: head.len.checked_sub(DESCRIPTOR_LEN)?,
            hash: Hash(*hash),
            rig: u32::from_le_bytes(*rig),
            approver: Approver::new(name).ok()?,
        };
        (descriptor.encode() == *raw).then_some(descriptor)
    }
}
