//! The store: all persistent items of a board, in one flash.

use embedded_storage::nor_flash::NorFlash;

use crate::area::Area;
use crate::board::BoardTable;
use crate::descriptor::{Descriptor, Kind};
use crate::disarmed::Disarmed;
use crate::error::Error;
use crate::fault::{CLEARED_HEAD, FAULT_HEAD, Fault, Faults, least_reserve};
use crate::flash::{fill, read};
use crate::log::{Active, Log};
use crate::record::{Record, RecordStatus};
use crate::stored::Stored;
use crate::upload::Upload;

/// The persistent items of a board, in a flash `F`.
///
/// Each reading of an item reads all of its bytes, to check its CRC. Without [`Disarmed`], only faults, and the record
/// that they were cleared, can be written.
#[derive(Debug)]
pub struct Store<F> {
    pub(crate) flash: F,
    pub(crate) board: BoardTable,
    pub(crate) log: Log,
    run: u32,
}

/// Condition of the log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Condition {
    /// There never was a log: the first item, or [`Store::tidy`], creates it.
    New,
    /// The log is in order.
    Good,
    /// A power cut left an incomplete record, or the log has too little room for new faults. The items are intact, but
    /// recording a fault may fail until [`Store::tidy`].
    Untidy,
    /// The flash holds data, but not a log. Settings, rig and faults are lost.
    Lost,
}

impl<F: NorFlash> Store<F> {
    /// Opens the existing items, and writes nothing. Call it only once, at power-on: it creates the only [`Disarmed`].
    /// O(length of the log).
    ///
    /// # Errors
    /// [`Error::Table`] if the table does not fit the flash; [`Error::Flash`].
    pub fn open(mut flash: F, board: BoardTable) -> Result<(Self, Disarmed), Error<F::Error>> {
        board.check::<F>(flash.capacity()).map_err(Error::Table)?;
        let log = Log::open(&mut flash, board.log)?;
        let faults = Faults::of(&log, &mut flash)?;
        let last = faults.last.iter().chain(&faults.first).map(|fault| fault.run).max();
        let run = last.unwrap_or(0).saturating_add(1);
        Ok((Self { flash, board, log, run }, Disarmed::at_power_on()))
    }

    /// Returns the condition of the log.
    pub fn condition(&self) -> Condition {
        match self.log.active {
            None if self.log.is_new => Condition::New,
            None => Condition::Lost,
            Some(Active { is_torn: false, .. }) if self.log.free() >= least_reserve::<F>() => {
                Condition::Good
            }
            Some(_) => Condition::Untidy,
        }
    }

    /// Tidies the log if necessary, so that faults can be recorded while nothing may be erased. Call it after
    /// opening, and whenever the rig becomes limp. Erases one sector, or none.
    ///
    /// # Errors
    /// [`Error::Flash`], [`Error::ReadBack`].
    pub fn tidy(&mut self, disarmed: &Disarmed) -> Result<(), Error<F::Error>> {
        if self.condition() == Condition::Good {
            return Ok(());
        }
        self.log.compact(&mut self.flash, disarmed)
    }

    /// Returns the number of this start, which is stored with every fault of this start.
    pub fn run(&self) -> u32 {
        self.run
    }

    /// Returns the board's declaration.
    pub fn board(&self) -> &BoardTable {
        &self.board
    }

    /// Ends the store, and returns the flash.
    pub fn close(self) -> F {
        self.flash
    }

    /// Returns the settings, if they are stored.
    ///
    /// # Errors
    /// [`Error::Flash`].
    pub fn settings(&mut self) -> Result<Option<Stored>, Error<F::Error>> {
        self.in_log(Kind::Settings)
    }

    /// Returns the rig, if it is stored.
    ///
    /// # Errors
    /// [`Error::Flash`].
    pub fn rig(&mut self) -> Result<Option<Stored>, Error<F::Error>> {
        self.in_log(Kind::Rig)
    }

    /// Returns `true` if newer settings, or a newer rig, existed than [`Self::settings`] or [`Self::rig`] reads, and
    /// are damaged. This stays `true` over every power cut until a new intact item is written. A power failure in the
    /// middle of a seal, which is rare, cannot be distinguished from damage and counts as damage, too. O(length of the
    /// log).
    ///
    /// # Errors
    /// [`Error::Flash`].
    pub fn is_damaged(&mut self, kind: Kind) -> Result<bool, Error<F::Error>> {
        self.log.is_damaged(&mut self.flash, kind)
    }

    /// Returns the show of a slot, if there is one. O(its size): its CRC covers every byte.
    ///
    /// # Errors
    /// [`Error::Slot`] if there is no such slot; [`Error::Flash`].
    pub fn show(&mut self, slot: usize) -> Result<Option<Stored>, Error<F::Error>> {
        let area = self.slot(slot)?;
        self.in_slot(area)
    }

    /// Reads content of an item, for flash that is not memory-mapped; [`Stored::content`] needs no copy.
    ///
    /// # Errors
    /// [`Error::Beyond`] if the range is not within the item; [`Error::Flash`].
    pub fn read(
        &mut self,
        item: &Stored,
        offset: u32,
        out: &mut [u8],
    ) -> Result<(), Error<F::Error>> {
        let end = u32::try_from(out.len()).unwrap_or(u32::MAX).saturating_add(offset);
        let len = item.descriptor.len;
        if end > len {
            return Err(Error::Beyond { found: end, len });
        }
        read(&mut self.flash, item.at.saturating_add(offset), out)
    }

