//! Finds packets in a stream of bytes, for any protocol with a header, a length and a check.

use crate::window::Window;

/// The rules of a protocol for the beginning and the end of a packet.
pub(crate) trait Framing {
    /// Length of header, id and length field: the bytes that are needed to know the length of a packet.
    const PREFIX_LEN: usize;

    /// Returns the length of the packet at the front, [`Self::PREFIX_LEN`] while the length is not known yet, or `None`
    /// if no packet begins there.
    fn announced(bytes: &[u8]) -> Option<usize>;

    /// Returns whether the check at the end of a packet is right.
    fn is_whole(packet: &[u8]) -> bool;
}

/// A search for packets of at most `N` bytes. After a damaged packet it continues at that packet's second byte.
#[derive(Debug, Clone)]
pub(crate) struct Finder<const N: usize> {
    window: Window<N>,
    /// Length of the packet that was returned last: its bytes are dropped by the next call.
    taken: usize,
    damaged: u32,
}

impl<const N: usize> Finder<N> {
    pub(crate) const fn new() -> Self {
        Self { window: Window::new(), taken: 0, damaged: 0 }
    }

    /// Discards all buffered bytes, but keeps the count of damaged packets.
    pub(crate) fn clear(&mut self) {
        self.window = Window::new();
        self.taken = 0;
    }

    /// Returns the number of packets with a wrong check or a missing end.
    pub(crate) fn damaged(&self) -> u32 {
        self.damaged
    }

    /// Returns the bytes of the next packet with a correct check. `at_end` states that no bytes will arrive after
    /// `input`. `on_damaged` receives each earlier packet whose check is wrong.
    pub(crate) fn next<F: Framing>(
        &mut self,
        input: &mut &[u8],
        at_end: bool,
        on_damaged: impl FnMut(&[u8]),
    ) -> Option<&mut [u8]> {
        self.window.drop_front(self.taken);
        self.taken = 0;
        let total = self.find::<F>(input, at_end, on_damaged)?;
        self.taken = total;
        self.window.bytes_mut().get_mut(..total)
    }

    fn find<F: Framing>(
        &mut self,
        input: &mut &[u8],
        at_end: bool,
        mut on_damaged: impl FnMut(&[u8]),
    ) -> Option<usize> {
        // A window that is too short never holds a whole prefix: the loop would not end.
        const { assert!(N > F::PREFIX_LEN, "a parser must hold more than a packet's prefix") };
        loop {
            let announced = F::announced(self.window.bytes()).filter(|wanted| *wanted <= N);
            let Some(wanted) = announced else {
                self.window.drop_front(1);
                continue;
            };
            let is_known = wanted > F::PREFIX_LEN;
            if self.window.fill(wanted, input) {
                if !is_known {
                    continue;
                }
                let packet = self.window.bytes().get(..wanted).unwrap_or_default();
                if F::is_whole(packet) {
                    return Some(wanted);
                }
                on_damaged(packet);
            } else if !at_end || self.window.bytes().is_empty() {
                return None;
            }
            self.damaged = self.damaged.saturating_add(u32::from(is_known));
            self.window.drop_front(1);
        }
    }
}
