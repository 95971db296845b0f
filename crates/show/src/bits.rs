//! Reads bits in the order of bytes, the most significant bit first.

/// A reader of bits. After the end it returns zeros.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bits<'a> {
    pub(crate) bytes: &'a [u8],
    /// Index of the next bit.
    pub(crate) at: u32,
}

impl Bits<'_> {
    /// Returns the next 32 bits without reading them.
    pub(crate) fn peek(&self) -> u32 {
        let start = (self.at >> 3) as usize;
        let [a, b, c, d, e] = match self.bytes.get(start..).and_then(<[u8]>::first_chunk::<5>) {
            Some(chunk) => *chunk,
            None => self.last_bytes(start),
        };
        let part = self.at & 7;
        let behind = u32::from(e) >> 8u32.saturating_sub(part);
        (u32::from_be_bytes([a, b, c, d]) << part) | behind
    }

    // Never inlined: few reads are so near to the end, and the code of all other reads stays short.
    #[cold]
    fn last_bytes(&self, start: usize) -> [u8; 5] {
        let mut chunk = [0; 5];
        for (to, from) in chunk.iter_mut().zip(self.bytes.get(start..).unwrap_or_default()) {
            *to = *from;
        }
        chunk
    }

    pub(crate) fn skip(&mut self, count: u32) {
        self.at = self.at.saturating_add(count);
    }

    /// Reads a number of `width` bits, at most 31.
    pub(crate) fn number(&mut self, width: u32) -> u32 {
        let bits = self.peek().checked_shr(32u32.saturating_sub(width)).unwrap_or(0);
        self.skip(width);
        bits
    }

    /// Reads ones and the zero after them, and returns the number of ones; or reads `most` ones, without a zero.
    pub(crate) fn ones(&mut self, most: u32) -> u32 {
        let ones = self.peek().leading_ones();
        if ones < most {
            self.skip(ones.saturating_add(1));
            ones
        } else {
            self.skip(most);
            most
        }
    }

    /// Reads a number, at least 1, in Elias's gamma code.
    pub(crate) fn gamma(&mut self) -> u32 {
        let zeros = self.peek().leading_zeros().min(30);
        self.skip(zeros);
        self.number(zeros.saturating_add(1))
    }
}