    /// Starts an upload, or continues it: [`Upload::received`] returns the offset. Settings and rigs go into the log,
    /// a show into the first free slot that is large enough.
    ///
    /// # Errors
    /// [`Error::Full`], [`Error::TooLong`], [`Error::NoFreeSlot`] if there is no room; [`Error::Flash`],
    /// [`Error::ReadBack`].
    pub fn begin(
        &mut self,
        disarmed: &Disarmed,
        descriptor: &Descriptor,
    ) -> Result<Upload, Error<F::Error>> {
        match descriptor.kind {
            Kind::Settings | Kind::Rig => self.begin_in_log(disarmed, descriptor),
            Kind::Show => self.begin_in_slot(disarmed, descriptor),
        }
    }

    /// Writes a block at [`Upload::received`], or repeats an earlier block. Blocks start and end at multiples of the
    /// flash's granule; only the last block may end anywhere. O(block).
    ///
    /// # Errors
    /// [`Error::Order`], [`Error::Beyond`], [`Error::Alignment`]: send the right block. [`Error::Stale`],
    /// [`Error::Torn`], [`Error::Capacity`] (of a rig's first block): start again. [`Error::Flash`],
    /// [`Error::ReadBack`].
    pub fn write(
        &mut self,
        _: &Disarmed,
        upload: &mut Upload,
        offset: u32,
        block: &[u8],
    ) -> Result<(), Error<F::Error>> {
        self.check_place(upload)?;
        upload.write(&mut self.flash, self.board.capacity, offset, block)
    }

    /// Ends an upload: the content is read back, hashed and sealed. From then on the item is valid. O(len).
    ///
    /// # Errors
    /// [`Error::Order`] if bytes are missing. [`Error::Hash`], [`Error::Capacity`]: the upload is dropped.
    /// [`Error::Stale`]: start again. [`Error::Flash`], [`Error::ReadBack`].
    pub fn end(&mut self, _: &Disarmed, upload: &Upload) -> Result<Stored, Error<F::Error>> {
        self.check_place(upload)?;
        upload.end(&mut self.flash, self.board.capacity)
    }

    /// Uploads an item in one call. It writes nothing if the same item is already stored, and no newer item is damaged.
    ///
    /// # Errors
    /// As in [`Self::begin`], [`Self::write`], [`Self::end`].
    pub fn put(
        &mut self,
        disarmed: &Disarmed,
        descriptor: &Descriptor,
        content: &[u8],
    ) -> Result<Stored, Error<F::Error>> {
        let mut upload = self.begin(disarmed, descriptor)?;
        let result = self.write(disarmed, &mut upload, 0, content);
        if let Err(Error::Torn { .. }) = result {
            // A power cut had left a part of the item. That part was given up; start again.
            upload = self.begin(disarmed, descriptor)?;
            self.write(disarmed, &mut upload, 0, content)?;
        } else {
            result?;
        }
        self.end(disarmed, &upload)
    }

    /// Deletes the show of a slot: erases the sector with its head. After a power cut the show is intact or absent.
    ///
    /// # Errors
    /// [`Error::Slot`] if there is no such slot; [`Error::Flash`].
    pub fn delete_show(&mut self, _: &Disarmed, slot: usize) -> Result<(), Error<F::Error>> {
        let area = self.slot(slot)?;
        self.flash.erase(area.start, area.sectors_end(1)).map_err(Error::Flash)
    }

    /// Records a fault, even while the rig is armed. It erases nothing; call it when the servos are safe. Returns the
    /// number of this start, which replaces `fault.run`.
    ///
    /// # Errors
    /// [`Error::Untidy`], [`Error::Full`]: keep the fault in RAM until the rig is limp, then call [`Self::tidy`].
    /// [`Error::Flash`], [`Error::ReadBack`].
    pub fn record_fault(&mut self, fault: &Fault) -> Result<u32, Error<F::Error>> {
        let record = self.log.begin(&mut self.flash, FAULT_HEAD)?;
        let fault = Fault { run: self.run, ..*fault };
        fill(&mut self.flash, record.payload_at::<F>(), &fault.encode())?;
        record.seal(&mut self.flash)?;
        Ok(self.run)
    }

    /// Returns the first fault since they were cleared, and the last ones. O(length of the log).
    ///
    /// # Errors
    /// [`Error::Flash`].
    pub fn faults(&mut self) -> Result<Faults, Error<F::Error>> {
        Faults::of(&self.log, &mut self.flash)
    }

    /// Clears faults: the next fault becomes the first, and the last faults stay. It erases nothing, and works even
    /// while the rig is armed, because a person may clear faults while the rig is lowered.
    ///
    /// # Errors
    /// As in [`Self::record_fault`].
    pub fn clear_faults(&mut self) -> Result<(), Error<F::Error>> {
        self.log.begin(&mut self.flash, CLEARED_HEAD)?.seal(&mut self.flash)
    }

    fn in_log(&mut self, kind: Kind) -> Result<Option<Stored>, Error<F::Error>> {
        let mut newest = None;
        self.log.newest(&mut self.flash, |flash, record| {
            if record.head.kind == kind.code() {
                newest = Stored::of(flash, record)?.or(newest.take());
            }
            Ok(false)
        })?;
        Ok(newest)
    }

    pub(crate) fn in_slot(&mut self, area: Area) -> Result<Option<Stored>, Error<F::Error>> {
        let RecordStatus::Record(record) = Record::look(&mut self.flash, area.start, area.end())?
        else {
            return Ok(None);
        };
        let item = Stored::of(&mut self.flash, &record)?;
        Ok(item.filter(|item| item.descriptor.kind == Kind::Show))
    }

    fn slot(&self, slot: usize) -> Result<Area, Error<F::Error>> {
        let slots = self.board.slots;
        slots.get(slot).copied().ok_or(Error::Slot { slot, slots: slots.len() })
    }
}
