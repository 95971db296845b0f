//! An intact item and its address.

use core::ops::Range;

use embedded_storage::nor_flash::NorFlash;

use crate::descriptor::{DESCRIPTOR_LEN, Descriptor};
use crate::error::Error;
use crate::flash::read;
use crate::record::{Record, Seal};

/// An item that was intact when it was read.
///
/// The content of a show stays in place until the show is deleted. The content of settings or of a rig stays until the
/// log erases its sector in a later compaction: read these items again after each compaction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stored {
    pub(crate) descriptor: Descriptor,
    pub(crate) at: u32,
}

impl Stored {
    /// Returns the descriptor.
    pub fn descriptor(&self) -> &Descriptor {
        &self.descriptor
    }

    /// Returns the content in place, if the flash is memory-mapped. `flash`: the whole flash from its first byte.
    /// Returns `None` if it is too short.
    pub fn content<'a>(&self, flash: &'a [u8]) -> Option<&'a [u8]> {
        let start = usize::try_from(self.at).ok()?;
        flash.get(start..)?.get(..usize::try_from(self.descriptor.len).ok()?)
    }

    /// Returns the address range of the content, from the start of the flash.
    pub fn place(&self) -> Range<u32> {
        self.at..self.at.saturating_add(self.descriptor.len)
    }

    /// Returns the item of a record, if it is intact and valid. O(len).
    pub(crate) fn of<F: NorFlash>(
        flash: &mut F,
        record: &Record,
    ) -> Result<Option<Self>, Error<F::Error>> {
        if record.state(flash)? != Seal::Good {
            return Ok(None);
        }
        let descriptor = describe(flash, record)?;
        Ok(descriptor.map(|descriptor| Self { descriptor, at: content_at::<F>(record) }))
    }
}

/// Reads a record's descriptor, even if the record is incomplete.
pub(crate) fn describe<F: NorFlash>(
    flash: &mut F,
    record: &Record,
) -> Result<Option<Descriptor>, Error<F::Error>> {
    if record.head.len < DESCRIPTOR_LEN {
        return Ok(None);
    }
    let mut raw = [0; DESCRIPTOR_LEN as usize];
    read(flash, record.payload_at::<F>(), &mut raw)?;
    Ok(Descriptor::decode(record.head, &raw))
}

/// Returns the address of a record's content: a multiple of the granule, because a descriptor has 96 bytes.
pub(crate) fn content_at<F: NorFlash>(record: &Record) -> u32 {
    record.payload_at::<F>().saturating_add(DESCRIPTOR_LEN)
}
