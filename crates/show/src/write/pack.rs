//! Packs curves into blocks of bytes. In a block, each channel begins two knots before the span in which the block
//! starts.

use super::curve::Curve;
use crate::channel::{Code, ESCAPE, RUNG_ESCAPE, RUNG_WIDTH, mapped};
use crate::layout::ChannelRecord;
use crate::show::CHECKSUM;
use crate::span_lengths::{RUNGS, span};

/// A writer of bits in the order of bytes, the most significant bit first.
#[derive(Debug, Clone, Default)]
pub(super) struct BitWriter {
    pub(super) bytes: Vec<u8>,
    pub(super) count: u32,
}

impl BitWriter {
    pub(super) fn number(&mut self, number: u32, width: u32) {
        let mut left = width;
        while left > 0 {
            let used = self.count % 8;
            if used == 0 {
                self.bytes.push(0);
            }
            // The number of bits that the last byte has room for.
            let now = left.min(8 - used);
            left -= now;
            let bits = number >> left & ((1 << now) - 1);
            if let Some(last) = self.bytes.last_mut() {
                *last |= (bits << (8 - used - now)).to_le_bytes()[0];
            }
            self.count += now;
        }
    }

    fn ones(&mut self, ones: u32) {
        self.number(u32::MAX, ones);
    }

    fn gamma(&mut self, number: u32) {
        let zeros = number.ilog2();
        self.number(0, zeros);
        self.number(number, zeros + 1);
    }

    fn append(&mut self, other: &Self) {
        for place in 0..other.count {
            let byte = other.bytes[(place / 8) as usize];
            self.number(u32::from(byte >> (7 - place % 8)), 1);
        }
    }
}

fn rung_of(length: i32) -> u8 {
    (0..RUNGS).find(|rung| span(*rung) == length).expect("spans are laid from the ladder")
}

/// Writes a channel's knots in a block that starts at `start`.
fn stream(record: &ChannelRecord, knots: &[i32], controls: &[i32], start: i32, to: &mut BitWriter) {
    let whole = |control: i32| (control - record.least).unsigned_abs();
    let gap = knots.get(1).map_or(1, |next| next - knots[0]);
    let rung = if gap > span(RUNGS - 1) { 0 } else { rung_of(gap) };
    to.gamma((start - knots[0]).unsigned_abs());
    to.number(whole(controls[0]), record.width());
    to.number(u32::from(rung), RUNG_WIDTH);
    let mut code = Code::first(record, rung, controls[0]);
    for (knots, control) in knots.windows(2).zip(&controls[1..]) {
        let rung = rung_of(knots[1] - knots[0]);
        let change = mapped(i32::from(rung) - i32::from(code.rung));
        if change < RUNG_ESCAPE {
            to.ones(change);
            to.number(0, 1);
        } else {
            to.ones(RUNG_ESCAPE);
            to.number(u32::from(rung), RUNG_WIDTH);
        }
        code.rung = rung;
        let residual = mapped(control - code.expected(record));
        let low = code.low_bits();
        if residual >> low < ESCAPE {
            to.ones(residual >> low);
            to.number(0, 1);
            to.number(residual & ((1 << low) - 1), low);
        } else {
            to.ones(ESCAPE);
            to.number(whole(*control), record.width());
        }
        code.learn(residual, *control);
    }
}

/// Returns the index of each block's first knot: two before the span in which the block starts.
fn firsts(curve: &Curve, block: i32, blocks: i32) -> Vec<usize> {
    let mut firsts: Vec<usize> = (0..blocks)
        .map(|k| curve.knots.partition_point(|knot| *knot <= k * block).saturating_sub(3))
        .collect();
    firsts.push(curve.knots.len());
    firsts
}

/// Returns the bits of a channel, by block.
pub(super) fn streams(
    record: &ChannelRecord,
    curve: &Curve,
    block: i32,
    blocks: i32,
) -> Vec<BitWriter> {
    let firsts = firsts(curve, block, blocks);
    firsts
        .windows(2)
        .zip(0..)
        .map(|(range, k)| {
            let mut bits = BitWriter::default();
            let range = range[0]..range[1];
            stream(
                record,
                &curve.knots[range.clone()],
                &curve.controls[range],
                k * block,
                &mut bits,
            );
            bits
        })
        .collect()
}

/// Returns the parameters of a channel: of the tried ones, those that give the fewest bits.
pub(super) fn record(
    curve: &Curve,
    step: f32,
    flips: bool,
    block: i32,
    blocks: i32,
) -> ChannelRecord {
    let controls = &curve.controls;
    let (mut least, mut most) = controls
        .iter()
        .fold((i32::MAX, i32::MIN), |(least, most), c| (least.min(*c), most.max(*c)));
    if flips {
        most = most.abs().max(least.abs());
        least = -most;
    }
    let with = |trend: u8, mean: u8| ChannelRecord { step, least, most, mean, trend, flips };
    let bits = |record: &ChannelRecord| -> u32 {
        streams(record, curve, block, blocks).iter().map(|bits| bits.count).sum()
    };
    let trend = (0..=16).step_by(2).min_by_key(|trend| bits(&with(*trend, 16))).unwrap_or(0);
    let mean =
        [0, 2, 4, 8, 16, 32, 64, 128, 255].into_iter().min_by_key(|mean| bits(&with(trend, *mean)));
    with(trend, mean.unwrap_or(0))
}

/// Returns a block with the bits of all channels.
pub(super) fn block(channels: &[&BitWriter]) -> Vec<u8> {
    let longest = channels.iter().map(|bits| bits.count).max().unwrap_or(0);
    let width = 32 - longest.leading_zeros();
    let mut content = BitWriter::default();
    content.number(width, 5);
    for bits in channels {
        content.number(bits.count, width);
    }
    for bits in channels {
        content.append(bits);
    }
    let mut block = CHECKSUM.checksum(&content.bytes).to_le_bytes().to_vec();
    block.extend(content.bytes);
    block
}
