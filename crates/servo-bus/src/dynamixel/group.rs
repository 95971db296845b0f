//! Lists inside instructions for several servos: written one servo at a time, and read the same way.

use super::frame::{BROADCAST, FrameWriter, MAX_ID};
use super::instruction::Instruction;
use crate::EncodeError;

/// Writes a sync write, servo by servo.
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

    /// Adds a servo. Data of another length, or an id that no servo has, spoils the packet.
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

    /// Ends the packet, and says how long it is.
    ///
    /// # Errors
    /// [`EncodeError`] if it does not fit, or a servo was wrong.
    pub fn finish(self) -> Result<usize, EncodeError> {
        self.wrong.map_or_else(|| self.frame.finish(), Err)
    }
}

/// Writes a bulk write, servo by servo.
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

    /// Adds a servo.
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

    /// Ends the packet, and says how long it is.
    ///
    /// # Errors
    /// [`EncodeError`] if it does not fit, or a servo was wrong.
    pub fn finish(self) -> Result<usize, EncodeError> {
        self.wrong.map_or_else(|| self.frame.finish(), Err)
    }
}

/// What a bulk read asks of one servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BulkEntry {
    /// The servo.
    pub id: u8,
    /// First address.
    pub address: u16,
    /// How many bytes.
    pub length: u16,
}

impl BulkEntry {
    /// As it stands in the packet.
    pub const fn bytes(self) -> [u8; 5] {
        let ([a, b], [c, d]) = (self.address.to_le_bytes(), self.length.to_le_bytes());
        [self.id, a, b, c, d]
    }
}

/// The entries of a bulk read; a rest of fewer than 5 bytes is left out.
pub fn bulk_entries(list: &[u8]) -> impl Iterator<Item = BulkEntry> + Clone {
    let (entries, _) = list.as_chunks::<5>();
    entries.iter().map(|&[id, a, b, c, d]| BulkEntry {
        id,
        address: u16::from_le_bytes([a, b]),
        length: u16::from_le_bytes([c, d]),
    })
}

/// The servos of a sync write and their bytes; a rest that is too short is left out.
pub fn sync_blocks(blocks: &[u8], length: u16) -> impl Iterator<Item = (u8, &[u8])> {
    let each = usize::from(length).saturating_add(1);
    blocks.chunks_exact(each).filter_map(|block| block.split_first().map(|(id, data)| (*id, data)))
}

/// The servos of a bulk write, with address and bytes; stops where the list is cut short.
pub fn bulk_blocks(mut list: &[u8]) -> impl Iterator<Item = (u8, u16, &[u8])> {
    core::iter::from_fn(move || {
        let (&[id, a, b, c, d], rest) = list.split_first_chunk::<5>()?;
        let (data, rest) = rest.split_at_checked(usize::from(u16::from_le_bytes([c, d])))?;
        list = rest;
        Some((id, u16::from_le_bytes([a, b]), data))
    })
}
