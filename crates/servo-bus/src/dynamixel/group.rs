//! Writes and reads the lists inside instructions for several servos, one servo at a time.

use super::frame::{BROADCAST, FrameWriter, MAX_ID};
use super::instruction::Instruction;
use crate::EncodeError;

/// A writer of a sync write instruction, servo by servo.
///
/// ```
/// use sinew_servo_bus::dynamixel::group::SyncWriter;
/// let mut out = [0; 32];
/// let mut packet = SyncWriter::new(&mut out, 116, 4);
/// packet.push(1, &150_u32.to_le_bytes());
/// packet.push(2, &170_u32.to_le_bytes());
/// assert_eq!(packet.finish()?, 24);
/// # Ok::<(), sinew_servo_bus::EncodeError>(())
/// ```
pub struct SyncWriter<'a> {
    frame: FrameWriter<'a>,
    length: u16,
    wrong: Option<EncodeError>,
}

impl<'a> SyncWriter<'a> {
    /// Begins a sync write of `length` bytes for each servo.
    pub fn new(out: &'a mut [u8], address: u16, length: u16) -> Self {
        let code = Instruction::SyncWrite { address, length, blocks: &[] }.code();
        let mut frame = FrameWriter::new(out, BROADCAST, code);
        frame.push_u16(address);
        frame.push_u16(length);
        Self { frame, length, wrong: None }
    }

    /// Appends a servo. If the data have another length, or no servo can have the id, [`Self::finish`] fails.
    pub fn push(&mut self, id: u8, data: &[u8]) {
        if id > MAX_ID {
            self.wrong = Some(EncodeError::Id(id));
        }
        if data.len() != usize::from(self.length) {
            self.wrong = Some(EncodeError::Length);
        }
        self.frame.push(id);
        self.frame.extend(data);
    }

    /// Ends the packet and returns its length.
    ///
    /// # Errors
    /// [`EncodeError`] if the packet does not fit, or a servo was refused.
    pub fn finish(self) -> Result<usize, EncodeError> {
        self.wrong.map_or_else(|| self.frame.finish(), Err)
    }
}

/// A writer of a bulk write instruction, servo by servo.
pub struct BulkWriter<'a> {
    frame: FrameWriter<'a>,
    wrong: Option<EncodeError>,
}

impl<'a> BulkWriter<'a> {
    /// Begins a bulk write.
    pub fn new(out: &'a mut [u8]) -> Self {
        Self {
            frame: FrameWriter::new(out, BROADCAST, Instruction::BulkWrite(&[]).code()),
            wrong: None,
        }
    }

    /// Appends a servo. If no servo can have the id, or the data are too long, [`Self::finish`] fails.
    pub fn push(&mut self, id: u8, address: u16, data: &[u8]) {
        if id > MAX_ID {
            self.wrong = Some(EncodeError::Id(id));
        }
        let Ok(length) = u16::try_from(data.len()) else {
            self.wrong = Some(EncodeError::Length);
            return;
        };
        self.frame.push(id);
        self.frame.push_u16(address);
        self.frame.push_u16(length);
        self.frame.extend(data);
    }

    /// Ends the packet and returns its length.
    ///
    /// # Errors
    /// [`EncodeError`] if the packet does not fit, or a servo was refused.
    pub fn finish(self) -> Result<usize, EncodeError> {
        self.wrong.map_or_else(|| self.frame.finish(), Err)
    }
}

/// The part of a bulk read for one servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BulkEntry {
    /// Id of the servo.
    pub id: u8,
    /// First address to read.
    pub address: u16,
    /// Number of bytes to read.
    pub length: u16,
}

impl BulkEntry {
    /// Returns the entry as bytes of the packet.
    pub const fn bytes(self) -> [u8; 5] {
        let ([a, b], [c, d]) = (self.address.to_le_bytes(), self.length.to_le_bytes());
        [self.id, a, b, c, d]
    }
}

/// Returns the entries of a bulk read. Ignores an incomplete entry (fewer than 5 bytes) at the end.
pub fn bulk_entries(list: &[u8]) -> impl Iterator<Item = BulkEntry> + Clone {
    let (entries, _) = list.as_chunks::<5>();
    entries.iter().map(|&[id, a, b, c, d]| BulkEntry {
        id,
        address: u16::from_le_bytes([a, b]),
        length: u16::from_le_bytes([c, d]),
    })
}

/// Returns id and data of each servo in a sync write. Ignores an incomplete block at the end.
pub fn sync_blocks(blocks: &[u8], length: u16) -> impl Iterator<Item = (u8, &[u8])> {
    let each = usize::from(length).saturating_add(1);
    blocks.chunks_exact(each).filter_map(|block| block.split_first().map(|(id, data)| (*id, data)))
}

/// Returns id, address and data of each servo in a bulk write. Stops at an incomplete block.
pub fn bulk_blocks(mut list: &[u8]) -> impl Iterator<Item = (u8, u16, &[u8])> {
    core::iter::from_fn(move || {
        let (&[id, a, b, c, d], rest) = list.split_first_chunk::<5>()?;
        let (data, rest) = rest.split_at_checked(usize::from(u16::from_le_bytes([c, d])))?;
        list = rest;
        Some((id, u16::from_le_bytes([a, b]), data))
    })
}
