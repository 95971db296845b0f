//! A channel during playing: six knots around a position, and the place to read the next knots.

use crate::error::ShowError;
use crate::layout::ChannelRecord;
use crate::position::Position;
use crate::show::Show;
use crate::span::{Cubic, Jet};
use crate::span_lengths::{RUNGS, span};

/// Number of ones that announces a residual stored as a whole number.
pub(crate) const ESCAPE: u32 = 16;
/// Number of ones that announces a rung stored as a whole number.
pub(crate) const RUNG_ESCAPE: u32 = 10;
/// Number of bits of a rung that is stored as a whole number.
pub(crate) const RUNG_WIDTH: u32 = 5;

/// The knots for the span of a position. The span starts at `knots[2]` and ends at `knots[3]`.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Channel {
    knots: [i32; 6],
    controls: [i32; 6],
    cubic: Cubic,
    code: Code,
    /// Index of the block that is being read.
    block: u32,
    /// Index of the next bit in the block. `end` is the index of the first bit after the channel's bits. If both are 0,
    /// nothing was read yet.
    at: u32,
    end: u32,
    /// Whether the block that is being read belongs to the next round of a looped show.
    ahead: bool,
}

/// The context that predicts the next knot.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Code {
    pub(crate) rung: u8,
    /// Running mean of residuals, in sixteenths.
    pub(crate) mean: u32,
    /// The control value before the last.
    pub(crate) before: i32,
    /// The last control value.
    pub(crate) last: i32,
}

impl Code {
    /// Returns the context after the first knot of a block.
    pub(crate) fn first(record: &ChannelRecord, rung: u8, control: i32) -> Self {
        Self { rung, mean: u32::from(record.mean) << 4, before: control, last: control }
    }

    /// Returns the expected next control value.
    pub(crate) fn expected(&self, record: &ChannelRecord) -> i32 {
        let slope = self.last.wrapping_sub(self.before).wrapping_mul(i32::from(record.trend));
        self.last.wrapping_add(slope >> 4)
    }

    /// Returns the number of low bits of a residual that are stored directly.
    pub(crate) fn low_bits(self) -> u32 {
        // About the logarithm of half the mean: half of all prefixes are then a single bit.
        32u32.saturating_sub((self.mean >> 5).leading_zeros()).min(24)
    }

    /// Updates the context with a control value and its residual, mapped to 0, 1, 2, ...
    pub(crate) fn learn(&mut self, mapped: u32, control: i32) {
        let kept = self.mean.saturating_sub(self.mean >> 2);
        self.mean = kept.saturating_add(mapped.min(1 << 24) << 2);
        (self.before, self.last) = (self.last, control);
    }
}

impl Channel {
    /// Prepares for a position within the show. Amortised O(1) from tick to tick, O(block) for a jump.
    #[inline]
    pub(crate) fn seek(
        &mut self,
        show: &Show<'_>,
        index: usize,
        position: Position,
        checked: &mut Checked,
    ) -> Result<(), ShowError> {
        let sample = position.sample().cast_signed();
        let [_, _, from, to, ..] = self.knots;
        if sample < from || sample >= to { self.go(show, index, sample, checked) } else { Ok(()) }
    }

    /// Returns the curve at a prepared position: value, and derivatives per sample.
    #[inline]
    pub(crate) fn at(&self, position: Position) -> Jet {
        let [_, _, from, ..] = self.knots;
        self.cubic.at(position.since(from))
    }

    /// Moves the knots to the span of a sample.
    #[inline(never)]
    fn go(
        &mut self,
        show: &Show<'_>,
        index: usize,
        sample: i32,
        checked: &mut Checked,
    ) -> Result<(), ShowError> {
        let from = Source { show, index, record: show.channel(index) };
        let moved = self.move_to(&from, sample, checked);
        if moved.is_err() {
            // The channel starts again at the next request.
            *self = Self::default();
        }
        moved
    }

    fn move_to(
        &mut self,
        from: &Source<'_>,
        sample: i32,
        checked: &mut Checked,
    ) -> Result<(), ShowError> {
        let block = from.show.block_of(sample);
        let is_behind = block > self.block && !self.ahead;
        if self.end == 0 || is_behind || sample < self.knots[2] {
            *self = Self { block, ..Self::default() };
            self.open(from, checked)?;
            for _ in 1..6 {
                self.next(from, checked)?;
            }
            if sample < self.knots[2] {
                return Err(self.broken(from));
            }
        }
        while sample >= self.knots[3] {
            self.next(from, checked)?;
        }
        let [_, c1, c2, c3, c4, _] = self.controls;
        self.cubic = Cubic::new(&self.knots, [c1, c2, c3, c4], from.record.step);
        Ok(())
    }

