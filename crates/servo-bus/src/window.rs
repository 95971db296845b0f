//! Holds the unread bytes of a stream in a fixed buffer.

/// The bytes that a parser examines. It drops bytes at the front and adds bytes at the back.
#[derive(Debug, Clone)]
pub(crate) struct Window<const N: usize> {
    buffer: [u8; N],
    start: usize,
    end: usize,
}

impl<const N: usize> Window<N> {
    pub(crate) const fn new() -> Self {
        Self { buffer: [0; N], start: 0, end: 0 }
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        self.buffer.get(self.start..self.end).unwrap_or_default()
    }

    pub(crate) fn bytes_mut(&mut self) -> &mut [u8] {
        self.buffer.get_mut(self.start..self.end).unwrap_or_default()
    }

    pub(crate) fn drop_front(&mut self, count: usize) {
        self.start = self.start.saturating_add(count).min(self.end);
    }

    /// Moves bytes from `input` to the back until the window holds `len` bytes. Returns whether it does.
    pub(crate) fn fill(&mut self, len: usize, input: &mut &[u8]) -> bool {
        if self.start.saturating_add(len) > N {
            self.compact();
        }
        let have = self.end.saturating_sub(self.start);
        let free = self.buffer.get_mut(self.end..).unwrap_or_default();
        let taken = len.saturating_sub(have).min(free.len()).min(input.len());
        for (slot, byte) in free.iter_mut().zip(input.iter().take(taken)) {
            *slot = *byte;
        }
        self.end = self.end.saturating_add(taken);
        *input = input.get(taken..).unwrap_or_default();
        self.end.saturating_sub(self.start) >= len
    }

    fn compact(&mut self) {
        let count = self.end.saturating_sub(self.start);
        for index in 0..count {
            let byte = self.buffer.get(self.start.saturating_add(index)).copied().unwrap_or(0);
            if let Some(slot) = self.buffer.get_mut(index) {
                *slot = byte;
            }
        }
        (self.start, self.end) = (0, count);
    }
}
