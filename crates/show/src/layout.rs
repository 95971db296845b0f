//! The head of a show, field by field: see docs/show-format.md.

use crate::error::ShowError;
use crate::position::Rate;
use crate::time_code::TimeCode;

pub(crate) const MAGIC: [u8; 4] = *b"SNWS";
pub(crate) const VERSION: u16 = 2;
pub(crate) const HEADER_LEN: usize = 56;
pub(crate) const CHANNEL_LEN: usize = 16;
pub(crate) const CRC_LEN: usize = 4;
/// Minimum length of a block, in bytes: its CRC, and the width of its table.
pub(crate) const BLOCK_HEAD_LEN: u32 = 5;

/// Flag of a looped show, which continues from its end to its start.
pub(crate) const LOOP: u16 = 1;
/// Flag of a show that is slower than its performance: the head contains its time map, the course.
pub(crate) const SLOWED: u16 = 2;
/// Maximum length of a show, in samples.
pub(crate) const LONGEST: u32 = 1 << 30;
/// Minimum length of a block, in samples.
pub(crate) const SHORTEST_BLOCK: u16 = 16;
/// Maximum absolute control value, in steps: whole numbers up to it are exact in f32.
pub(crate) const LARGEST_CONTROL: i32 = 1 << 22;
/// Maximum absolute coordinate, rad or m: the core's limit.
pub(crate) const LARGEST: f32 = 1e6;

/// The fixed part of the head.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Header {
    pub(crate) flags: u16,
    pub(crate) total_len: u32,
    /// Length of the head without its CRC, in bytes.
    pub(crate) head_len: u32,
    pub(crate) rig: u32,
    pub(crate) rate: Rate,
    pub(crate) length: u32,
    pub(crate) block: u16,
    pub(crate) joints: u16,
    pub(crate) channels: u16,
    pub(crate) cues: u16,
    pub(crate) cues_len: u16,
    pub(crate) time_code: Option<TimeCode>,
    pub(crate) error_rad: f32,
    pub(crate) error_m: f32,
}

impl Header {
    pub(crate) fn read(raw: &[u8; HEADER_LEN]) -> Self {
        Self {
            flags: u16_at(raw, 6),
            total_len: u32_at(raw, 8),
            head_len: u32_at(raw, 12),
            rig: u32_at(raw, 16),
            rate: Rate { samples: u32_at(raw, 20), seconds: u32_at(raw, 24) },
            length: u32_at(raw, 28),
            block: u16_at(raw, 32),
            joints: u16_at(raw, 34),
            channels: u16_at(raw, 36),
            cues: u16_at(raw, 38),
            cues_len: u16_at(raw, 40),
            time_code: TimeCode::read([42, 43, 44, 45, 46, 47].map(|at| u8_at(raw, at))),
            error_rad: f32::from_bits(u32_at(raw, 48)),
            error_m: f32::from_bits(u32_at(raw, 52)),
        }
    }

    #[cfg(feature = "std")]
    pub(crate) fn write(&self, to: &mut Vec<u8>) {
        to.extend(MAGIC);
        to.extend(VERSION.to_le_bytes());
        to.extend(self.flags.to_le_bytes());
        let words = [self.total_len, self.head_len, self.rig, self.rate.samples, self.rate.seconds];
        to.extend(words.into_iter().chain([self.length]).flat_map(u32::to_le_bytes));
        let counts = [self.block, self.joints, self.channels, self.cues, self.cues_len];
        to.extend(counts.into_iter().flat_map(u16::to_le_bytes));
        to.extend(TimeCode::write(self.time_code));
        to.extend([self.error_rad, self.error_m].into_iter().flat_map(f32::to_le_bytes));
    }

