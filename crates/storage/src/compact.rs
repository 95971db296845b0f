//! Compaction: copies the records of a log that are still valid into the next sector. Only this module erases sectors
//! of the log.

use embedded_storage::nor_flash::NorFlash;

use crate::damage::NOTE_KIND;
use crate::disarmed::Disarmed;
use crate::error::Error;
use crate::fault::{FAULT_KIND, FAULTS_KEPT, Tally};
use crate::flash::{CHUNK, CHUNK_LEN, fill, is_blank, read};
use crate::log::{Active, Log, finish};
use crate::record::{Record, Seal};

impl Log {
    /// Erases the next sector, copies the valid records, and then activates it. Until that last step the old sector
    /// is active, so a power cut at any point changes nothing.
    ///
    /// Valid records are the newest intact record of each kind; for faults, the first since they were cleared, and
    /// the last [`FAULTS_KEPT`]. Order is kept. Notes about damaged newer items follow.
    pub(crate) fn compact<F: NorFlash>(
        &mut self,
        flash: &mut F,
        _: &Disarmed,
    ) -> Result<(), Error<F::Error>> {
        let (sector, generation) = match self.active {
            Some(Active { sector, generation, .. }) => {
                let next = sector.saturating_add(1);
                let next = if next < self.area.sectors { next } else { 0 };
                (next, generation.saturating_add(1))
            }
            None => (0, 1),
        };
        let (start, sector_end) = (self.start(sector), self.start(sector.saturating_add(1)));
        flash.erase(start, sector_end).map_err(Error::Flash)?;
        if !is_blank(flash, start, self.area.sector_len)? {
            return Err(Error::ReadBack { at: start });
        }
        let tally = Tally::of(self, flash)?;
        let (mut fault, mut at) = (0_usize, None);
        let mut end = self.first_in::<F>(sector);
        while let Some(record) = self.next(flash, at)? {
            at = Some(record.end::<F>());
            if record.head.kind == NOTE_KIND || record.state(flash)? != Seal::Good {
                continue;
            }
            let counts = if record.head.kind == FAULT_KIND {
                let number = fault;
                fault = number.saturating_add(1);
                tally.first == Some(number) || number.saturating_add(FAULTS_KEPT) >= tally.count
            } else {
                self.newest_of(flash, record.head.kind)? == Some(record)
            };
            if counts {
                end = copy(flash, &record, end, sector_end)?;
            }
        }
        end = self.note_damage(flash, end, sector_end)?;
        finish(flash, start, generation)?;
        let (is_torn, is_cut_short) = (false, false);
        self.active = Some(Active { sector, generation, end, is_torn, is_cut_short });
        self.is_new = false;
        Ok(())
    }
}

/// Copies an intact record unchanged, and returns the address for the next record.
fn copy<F: NorFlash>(
    flash: &mut F,
    record: &Record,
    to: u32,
    end: u32,
) -> Result<u32, Error<F::Error>> {
    let copy = Record { at: to, head: record.head };
    let behind = copy.end::<F>();
    let mut left = behind.saturating_sub(to);
    if behind > end {
        return Err(Error::Full { needed: left, free: end.saturating_sub(to) });
    }
    let (mut from, mut to) = (record.at, to);
    let mut chunk = [0; CHUNK];
    while left > 0 {
        let part = chunk.get_mut(..(left as usize).min(CHUNK)).unwrap_or_default();
        read(flash, from, part)?;
        fill(flash, to, part)?;
        let len = left.min(CHUNK_LEN);
        (from, to) = (from.saturating_add(len), to.saturating_add(len));
        left = left.saturating_sub(len);
    }
    if copy.state(flash)? != Seal::Good {
        return Err(Error::ReadBack { at: copy.at });
    }
    Ok(behind)
}
