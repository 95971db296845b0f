//! Reading and writing of consecutive bytes, little-endian.

use crc::{CRC_32_ISO_HDLC, Crc};
use sinew_core::glam::{Quat, Vec3};

use super::BoardRigError;

const CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);
const CRC_LEN: usize = 4;

/// Reads the bytes of a [`Writer`]. After the last byte it reads zeros; [`Self::check_length`] then reports the
/// error.
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    fn take<const K: usize>(&mut self) -> [u8; K] {
        let end = self.at.saturating_add(K);
        let field = self.bytes.get(self.at..end).and_then(|field| field.try_into().ok());
        self.at = end;
        field.unwrap_or([0; K])
    }

    pub(super) fn magic(&mut self) -> [u8; 4] {
        self.take()
    }

    pub(super) fn u16(&mut self) -> u16 {
        u16::from_le_bytes(self.take())
    }

    pub(super) fn f32(&mut self) -> f32 {
        f32::from_le_bytes(self.take())
    }

    pub(super) fn numbers<const K: usize>(&mut self) -> [f32; K] {
        [0.0; K].map(|_: f32| self.f32())
    }

    pub(super) fn vec3(&mut self) -> Vec3 {
        Vec3::from_array(self.numbers())
    }

    pub(super) fn quat(&mut self) -> Quat {
        Quat::from_array(self.numbers())
    }

    /// Checks the CRC, so that damaged bytes are refused before any of them is used.
    pub(super) fn check_crc(&self) -> Result<(), BoardRigError> {
        let found = self.bytes.len();
        let short = BoardRigError::Length { expected: CRC_LEN, found };
        let (content, stored) = self.bytes.split_last_chunk::<CRC_LEN>().ok_or(short)?;
        let (stored, computed) = (u32::from_le_bytes(*stored), CHECKSUM.checksum(content));
        if stored == computed { Ok(()) } else { Err(BoardRigError::Checksum { stored, computed }) }
    }

    /// Fails if more bytes were read than there are.
    pub(super) fn check_length(&self) -> Result<(), BoardRigError> {
        let (expected, found) = (self.at, self.bytes.len());
        if expected <= found { Ok(()) } else { Err(BoardRigError::Length { expected, found }) }
    }

    /// Fails if bytes other than the CRC follow the last byte that was read.
    pub(super) fn check_end(&self) -> Result<(), BoardRigError> {
        let (expected, found) = (self.at.saturating_add(CRC_LEN), self.bytes.len());
        if expected == found { Ok(()) } else { Err(BoardRigError::Length { expected, found }) }
    }
}

/// Writes bytes while there is room, and counts them even without room.
pub(super) struct Writer<'a> {
    bytes: &'a mut [u8],
    at: usize,
}

impl<'a> Writer<'a> {
    pub(super) fn new(bytes: &'a mut [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    pub(super) fn put(&mut self, field: &[u8]) {
        let end = self.at.saturating_add(field.len());
        if let Some(room) = self.bytes.get_mut(self.at..end) {
            room.copy_from_slice(field);
        }
        self.at = end;
    }

    pub(super) fn u16(&mut self, number: u16) {
        self.put(&number.to_le_bytes());
    }

    /// Writes a count. The capacities of boards keep it below 2^16.
    pub(super) fn count(&mut self, count: usize) {
        self.u16(u16::try_from(count).unwrap_or(u16::MAX));
    }

    pub(super) fn f32(&mut self, number: f32) {
        self.put(&number.to_le_bytes());
    }

    pub(super) fn numbers(&mut self, numbers: impl IntoIterator<Item = f32>) {
        for number in numbers {
            self.f32(number);
        }
    }

    /// Appends the CRC, and returns the number of bytes.
    pub(super) fn finish(mut self) -> Result<usize, BoardRigError> {
        let crc = self.bytes.get(..self.at).map_or(0, |content| CHECKSUM.checksum(content));
        self.put(&crc.to_le_bytes());
        let (expected, found) = (self.at, self.bytes.len());
        if expected <= found {
            Ok(expected)
        } else {
            Err(BoardRigError::Length { expected, found })
        }
    }
}
