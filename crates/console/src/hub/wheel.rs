//! The wheel: the right to drive, which one page has. Other pages may watch, hold and stop.

use std::time::Duration;

use crate::server::PageId;

/// Time without a message of the driver, or without a driver, after which the rig holds; and the time from then until
/// it is lowered.
const SILENT: Duration = Duration::from_secs(2);
pub(super) const LOWER_AFTER: Duration = Duration::from_secs(3);
/// Time after which a request for the wheel is forgotten.
const ASKS: Duration = Duration::from_secs(30);

/// The page that has the wheel, and the time of its last message.
#[derive(Debug, Default)]
pub(super) struct Wheel {
    holder: Option<PageId>,
    heard: Duration,
    /// The page that asked for the wheel last, and the time.
    asks: Option<(PageId, Duration)>,
}

impl Wheel {
    /// Gives the wheel to a page, if the wheel is free or its holder is silent. Returns whether the page now holds the
    /// wheel. Otherwise the request of the page is stored.
    pub(super) fn take(&mut self, page: PageId, now: Duration) -> bool {
        if self.is_at(page) {
            return true;
        }
        let is_given = self.holder.is_none() || self.is_silent(now);
        if is_given {
            (self.holder, self.heard, self.asks) = (Some(page), now, None);
        } else {
            self.asks = Some((page, now));
        }
        is_given
    }

    /// Takes the wheel from its holder, and gives it to the page that has asked for it; otherwise the wheel is free.
    pub(super) fn pass(&mut self, now: Duration) {
        let next = self.asks.take().filter(|(_, at)| now.saturating_sub(*at) < ASKS);
        (self.holder, self.heard) = (next.map(|(page, _)| page), now);
    }

    /// Deletes the request of a page that is closed.
    pub(super) fn forget(&mut self, page: PageId) {
        self.asks.take_if(|(asks, _)| *asks == page);
    }

    /// Returns whether a page has asked for the wheel within the last 30 s.
    pub(super) fn is_asked(&self, now: Duration) -> bool {
        self.asks.is_some_and(|(_, at)| now.saturating_sub(at) < ASKS)
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
        // The page that has asked for the wheel gets it.
        wheel.pass(s(6));
        assert!(!wheel.is_silent(s(7)) && wheel.is_at(2) && !wheel.is_asked(s(7)));
        // No page has asked for the wheel since.
        wheel.pass(s(8));
        assert!(wheel.is_free() && wheel.take(1, s(8)) && !wheel.take(3, s(9)));
        wheel.forget(3);
        wheel.pass(s(9));
        assert!(wheel.is_free());
    }

    #[test]
    fn a_silent_page_loses_the_wheel() {
        let (mut wheel, s) = (Wheel::default(), Duration::from_secs);
        assert!(wheel.take(1, s(0)) && !wheel.take(2, s(1)) && wheel.is_asked(s(1)));
        assert!(wheel.take(2, s(2)) && wheel.is_at(2));
        // A message of the previous page arrives; it only watches now.
        wheel.hear(1, s(3));
        assert!(!wheel.take(1, s(3)));
    }
}
