//! An item that arrives in blocks; after a power cut its upload continues.

use core::ops::Range;

use embedded_storage::nor_flash::NorFlash;
use sha2::{Digest, Sha256};

use crate::board::Capacity;
use crate::descriptor::{Descriptor, Hash, Kind};
use crate::error::Error;
use crate::flash::{CHUNK, CHUNK_LEN, fill, granule, is_blank, padded, read, scan};
use crate::record::{Record, Seal};
use crate::stored::{Stored, content_at, describe};

/// An upload in progress, from [`Store::begin`](crate::Store::begin).
#[derive(Debug, Clone)]
pub struct Upload {
    pub(crate) record: Record,
    pub(crate) descriptor: Descriptor,
    /// Generation of the log, for an item in the log. If it has changed, the place of the upload is gone.
    pub(crate) generation: Option<u32>,
    pub(crate) received: u32,
    pub(crate) is_sealed: bool,
}

impl Upload {
    /// Returns the descriptor of the item.
    pub fn descriptor(&self) -> &Descriptor {
        &self.descriptor
    }

    /// Returns the number of received bytes: the next block starts at this offset, or earlier. If the item is already
    /// intact, this is its length.
    pub fn received(&self) -> u32 {
        self.received
    }

    /// Returns the address range of the content, from the start of the flash.
    pub fn place<F: NorFlash>(&self) -> Range<u32> {
        let start = content_at::<F>(&self.record);
        start..start.saturating_add(self.descriptor.len)
    }

    /// Writes the descriptor of an item after its head.
    pub(crate) fn start<F: NorFlash>(
        flash: &mut F,
        record: Record,
        descriptor: &Descriptor,
        generation: Option<u32>,
    ) -> Result<Self, Error<F::Error>> {
        fill(flash, record.payload_at::<F>(), &descriptor.encode())?;
        let descriptor = descriptor.clone();
        Ok(Self { record, descriptor, generation, received: 0, is_sealed: false })
    }

    /// Returns an upload that continues in a record, if the record is of the same item and was not given up. O(len).
    pub(crate) fn resume<F: NorFlash>(
        flash: &mut F,
        record: Record,
        descriptor: &Descriptor,
        generation: Option<u32>,
    ) -> Result<Option<Self>, Error<F::Error>> {
        if describe(flash, &record)?.as_ref() != Some(descriptor) {
            return Ok(None);
        }
        let is_sealed = match record.state(flash)? {
            Seal::Good => true,
            Seal::Open => false,
            Seal::GivenUp | Seal::Bad => return Ok(None),
        };
        let mut upload =
            Self { record, descriptor: descriptor.clone(), generation, received: 0, is_sealed };
        upload.received = if is_sealed { descriptor.len } else { upload.written(flash)? };
        Ok(Some(upload))
    }

    /// Returns the offset of the last chunk that is not blank. Everything before it is complete, because it was
    /// written in order.
    fn written<F: NorFlash>(&self, flash: &mut F) -> Result<u32, Error<F::Error>> {
        let mut offset = self.descriptor.len & !CHUNK_LEN.saturating_sub(1);
        loop {
            let left = self.descriptor.len.saturating_sub(offset).min(CHUNK_LEN);
            let at = content_at::<F>(&self.record).saturating_add(offset);
            if offset == 0 || !is_blank(flash, at, left)? {
                return Ok(offset);
            }
            offset = offset.saturating_sub(CHUNK_LEN);
        }
    }

    pub(crate) fn write<F: NorFlash>(
        &mut self,
        flash: &mut F,
        capacity: Capacity,
        offset: u32,
        block: &[u8],
    ) -> Result<(), Error<F::Error>> {
        let len = self.descriptor.len;
        let end = u32::try_from(block.len()).unwrap_or(u32::MAX).saturating_add(offset);
        if offset > self.received {
            return Err(Error::Order { expected: self.received, found: offset });
        }
        if end > len {
            return Err(Error::Beyond { found: end, len });
        }
        let granule = granule::<F>();
        if padded::<F>(offset) != offset || (padded::<F>(end) != end && end != len) {
            return Err(Error::Alignment { granule, offset, len: block.len() });
        }
        if let (Kind::Rig, 0, Some(head)) = (self.descriptor.kind, offset, block.first_chunk()) {
            let checked = capacity.check(head);
            self.or_give_up(flash, checked.map_err(Error::from))?;
        }
        let at = content_at::<F>(&self.record).saturating_add(offset);
        let filled = fill(flash, at, block);
        self.or_give_up(flash, filled)?;
        self.received = self.received.max(end);
        Ok(())
    }

    pub(crate) fn end<F: NorFlash>(
        &self,
        flash: &mut F,
        capacity: Capacity,
    ) -> Result<Stored, Error<F::Error>> {
        let Self { record, descriptor, .. } = self;
        if self.received != descriptor.len {
            return Err(Error::Order { expected: self.received, found: descriptor.len });
        }
        let at = content_at::<F>(record);
        if !self.is_sealed {
            let checked = self.check(flash, capacity, at);
            self.or_give_up(flash, checked)?;
            record.seal(flash)?;
        }
        Stored::of(flash, record)?.ok_or(Error::Stale)
    }

    /// Checks that the content in flash is the announced one.
    fn check<F: NorFlash>(
        &self,
        flash: &mut F,
        capacity: Capacity,
        at: u32,
    ) -> Result<(), Error<F::Error>> {
        let descriptor = &self.descriptor;
        if describe(flash, &self.record)?.as_ref() != Some(descriptor) {
            return Err(Error::Stale);
        }
        if descriptor.kind == Kind::Rig {
            // A shorter content is not a rig.
            let mut head = [0; Capacity::HEAD_LEN];
            let len = CHUNK.min(descriptor.len as usize).min(head.len());
            read(flash, at, head.get_mut(..len).unwrap_or_default())?;
            capacity.check(&head)?;
        }
        let mut hasher = Sha256::new();
        scan(flash, at, descriptor.len, |part| hasher.update(part))?;
        if Hash::finish(hasher) == descriptor.hash { Ok(()) } else { Err(Error::Hash) }
    }

    /// Gives up an upload whose `result` shows that it cannot succeed, so that it is never continued. Returns `result`.
    fn or_give_up<F: NorFlash>(
        &self,
        flash: &mut F,
        result: Result<(), Error<F::Error>>,
    ) -> Result<(), Error<F::Error>> {
        if let Err(Error::Torn { .. } | Error::Hash | Error::Capacity(_)) = result {
            self.record.give_up(flash)?;
        }
        result
    }
}
