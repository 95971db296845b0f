//! The wheel: the right to drive, which one page has. Other pages may watch, hold and stop.

use std::time::Duration;

use crate::server::PageId;

/// Time without a message of the driver, or without a driver, after which the rig holds; and the time from then until
/// it is lowered.
const SILENT: Duration = Duration::from_secs(2);
pub(super) const LOWER_AFTER: Duration = Duration::from_secs(3);

/// The page that has the wheel, and the time of its last message.
#[derive(Debug, Default)]
pub(super) struct Wheel {
    holder: Option<PageId>,
    heard: Duration,
}

impl Wheel {
    /// Gives the wheel to a page, if no page has it. Returns whether this page has the wheel now.
    pub(super) fn take(&mut self, page: PageId, now: Duration) -> bool {
        if self.holder.is_none() {
            (self.holder, self.heard) = (Some(page), now);
        }
        self.is_at(page)
    }

    pub(super) fn free(&mut self, now: Duration) {
        (self.holder, self.heard) = (None, now);
    }

    pub(super) fn is_at(&self, page: PageId) -> bool {
        self.holder == Some(page)
    }

    pub(super) fn is_free(&self) -> bool {
        self.holder.is_none()
    }

    /// Notes the time of a page's message, if the page has the wheel.
    pub(super) fn hear(&mut self, page: PageId, now: Duration) {
        if self.is_at(page) {
            self.heard = now;
        }
    }

    /// Returns whether the driver has been silent, or the wheel free, for too long.
    pub(super) fn is_silent(&self, now: Duration) -> bool {
        now.saturating_sub(self.heard) >= SILENT
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_page_drives_and_others_wait() {
        let (mut wheel, s) = (Wheel::default(), Duration::from_secs);
        assert!(wheel.take(1, s(0)) && !wheel.take(2, s(0)));
        wheel.hear(2, s(5));
        assert!(wheel.is_silent(s(2)));
        wheel.hear(1, s(5));
        assert!(!wheel.is_silent(s(6)));
        wheel.free(s(6));
        assert!(!wheel.is_silent(s(7)) && wheel.take(2, s(7)) && !wheel.is_at(1));
    }
}
