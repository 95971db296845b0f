//! Start of a node: reads and checks everything in storage at power-on.

use core::mem::MaybeUninit;

use embedded_storage::nor_flash::NorFlash;
use sinew_rig::board::BoardRig;
use sinew_storage::{BoardTable, Condition, Disarmed, Error, Hash, Kind, Store, Stored};

use super::settings::{NodeSettings, SETTINGS_MAX, SETTINGS_SCHEMA};
use super::text;
use crate::controller::Start;
use crate::supervisor::{Fault, FaultLog, FaultRecord, FaultSet, LOGGED};

/// Version of the rig's compact form.
pub const RIG_SCHEMA: u16 = 1;

/// The data that was read at power-on.
#[derive(Debug)]
pub struct Found<'r, F, const BODIES: usize, const DOFS: usize, const SERVOS: usize> {
    /// The storage, in a consistent state.
    pub store: Store<F>,
    /// The only permission to erase, for [`Mail::new`](super::Mail::new).
    pub disarmed: Disarmed,
    /// The stored settings, or the board's own if there are none or they are bad.
    pub settings: NodeSettings,
    /// The rig, and the CRC at the end of its compact form. `None` if there is no valid rig: then nothing can move.
    pub rig: Option<(&'r BoardRig<BODIES, DOFS, SERVOS>, u32)>,
    /// Whether the settings or the rig are not the newest that were stored, because the newest are bad.
    pub is_bad: bool,
    /// Input of the controller: the reasons for the start and bad data, as faults, and the stored faults of earlier
    /// starts.
    pub start: Start,
}

/// Opens storage and reads it. `defaults` returns the board's own settings for the bytes that are stored [after the
/// rig](split_rig). `causes` are the reasons for the start. `room` holds the longest item of a rig; the rig is decoded
/// in `slot`. O(length of the log).
///
/// # Errors
/// [`Error`] if the flash cannot be read, or the table does not fit it. Invalid content of the flash is not an error.
pub fn start<'r, F: NorFlash, const BODIES: usize, const DOFS: usize, const SERVOS: usize>(
    flash: F,
    table: BoardTable,
    defaults: impl FnOnce(&[u8]) -> NodeSettings,
    mut causes: FaultSet,
    room: &mut [u8],
    slot: &'r mut MaybeUninit<BoardRig<BODIES, DOFS, SERVOS>>,
) -> Result<Found<'r, F, BODIES, DOFS, SERVOS>, Error<F::Error>> {
    let (mut store, disarmed) = Store::open(flash, table)?;
    let was_lost = store.condition() == Condition::Lost;
    store.tidy(&disarmed)?;
    let log = fault_log(&mut store)?;

    // Older complete items are read, so that a host can ask for them. They are not used unless somebody approves them
    // again.
    let mut is_bad =
        was_lost || store.is_damaged(Kind::Settings)? || store.is_damaged(Kind::Rig)?;
    let (mut rig, mut behind): (_, &[u8]) = (None, &[]);
    if let Some(item) = store.rig()?
        && let Some(content) = content(&mut store, &item, RIG_SCHEMA, room)?
    {
        let (bytes, more) = split_rig(content);
        (rig, behind) = (read_rig(slot, bytes), more);
    }
    is_bad |= rig.is_none();
    let defaults = defaults(behind);
    let mut settings = defaults.clone();
    if let Some(item) = store.settings()? {
        let mut bytes = [0; SETTINGS_MAX];
        let of_rig = item.descriptor().rig;
        let fits = of_rig == 0 || rig.as_ref().is_some_and(|(_, crc)| *crc == of_rig);
        let bytes = content(&mut store, &item, SETTINGS_SCHEMA, &mut bytes)?;
        match bytes.map(|bytes| defaults.read(bytes)) {
            Some(Ok(read)) if fits => settings = read,
            _ => is_bad = true,
        }
    }
    if let Some((_, crc)) = rig {
        settings.controller.rig_crc = crc;
    }
    if is_bad {
        causes = causes.with(Fault::SettingsBad);
    }
    let count = store.run();
    Ok(Found { store, disarmed, settings, rig, is_bad, start: Start { count, causes, log } })
}

