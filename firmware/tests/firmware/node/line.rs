//! A line that loses, repeats, delays and damages frames.

use std::collections::VecDeque;

/// Errors of a line, per 1000 frames.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Trouble {
    pub(crate) lost: u64,
    pub(crate) twice: u64,
    pub(crate) flipped: u64,
    /// Maximum delay, us. Frames may overtake each other.
    pub(crate) jitter_us: u64,
}

/// A bad line: one frame in ten is lost, one in twenty arrives twice, one in twenty is damaged, and frames overtake
/// each other.
pub(crate) const BAD: Trouble = Trouble { lost: 100, twice: 50, flipped: 50, jitter_us: 10_000 };

/// One direction of the host link.
#[derive(Debug, Default)]
pub(crate) struct Line {
    pub(crate) trouble: Trouble,
    random: u64,
    under_way: Vec<(u64, Vec<u8>)>,
    pub(crate) bytes: VecDeque<u8>,
    pub(crate) frames: u64,
}

/// Returns the next number of a `SplitMix64` generator.
pub(crate) fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mixed = (*state ^ (*state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    mixed ^ (mixed >> 31)
}

impl Line {
    pub(crate) fn new(trouble: Trouble, seed: u64) -> Self {
        Self { trouble, random: seed, ..Self::default() }
    }

    fn happens(&mut self, in_thousand: u64) -> bool {
        random(&mut self.random) % 1000 < in_thousand
    }

    /// Sends a frame.
    pub(crate) fn send(&mut self, frame: &[u8], now_us: u64) {
        let Trouble { lost, twice, flipped, jitter_us } = self.trouble;
        let times = u32::from(!self.happens(lost)) + u32::from(self.happens(twice));
        for _ in 0..times {
            let mut frame = frame.to_vec();
            if self.happens(flipped) {
                let bit = random(&mut self.random) as usize % (8 * frame.len());
                frame[bit / 8] ^= 1 << (bit % 8);
            }
            let late_us = random(&mut self.random) % (jitter_us + 1);
            self.frames += 1;
            self.under_way.push((now_us + late_us, frame));
        }
    }

    /// Delivers the frames that are due.
    pub(crate) fn arrive(&mut self, now_us: u64) {
        let (mut come, rest): (Vec<_>, Vec<_>) =
            self.under_way.drain(..).partition(|(due, _)| *due <= now_us);
        self.under_way = rest;
        come.sort_by_key(|(due, _)| *due);
        self.bytes.extend(come.into_iter().flat_map(|(_, frame)| frame));
    }
}
