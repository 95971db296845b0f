//! Damage in a log: newer settings, or a newer rig, that are no longer intact. A program that reads the older item must
//! know about it.
//!
//! Either a record was sealed and its CRC is wrong, or a head is invalid and followed by more bytes than a power cut
//! leaves. A compaction drops both, and writes a note instead: a record without payload, whose schema is the item's
//! kind.

use embedded_storage::nor_flash::NorFlash;

use crate::descriptor::Kind;
use crate::error::Error;
use crate::flash::{is_blank, padded};
use crate::log::{Active, Log};
use crate::record::{HEAD_LEN, Head, Record, Seal};
use crate::stored::describe;

pub(crate) const NOTE_KIND: u8 = 18;

/// Maximum number of notes in a log: for settings, and for a rig.
pub(crate) const NOTES: u32 = 2;

impl Log {
    /// Returns `true` if there was a newer item of this kind than the newest intact one, or there may have been one
    /// among unreachable records. O(length of the log).
    pub(crate) fn is_damaged<F: NorFlash>(
        &self,
        flash: &mut F,
        kind: Kind,
    ) -> Result<bool, Error<F::Error>> {
        let (mut is_damaged, mut at) = (false, None);
        while let Some(record) = self.next(flash, at)? {
            at = Some(record.end::<F>());
            if record.head == note(kind) {
                is_damaged = true;
            } else if record.head.kind == kind.code() {
                match record.state(flash)? {
                    Seal::Good => is_damaged = describe(flash, &record)?.is_none(),
                    // A seal that was interrupted by a power failure looks the same. It counts as damage, although
                    // the item was never confirmed.
                    Seal::Bad => is_damaged = true,
                    Seal::Open | Seal::GivenUp => {}
                }
            }
        }
        Ok(is_damaged || self.active.is_some_and(|active| active.is_cut_short))
    }

    /// Writes notes about damaged items during a compaction. Returns the address for the next record.
    pub(crate) fn note_damage<F: NorFlash>(
        &self,
        flash: &mut F,
        mut at: u32,
        end: u32,
    ) -> Result<u32, Error<F::Error>> {
        for kind in [Kind::Settings, Kind::Rig] {
            if self.is_damaged(flash, kind)? {
                let needed = Record::room::<F>(0);
                let free = end.saturating_sub(at);
                if needed > free {
                    return Err(Error::Full { needed, free });
                }
                let record = Record::begin(flash, at, note(kind))?;
                record.seal(flash)?;
                at = record.end::<F>();
            }
        }
        Ok(at)
    }
}

impl Active {
    /// Checks whether more bytes follow a torn head than a power cut leaves (the length of a head). These are
    /// unreachable records.
    pub(crate) fn look_behind<F: NorFlash>(
        &mut self,
        flash: &mut F,
        end: u32,
    ) -> Result<(), Error<F::Error>> {
        let rest = end.saturating_sub(self.end);
        self.is_torn = !is_blank(flash, self.end, rest)?;
        let head = padded::<F>(HEAD_LEN).min(rest);
        let behind = self.end.saturating_add(head);
        self.is_cut_short = !is_blank(flash, behind, rest.saturating_sub(head))?;
        Ok(())
    }
}

fn note(kind: Kind) -> Head {
    Head { kind: NOTE_KIND, schema: kind.code().into(), len: 0 }
}
