//! Allocates the place of an item: room in the log, or a free slot.

use embedded_storage::nor_flash::NorFlash;

use crate::descriptor::Descriptor;
use crate::disarmed::Disarmed;
use crate::error::Error;
use crate::fault::{Tally, reserve};
use crate::record::{Record, RecordStatus};
use crate::store::Store;
use crate::upload::Upload;

impl<F: NorFlash> Store<F> {
    pub(crate) fn begin_in_log(
        &mut self,
        disarmed: &Disarmed,
        descriptor: &Descriptor,
    ) -> Result<Upload, Error<F::Error>> {
        let newest = self
            .log
            .newest(&mut self.flash, |_, record| Ok(record.head.kind == descriptor.kind.code()))?;
        let generation = self.log.active.map(|active| active.generation);
        if let Some(record) = newest
            && let Some(upload) = Upload::resume(&mut self.flash, record, descriptor, generation)?
            // If a newer item is damaged, the host must confirm this one again.
            && !(upload.is_sealed && self.log.is_damaged(&mut self.flash, descriptor.kind)?)
        {
            return Ok(upload);
        }
        let head = descriptor.head();
        self.make_room(disarmed, Record::room::<F>(head.len))?;
        let record = self.log.begin(&mut self.flash, head)?;
        let generation = self.log.active.map(|active| active.generation);
        Upload::start(&mut self.flash, record, descriptor, generation)
    }

    pub(crate) fn begin_in_slot(
        &mut self,
        _: &Disarmed,
        descriptor: &Descriptor,
    ) -> Result<Upload, Error<F::Error>> {
        let head = descriptor.head();
        let room = Record::room::<F>(head.len);
        let mut free = None;
        let mut holds = 0;
        for area in self.board.slots {
            holds = holds.max(area.holds::<F>());
            if room > area.total_len() {
                continue;
            }
            if let RecordStatus::Record(record) =
                Record::look(&mut self.flash, area.start, area.end())?
            {
                let resumed = Upload::resume(&mut self.flash, record, descriptor, None)?;
                if let Some(upload) = resumed {
                    return Ok(upload);
                }
            }
            if free.is_none() && self.in_slot(*area)?.is_none() {
                free = Some(*area);
            }
        }
        let len = descriptor.len;
        if len > holds {
            return Err(Error::TooLong { len, holds });
        }
        let area = free.ok_or(Error::NoFreeSlot { len })?;
        // Erased even if it is blank: after an interrupted erase, flash may read as blank and still not keep data.
        self.flash.erase(area.start, area.sectors_end(room)).map_err(Error::Flash)?;
        let record = Record::begin(&mut self.flash, area.start, head)?;
        Upload::start(&mut self.flash, record, descriptor, None)
    }

    /// Makes room in the log for a record, in addition to the reserve for faults.
    pub(crate) fn make_room(
        &mut self,
        disarmed: &Disarmed,
        needed: u32,
    ) -> Result<(), Error<F::Error>> {
        let mut free = self.free_beside_faults()?;
        if needed > free || self.log.active.is_none_or(|active| active.is_torn) {
            self.log.compact(&mut self.flash, disarmed)?;
            free = self.free_beside_faults()?;
        }
        if needed > free { Err(Error::Full { needed, free }) } else { Ok(()) }
    }

    fn free_beside_faults(&mut self) -> Result<u32, Error<F::Error>> {
        let tally = Tally::of(&self.log, &mut self.flash)?;
        Ok(self.log.free().saturating_sub(reserve::<F>(tally)))
    }

    /// Refuses an upload whose place was given up because the log was compacted.
    pub(crate) fn check_place(&self, upload: &Upload) -> Result<(), Error<F::Error>> {
        let here = self.log.active.map(|active| active.generation);
        if upload.generation.is_some() && upload.generation != here {
            return Err(Error::Stale);
        }
        Ok(())
    }
}
