//! Packets in a stream of bytes, of any protocol that has a header, a length and a check.

use crate::window::Window;

/// How a protocol's packets begin and end.
pub(crate) trait Framing {
    /// Header, id and length: all that is needed to know how long a packet is.
    const PREFIX_LEN: usize;

    /// How many bytes the packet at the front has; [`Self::PREFIX_LEN`] as long as that is not known; none if no packet
    /// begins here.
    fn announced(bytes: &[u8]) -> Option<usize>;

    /// Whether the check at the end of a packet is right.
    fn is_whole(packet: &[u8]) -> bool;
}

/// Finds packets of at most `N` bytes. After a damaged one it goes on from that one's second byte.
#[derive(Debug, Clone)]
pub(crate) struct Finder<const N: usize> {
    window: Window<N>,
    /// Bytes of the packet that was given out, to be dropped before the next one.
    taken: usize,
    damaged: u32,
}

impl<const N: usize> Finder<N> {
    pub(crate) const fn new() -> Self {
        Self { window: Window::new(), taken: 0, damaged: 0 }
    }

    /// Forgets what has come so far, but not how much of it was damaged.
    pub(crate) fn clear(&mut self) {
        self.window = Window::new();
        self.taken = 0;
    }

    /// How many packets had a wrong check, or were cut short.
    pub(crate) fn damaged(&self) -> u32 {
        self.damaged
    }

    /// The bytes of the next packet whose check is right. `at_end` says that no more than `input` will come.
    /// `on_damaged` gets each packet before it whose check is wrong.
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
        // A shorter window never holds a whole length: the loop would not end.
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
