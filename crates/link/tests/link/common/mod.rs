//! Random messages, and frames encoded by their definition.

#![expect(clippy::cast_possible_truncation, reason = "random bits are cut to any width")]

pub(crate) mod messages;
pub(crate) mod wire;

/// A pseudo-random generator with a seed (`SplitMix64`).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.next() % count as u64) as usize
    }

    pub(crate) fn chance(&mut self, part: f64) -> bool {
        self.unit() < part
    }

    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns a random number with a random maximum length of 1 to 32 bits, so that small numbers are frequent, too.
    pub(crate) fn bits(&mut self) -> u32 {
        let shift = self.below(32);
        (self.next() as u32) >> shift
    }

    pub(crate) fn finite(&mut self) -> f32 {
        loop {
            let number = f32::from_bits(self.next() as u32);
            if number.is_finite() {
                return number;
            }
        }
    }

    pub(crate) fn maybe<T>(&mut self, item: impl FnOnce(&mut Self) -> T) -> Option<T> {
        if self.chance(0.5) { Some(item(self)) } else { None }
    }

    pub(crate) fn list<T, const N: usize>(
        &mut self,
        mut item: impl FnMut(&mut Self) -> T,
    ) -> heapless::Vec<T, N> {
        // Mostly short lists, as on a real line, but full ones, too.
        let most = if self.chance(0.1) { N } else { N.min(12) };
        (0..self.below(most + 1)).map(|_| item(self)).collect()
    }

    pub(crate) fn bytes<const N: usize>(&mut self) -> heapless::Vec<u8, N> {
        self.list(|random| if random.chance(0.3) { 0 } else { random.next() as u8 })
    }

    pub(crate) fn text<const N: usize>(&mut self) -> heapless::String<N> {
        // No character takes more than two bytes.
        (0..self.below(N / 2 + 1)).map(|_| ['a', 'é', '7', '"'][self.below(4)]).collect()
    }
}
