//! A record: the content of a slot, and the element of a log.
//!
//! | bytes | content |
//! | --- | --- |
//! | 2 | magic `SR` |
//! | u8 | version of this format, 1 |
//! | u8 | kind |
//! | u16 | schema version of the payload |
//! | u16 | 0 |
//! | u32 | length of the payload |
//! | u32 | CRC-32 (ISO-HDLC) of the bytes before it |
//! | | the payload |
//! | u32 | the seal, written last: CRC-32 of everything before it, without padding |
//!
//! Little-endian. Each of the three parts starts at a multiple of the flash's granule; the gaps are FF. The seal is
//! never FF FF FF FF (not yet written) or 0 (given up).

use embedded_storage::nor_flash::NorFlash;

use crate::error::Error;
use crate::flash::{CHECKSUM, checksum, fill, padded, read};

pub(crate) const HEAD_LEN: u32 = 16;
const SEAL_LEN: u32 = 4;
const VERSION: u8 = 1;
const OPEN: u32 = u32::MAX;
const GIVEN_UP: u32 = 0;

/// Description of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Head {
    pub(crate) kind: u8,
    pub(crate) schema: u16,
    /// Length of the payload, in bytes.
    pub(crate) len: u32,
}

impl Head {
    pub(crate) fn encode(self) -> [u8; 16] {
        let [s0, s1] = self.schema.to_le_bytes();
        let [l0, l1, l2, l3] = self.len.to_le_bytes();
        let content = [b'S', b'R', VERSION, self.kind, s0, s1, 0, 0, l0, l1, l2, l3];
        let [c0, c1, c2, c3] = CHECKSUM.checksum(&content).to_le_bytes();
        [b'S', b'R', VERSION, self.kind, s0, s1, 0, 0, l0, l1, l2, l3, c0, c1, c2, c3]
    }

    fn decode(raw: [u8; 16]) -> Option<Self> {
        let [_, _, _, kind, s0, s1, _, _, l0, l1, l2, l3, ..] = raw;
        let head = Self {
            kind,
            schema: u16::from_le_bytes([s0, s1]),
            len: u32::from_le_bytes([l0, l1, l2, l3]),
        };
        (head.encode() == raw).then_some(head)
    }
}

/// A record and its address.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Record {
    pub(crate) at: u32,
    pub(crate) head: Head,
}

/// Content of the flash at an address.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RecordStatus {
    /// Erased, or the end of the area.
    Free,
    /// Not a valid head: the length is unknown.
    Torn,
    /// A record, sealed or not.
    Record(Record),
}

/// State of a record's seal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Seal {
    /// Not written yet.
    Open,
    /// Correct: the record is intact.
    Good,
    /// Given up: the record will never be completed.
    GivenUp,
    /// Wrong: the record is damaged.
    Bad,
}

impl Record {
    /// Returns the length of a record with a payload of this length, in bytes.
    pub(crate) fn room<F: NorFlash>(len: u32) -> u32 {
        let (head, seal) = (padded::<F>(HEAD_LEN), padded::<F>(SEAL_LEN));
        head.saturating_add(padded::<F>(len)).saturating_add(seal)
    }

    pub(crate) fn payload_at<F: NorFlash>(&self) -> u32 {
        self.at.saturating_add(padded::<F>(HEAD_LEN))
    }

    fn seal_at<F: NorFlash>(&self) -> u32 {
        self.payload_at::<F>().saturating_add(padded::<F>(self.head.len))
    }

    /// Returns the address for the next record.
    pub(crate) fn end<F: NorFlash>(&self) -> u32 {
        self.at.saturating_add(Self::room::<F>(self.head.len))
    }

    /// Returns the status of an address, in an area that ends at `end`.
    pub(crate) fn look<F: NorFlash>(
        flash: &mut F,
        at: u32,
        end: u32,
    ) -> Result<RecordStatus, Error<F::Error>> {
        if at.saturating_add(Self::room::<F>(0)) > end {
            return Ok(RecordStatus::Free);
        }
        let mut raw = [0; 16];
        read(flash, at, &mut raw)?;
        if raw == [0xFF; 16] {
            return Ok(RecordStatus::Free);
        }
        let record = Head::decode(raw).map(|head| Self { at, head });
        Ok(match record {
            Some(record) if record.end::<F>() <= end => RecordStatus::Record(record),
            _ => RecordStatus::Torn,
        })
    }

    /// Writes a head. Payload and seal must follow.
    pub(crate) fn begin<F: NorFlash>(
        flash: &mut F,
        at: u32,
        head: Head,
    ) -> Result<Self, Error<F::Error>> {
        fill(flash, at, &head.encode())?;
        Ok(Self { at, head })
    }

    /// Seals the payload that is in flash. O(len).
    pub(crate) fn seal<F: NorFlash>(&self, flash: &mut F) -> Result<(), Error<F::Error>> {
        let seal = self.computed_seal(flash)?;
        fill(flash, self.seal_at::<F>(), &seal.to_le_bytes())
    }

    /// Marks the record as given up.
    pub(crate) fn give_up<F: NorFlash>(&self, flash: &mut F) -> Result<(), Error<F::Error>> {
        fill(flash, self.seal_at::<F>(), &GIVEN_UP.to_le_bytes())
    }

    /// Returns the state of the seal. O(len) if it is written.
    pub(crate) fn state<F: NorFlash>(&self, flash: &mut F) -> Result<Seal, Error<F::Error>> {
        let mut raw = [0; 4];
        read(flash, self.seal_at::<F>(), &mut raw)?;
        Ok(match u32::from_le_bytes(raw) {
            OPEN => Seal::Open,
            GIVEN_UP => Seal::GivenUp,
            seal if seal == self.computed_seal(flash)? => Seal::Good,
            _ => Seal::Bad,
        })
    }

    fn computed_seal<F: NorFlash>(&self, flash: &mut F) -> Result<u32, Error<F::Error>> {
        let mut digest = CHECKSUM.digest();
        checksum(flash, self.at, HEAD_LEN, &mut digest)?;
        checksum(flash, self.payload_at::<F>(), self.head.len, &mut digest)?;
        Ok(match digest.finalize() {
            OPEN => OPEN.wrapping_sub(1),
            GIVEN_UP => GIVEN_UP.wrapping_add(1),
            seal => seal,
        })
    }
}
