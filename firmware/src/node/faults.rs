//! Faults on their way to the host and into flash.

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
    /// Tells faults to the host, and keeps them: in the order in which they came, with the notes between them that they
    /// were cleared. So the first one in flash is the first since then, whatever waits.
    #[inline(never)]
    pub(super) fn keep_faults(&mut self, mail: &impl Shared<Mail<'a, DOFS, SERVOS, COORDS>>) {
        while !self.faults.is_full()
            && let Some(news) = mail.with(|mail| mail.faults.pop_front())
        {
            if let FaultNews::Fault(record) = news {
                let told = text::fault(&record);
                self.outbox.put(&ToHost::Fault(told));
                if told.is_warning() {
                    // Not worth the flash's wear, nor the place of a fault.
                    self.warning = Some(told);
                    continue;
                }
                if !is_kept(record.times) {
                    continue;
                }
            } else {
                self.warning = None;
            }
            // There is room: asked above.
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
                // There is no room while torque is on: it waits until that is off.
                let Some(disarmed) = mail.with(|mail| mail.disarmed.take()) else { return };
                let is_tidy = self.store.tidy(&disarmed).is_ok();
                mail.with(|mail| mail.disarmed = Some(disarmed));
                if is_tidy {
                    return;
                }
            }
            // It is there; or the flash refuses it, and the host knows it alone.
            self.faults.pop_front();
        }
    }
}

/// A fault that comes and goes is written when it came once, 16 times, 256 times, 4096 times: flash wears.
fn is_kept(times: u16) -> bool {
    [1, 16, 256, 4096].contains(&times)
}