/// End of an item that has further data after the rig.
const MORE: [u8; 4] = *b"SNWW";

/// Splits the item of a rig into its compact form and the data after it, which only the board reads (the wiring). The
/// data ends with its own length, u32 little-endian, and `SNWW`; without this end the whole item is the rig.
pub fn split_rig(item: &[u8]) -> (&[u8], &[u8]) {
    let split = || {
        let (item, end) = item.split_last_chunk()?;
        let (item, len) = item.split_last_chunk()?;
        let at = item.len().checked_sub(u32::from_le_bytes(*len) as usize)?;
        (*end == MORE).then(|| item.split_at_checked(at)).flatten()
    };
    split().unwrap_or((item, &[]))
}

/// Completes an item: its first `rig_len` bytes are a rig, and the bytes from there to `len` are the data after it.
/// Returns the complete length, or `None` if there is no room.
#[must_use]
pub fn join_rig(item: &mut [u8], rig_len: usize, len: usize) -> Option<usize> {
    let more = u32::try_from(len.checked_sub(rig_len)?).ok()?;
    let (end, _) = item.get_mut(len..)?.split_first_chunk_mut::<8>()?;
    for (to, from) in end.iter_mut().zip(more.to_le_bytes().into_iter().chain(MORE)) {
        *to = from;
    }
    len.checked_add(end.len())
}

/// Returns the content of an item if it has this version, fits into `room`, and has the right hash.
fn content<'r, F: NorFlash>(
    store: &mut Store<F>,
    item: &Stored,
    schema: u16,
    room: &'r mut [u8],
) -> Result<Option<&'r [u8]>, Error<F::Error>> {
    let descriptor = item.descriptor();
    let Some(bytes) = room.get_mut(..descriptor.len as usize) else { return Ok(None) };
    store.read(item, 0, bytes)?;
    let is_good = descriptor.check_schema(schema).is_ok() && Hash::of(bytes) == descriptor.hash;
    Ok(is_good.then_some(bytes))
}

/// Returns the rig, and the CRC at the end of its compact form, or `None` if the bytes are not a valid rig.
fn read_rig<'r, const BODIES: usize, const DOFS: usize, const SERVOS: usize>(
    slot: &'r mut MaybeUninit<BoardRig<BODIES, DOFS, SERVOS>>,
    bytes: &[u8],
) -> Option<(&'r BoardRig<BODIES, DOFS, SERVOS>, u32)> {
    let crc = u32::from_le_bytes(*bytes.last_chunk()?);
    BoardRig::decode_in(slot, bytes).ok().map(|rig| (&*rig, crc))
}

/// Returns the stored faults for the supervisor. If a repeated fault was stored several times, only its newest record
/// is used. A fault that occurred again after faults were cleared has its own time.
fn fault_log<F: NorFlash>(store: &mut Store<F>) -> Result<FaultLog<LOGGED>, Error<F::Error>> {
    let kept = store.faults()?;
    let mut last: heapless::Vec<FaultRecord, LOGGED> = heapless::Vec::new();
    for record in kept.last.iter().rev().filter_map(text::kept) {
        let is_again =
            last.iter().any(|newer| newer.is_as(&record) && newer.time_us == record.time_us);
        if !is_again && last.push(record).is_err() {
            break;
        }
    }
    let first = kept.first.as_ref().and_then(text::kept);
    // By reference: the drop of a list that is taken apart can panic.
    Ok(FaultLog::restored(first, last.iter().copied()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_item_is_a_rig_and_what_is_behind_it() {
        let mut item = *b"rigmore........";
        assert_eq!(join_rig(&mut item, 3, 7), Some(15));
        assert_eq!(split_rig(&item), (&b"rig"[..], &b"more"[..]));
        assert_eq!(split_rig(&item[..14]), (&item[..14], &[][..]));
        assert_eq!(join_rig(&mut item, 3, 8), None);
        // The length in the item is greater than the item's.
        assert_eq!(split_rig(&item[6..]), (&item[6..], &[][..]));
    }
}
