//! Transfer of faults to the host and into flash.

use embedded_storage::nor_flash::NorFlash;
use sinew_link::message::ToHost;
use sinew_storage::Error;

use super::background_task::BackgroundTask;
use super::mail::{Mail, Shared};
use super::text;
use crate::supervisor::FaultNews;

impl<
    'a,
    F: NorFlash,
    const BODIES: usize,
    const DOFS: usize,
    const SERVOS: usize,
    const COORDS: usize,
> BackgroundTask<'a, F, BODIES, DOFS, SERVOS, COORDS>
{
    /// Reports faults to the host and stores them, in the order in which they occurred, together with the notes that
    /// faults were cleared. The first fault in flash after such a note is therefore the first fault since faults
    /// were cleared, even if other faults still wait to be stored.
    #[inline(never)]
    pub(super) fn keep_faults(&mut self, mail: &impl Shared<Mail<'a, DOFS, SERVOS, COORDS>>) {
        while !self.faults.is_full()
            && let Some(news) = mail.with(|mail| mail.faults.pop_front())
        {
            if let FaultNews::Fault(record) = news {
                let told = text::fault(&record);
                self.outbox.put(&ToHost::Fault(told));
                if told.is_warning() {
                    // A warning is not worth the wear of flash, nor the place of a fault.
                    self.warning = Some(told);
                    continue;
                }
                if !is_kept(record.times) {
                    continue;
                }
            } else {
                self.warning = None;
            }
            // There is room: the loop has checked it.
            let _ = self.faults.push_back(news);
        }
        if let Some(news) = self.faults.front().copied() {
            let kept = match news {
                FaultNews::Fault(record) => {
                    self.store.record_fault(&text::to_keep(&record)).map(|_| ())
                }
                FaultNews::Cleared => self.store.clear_faults(),
            };
            if let Err(Error::Untidy | Error::Full { .. }) = kept {
                // While torque is on, storage cannot make room: the record waits until torque is off.
                let Some(disarmed) = mail.with(|mail| mail.disarmed.take()) else { return };
                let is_tidy = self.store.tidy(&disarmed).is_ok();
                mail.with(|mail| mail.disarmed = Some(disarmed));
                if is_tidy {
                    return;
                }
            }
            // The record is stored. Or flash refuses it, and only the host knows it.
            self.faults.pop_front();
        }
    }
}

/// Returns whether the count of a repeated fault is stored: at 1, 16, 256 and 4096, to spare the flash.
fn is_kept(times: u16) -> bool {
    [1, 16, 256, 4096].contains(&times)
}
