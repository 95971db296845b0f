//! The log: consecutive records in a sector, until `compact` copies them to the next sector.
//!
//! | bytes | header of a sector, written when all its records are there |
//! | --- | --- |
//! | 4 | magic `SNWL` |
//! | u32 | version of this format, 1 |
//! | u32 | generation: the sector with the highest generation is active |
//! | u32 | CRC-32 (ISO-HDLC) of the bytes before it |

use embedded_storage::nor_flash::NorFlash;

use crate::area::Area;
use crate::error::Error;
use crate::flash::{CHECKSUM, all_ones, fill, padded, read};
use crate::record::{HEAD_LEN, Head, Record, RecordStatus, Seal};

const MAGIC: [u8; 4] = *b"SNWL";
const VERSION: u32 = 1;

/// Area and state of the log.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Log {
    pub(crate) area: Area,
    pub(crate) active: Option<Active>,
    /// Whether the sectors start erased: there never was a log.
    pub(crate) is_new: bool,
}

/// The active sector.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Active {
    pub(crate) sector: u32,
    pub(crate) generation: u32,
    /// Address for the next record.
    pub(crate) end: u32,
    /// Whether an invalid record follows, because of a power cut.
    pub(crate) is_torn: bool,
    /// Whether more bytes follow than a power cut leaves: unreachable records.
    pub(crate) is_cut_short: bool,
}

impl Log {
    /// Finds the active sector and its end. O(sector).
    pub(crate) fn open<F: NorFlash>(flash: &mut F, area: Area) -> Result<Self, Error<F::Error>> {
        let mut log = Self { area, active: None, is_new: true };
        for sector in 0..area.sectors {
            let mut raw = [0; 16];
            read(flash, log.start(sector), &mut raw)?;
            log.is_new &= all_ones(&raw);
            let Some(generation) = decode(raw) else { continue };
            if log.active.is_none_or(|active| active.generation < generation) {
                let end = log.first_in::<F>(sector);
                log.active =
                    Some(Active { sector, generation, end, is_torn: false, is_cut_short: false });
            }
        }
        if let Some(mut active) = log.active {
            let sector_end = log.start(active.sector.saturating_add(1));
            while let RecordStatus::Record(record) = Record::look(flash, active.end, sector_end)? {
                active.end = record.end::<F>();
            }
            active.look_behind(flash, sector_end)?;
            log.active = Some(active);
        }
        Ok(log)
    }

    /// Returns the start address of a sector.
    pub(crate) fn start(&self, sector: u32) -> u32 {
        self.area.start.saturating_add(self.area.sector_len.saturating_mul(sector))
    }

    /// Returns the address of the first record of a sector.
    pub(crate) fn first_in<F: NorFlash>(&self, sector: u32) -> u32 {
        self.start(sector).saturating_add(padded::<F>(HEAD_LEN))
    }

    /// Returns the record at an address; `None` at the end. Start with `at: None`, and continue with the end of each
    /// record.
    pub(crate) fn next<F: NorFlash>(
        &self,
        flash: &mut F,
        at: Option<u32>,
    ) -> Result<Option<Record>, Error<F::Error>> {
        let Some(active) = self.active else { return Ok(None) };
        let at = at.unwrap_or(self.first_in::<F>(active.sector));
        Ok(match Record::look(flash, at, active.end)? {
            RecordStatus::Record(record) => Some(record),
            RecordStatus::Free | RecordStatus::Torn => None,
        })
    }

    /// Returns the last record that `accept` accepts. O(sector), times the cost of `accept`.
    pub(crate) fn newest<F: NorFlash>(
        &self,
        flash: &mut F,
        mut accept: impl FnMut(&mut F, &Record) -> Result<bool, Error<F::Error>>,
    ) -> Result<Option<Record>, Error<F::Error>> {
        let (mut newest, mut at) = (None, None);
        while let Some(record) = self.next(flash, at)? {
            at = Some(record.end::<F>());
            if accept(flash, &record)? {
                newest = Some(record);
            }
        }
        Ok(newest)
    }

    /// Returns the last intact record of a kind.
    pub(crate) fn newest_of<F: NorFlash>(
        &self,
        flash: &mut F,
        kind: u8,
    ) -> Result<Option<Record>, Error<F::Error>> {
        self.newest(flash, |flash, record| {
            Ok(record.head.kind == kind && record.state(flash)? == Seal::Good)
        })
    }

    /// Returns the number of bytes that may be appended; 0 if the log must be compacted first.
    pub(crate) fn free(&self) -> u32 {
        self.active.filter(|active| !active.is_torn).map_or(0, |active| {
            self.start(active.sector.saturating_add(1)).saturating_sub(active.end)
        })
    }

    /// Appends a head. Payload and seal must follow.
    pub(crate) fn begin<F: NorFlash>(
        &mut self,
        flash: &mut F,
        head: Head,
    ) -> Result<Record, Error<F::Error>> {
        let (needed, free) = (Record::room::<F>(head.len), self.free());
        let active = self.active.as_mut().filter(|active| !active.is_torn).ok_or(Error::Untidy)?;
        if needed > free {
            return Err(Error::Full { needed, free });
        }
        // Until its head is complete, the length of the record is unknown.
        active.is_torn = true;
        let record = Record::begin(flash, active.end, head)?;
        active.end = record.end::<F>();
        active.is_torn = false;
        Ok(record)
    }
}

/// Encodes the header that makes a sector valid.
pub(crate) fn encode(generation: u32) -> [u8; 16] {
    let [v0, v1, v2, v3] = VERSION.to_le_bytes();
    let [g0, g1, g2, g3] = generation.to_le_bytes();
    let [m0, m1, m2, m3] = MAGIC;
    let content = [m0, m1, m2, m3, v0, v1, v2, v3, g0, g1, g2, g3];
    let [c0, c1, c2, c3] = CHECKSUM.checksum(&content).to_le_bytes();
    [m0, m1, m2, m3, v0, v1, v2, v3, g0, g1, g2, g3, c0, c1, c2, c3]
}

/// Returns the generation in a sector's header, or `None` if the header is invalid.
fn decode(raw: [u8; 16]) -> Option<u32> {
    let [.., g0, g1, g2, g3, _, _, _, _] = raw;
    let generation = u32::from_le_bytes([g0, g1, g2, g3]);
    (encode(generation) == raw).then_some(generation)
}

/// Makes a sector valid: the last step of a compaction.
pub(crate) fn finish<F: NorFlash>(
    flash: &mut F,
    start: u32,
    generation: u32,
) -> Result<(), Error<F::Error>> {
    fill(flash, start, &encode(generation))
}