    /// Reads the first knot of the channel in a block.
    fn open(&mut self, from: &Source<'_>, checked: &mut Checked) -> Result<(), ShowError> {
        let Source { show, index, record } = from;
        checked.pass(show, self.block)?;
        let (mut bits, end) = show.stream(self.block, *index);
        let start = self.block.saturating_mul(u32::from(show.header().block)).cast_signed();
        let knot = start.saturating_sub(bits.gamma().cast_signed());
        let round = if self.ahead { show.length().cast_signed() } else { 0 };
        let control = record.whole(bits.number(record.width()));
        self.code = Code::first(record, rung(bits.number(RUNG_WIDTH)), control);
        (self.at, self.end) = (bits.at, end);
        if self.at > self.end {
            return Err(self.broken(from));
        }
        self.push(record, knot.saturating_add(round), control);
        Ok(())
    }

    /// Reads the next knot.
    fn next(&mut self, from: &Source<'_>, checked: &mut Checked) -> Result<(), ShowError> {
        let Source { show, record, .. } = from;
        let last = self.knots[5];
        if self.at == self.end {
            self.block = self.block.saturating_add(1);
            if self.block == show.block_count() && show.is_loop() && !self.ahead {
                self.ahead = true;
                self.block = 0;
            }
            if self.block >= show.block_count() {
                return Err(self.broken(from));
            }
            self.open(from, checked)?;
        } else {
            let mut bits = show.bits(self.block, self.at);
            self.code.rung = match bits.ones(RUNG_ESCAPE) {
                RUNG_ESCAPE => rung(bits.number(RUNG_WIDTH)),
                change => {
                    let changed = i32::from(self.code.rung).saturating_add(unmapped(change));
                    u8::try_from(changed).unwrap_or(0).min(RUNGS - 1)
                }
            };
            let expected = self.code.expected(record);
            let (control, residual) = match bits.ones(ESCAPE) {
                ESCAPE => {
                    let control = record.whole(bits.number(record.width()));
                    (control, mapped(control.wrapping_sub(expected)))
                }
                high => {
                    let low = self.code.low_bits();
                    let residual = (high << low) | bits.number(low);
                    (record.clamp(expected.wrapping_add(unmapped(residual))), residual)
                }
            };
            self.code.learn(residual, control);
            self.at = bits.at;
            if self.at > self.end {
                return Err(self.broken(from));
            }
            self.push(record, last.saturating_add(span(self.code.rung)), control);
        }
        if self.knots[5] > last { Ok(()) } else { Err(self.broken(from)) }
    }

    fn push(&mut self, record: &ChannelRecord, knot: i32, control: i32) {
        let flips = self.ahead && record.flips;
        let control = if flips { control.wrapping_neg() } else { control };
        let [_, k1, k2, k3, k4, k5] = self.knots;
        self.knots = [k1, k2, k3, k4, k5, knot];
        let [_, c1, c2, c3, c4, c5] = self.controls;
        self.controls = [c1, c2, c3, c4, c5, control];
    }

    fn broken(&self, from: &Source<'_>) -> ShowError {
        ShowError::Broken { block: self.block, channel: from.index }
    }
}

/// The last two blocks whose CRCs were checked: two, because channels cross a block border at different times.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Checked([u32; 2]);

impl Checked {
    pub(crate) const NONE: Self = Self([u32::MAX; 2]);

    fn pass(&mut self, show: &Show<'_>, block: u32) -> Result<(), ShowError> {
        if !self.0.contains(&block) {
            show.check_block(block)?;
            let [last, _] = self.0;
            self.0 = [block, last];
        }
        Ok(())
    }
}

/// The show, the index and the parameters of the channel that is read.
struct Source<'a> {
    show: &'a Show<'a>,
    index: usize,
    record: ChannelRecord,
}

fn rung(bits: u32) -> u8 {
    u8::try_from(bits).unwrap_or(RUNGS).min(RUNGS - 1)
}

/// Maps 0, -1, 1, -2, 2 to 0, 1, 2, 3, 4.
pub(crate) fn mapped(number: i32) -> u32 {
    ((number << 1) ^ (number >> 31)).cast_unsigned()
}

/// Returns the inverse of [`mapped`].
pub(crate) fn unmapped(mapped: u32) -> i32 {
    (mapped >> 1).cast_signed() ^ (mapped & 1).cast_signed().wrapping_neg()
}