    pub(crate) fn check(&self) -> Result<(), ShowError> {
        let fields = [
            ("flags", u32::from(self.flags), 0, u32::from(LOOP | SLOWED)),
            ("numerator of rate", self.rate.samples, 1, Rate::MOST_SAMPLES),
            ("denominator of rate", self.rate.seconds, 1, Rate::MOST_SECONDS),
            ("length", self.length, 1, LONGEST),
            ("samples of block", u32::from(self.block), u32::from(SHORTEST_BLOCK), u32::MAX),
            ("number of channels", u32::from(self.channels), 1, u32::MAX),
            // Positions of bits are counted in u32.
            ("length in bytes", self.total_len, 0, 1 << 28),
        ];
        for (what, found, least, most) in fields {
            if found < least || found > most {
                return Err(ShowError::Field { what, index: 0, found });
            }
        }
        Ok(())
    }

    pub(crate) fn is_loop(&self) -> bool {
        self.flags & LOOP != 0
    }

    pub(crate) fn is_slowed(&self) -> bool {
        self.flags & SLOWED != 0
    }

    pub(crate) fn block_count(&self) -> u32 {
        self.length.div_ceil(u32::from(self.block).max(1))
    }
}

/// Parameters of a channel's control values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ChannelRecord {
    /// Size of one step of a control value: in rad, in m, or, for a component of a quaternion, without a unit.
    pub(crate) step: f32,
    /// Minimum of all control values.
    pub(crate) least: i32,
    /// Maximum of all control values.
    pub(crate) most: i32,
    /// Running mean of the residuals at the start of each block.
    pub(crate) mean: u8,
    /// Share of the last slope that is expected to continue, in sixteenths.
    pub(crate) trend: u8,
    /// Whether the channel's sign changes in every other round of a looped show.
    pub(crate) flips: bool,
}

impl ChannelRecord {
    pub(crate) fn read(raw: &[u8; CHANNEL_LEN]) -> Self {
        Self {
            step: f32::from_bits(u32_at(raw, 0)),
            least: u32_at(raw, 4).cast_signed(),
            most: u32_at(raw, 8).cast_signed(),
            mean: u8_at(raw, 12),
            trend: u8_at(raw, 13),
            flips: u8_at(raw, 14) == 1,
        }
    }

    #[cfg(feature = "std")]
    pub(crate) fn write(&self, to: &mut Vec<u8>) {
        to.extend(self.step.to_le_bytes());
        to.extend(self.least.to_le_bytes());
        to.extend(self.most.to_le_bytes());
        to.extend([self.mean, self.trend, u8::from(self.flips), 0]);
    }

    pub(crate) fn check(&self, index: usize) -> Result<(), ShowError> {
        let range = -LARGEST_CONTROL..=LARGEST_CONTROL;
        if !(range.contains(&self.least) && range.contains(&self.most) && self.least <= self.most) {
            let found = self.least.cast_unsigned();
            return Err(ShowError::Field { what: "range of channel", index, found });
        }
        let largest = self.step * self.least.unsigned_abs().max(self.most.unsigned_abs()) as f32;
        // Written so that NaN is refused. At the minimum step no acceleration overflows f32.
        if !(self.step >= f32::MIN_POSITIVE && largest <= LARGEST) {
            let found = self.step.to_bits();
            return Err(ShowError::Field { what: "step of channel", index, found });
        }
        Ok(())
    }

    /// Returns a control value from its whole-number form.
    pub(crate) fn whole(&self, bits: u32) -> i32 {
        self.clamp(self.least.wrapping_add(bits.cast_signed()))
    }

    pub(crate) fn clamp(&self, control: i32) -> i32 {
        control.max(self.least).min(self.most)
    }

    /// Returns the number of bits of a control value in whole-number form.
    pub(crate) fn width(&self) -> u32 {
        let range = self.most.wrapping_sub(self.least).cast_unsigned();
        32u32.saturating_sub(range.leading_zeros())
    }
}

fn u8_at(raw: &[u8], at: usize) -> u8 {
    raw.get(at).copied().unwrap_or_default()
}

fn u16_at(raw: &[u8], at: usize) -> u16 {
    let field = raw.get(at..).and_then(<[u8]>::first_chunk::<2>);
    field.map_or(0, |field| u16::from_le_bytes(*field))
}

fn u32_at(raw: &[u8], at: usize) -> u32 {
    let field = raw.get(at..).and_then(<[u8]>::first_chunk::<4>);
    field.map_or(0, |field| u32::from_le_bytes(*field))
}
