//! Registers of the chip, and their bits.

pub(super) const MODE1: u8 = 0x00;
pub(super) const MODE2: u8 = 0x01;
/// First register of channel 0: `ON_L ON_H OFF_L OFF_H`. Each channel has 4 bytes.
pub(super) const CHANNEL_0: u8 = 0x06;
/// First of the 4 registers that write all channels at once.
pub(super) const ALL_CHANNELS: u8 = 0xFA;
pub(super) const ALL_CHANNELS_LAST: u8 = 0xFD;
pub(super) const PRESCALE: u8 = 0xFE;

pub(super) const RESTART: u8 = 1 << 7;
pub(super) const AUTO_INCREMENT: u8 = 1 << 5;
pub(super) const SLEEP: u8 = 1 << 4;
pub(super) const ALL_CALL: u8 = 1 << 0;
/// Bit of MODE2: totem-pole outputs. With this bit alone, outputs change at the stop of a write, and are low while OE
/// is high.
pub(super) const OUTDRV: u8 = 1 << 2;
/// Bit in the high byte of ON or OFF: the output is always on, or always off. OFF has priority.
pub(super) const FULL: u8 = 1 << 4;

pub(super) const CHANNELS: usize = 16;
/// Counts of one pulse period.
pub(super) const PERIOD: u16 = 4096;

/// The 4 bytes of a channel that gives no pulse.
pub(super) const OFF: [u8; 4] = [0, 0, 0, FULL];

/// Returns the first register of channel `index`.
pub(super) fn channel(index: usize) -> u8 {
    let offset = u8::try_from(index.min(CHANNELS.saturating_sub(1))).unwrap_or(0).saturating_mul(4);
    CHANNEL_0.saturating_add(offset)
}
