//! How long a tick takes a board, by an estimate.

/// Cycles of a tick of the loop on a Cortex-M4F: so many, and so many for each servo. It is the line over what
/// `budget.toml` has of 6, 20 and 40 servos (`estimated_cycles.loop_recommended`: by current, `recommended`, all read
/// in every tick), which a test of `xtask` compares: instructions by the manual's cycles, without wait states of the
/// flash.
pub const TICK_CYCLES: [u32; 2] = [21_000, 15_900];

/// Boards' images are optimized for size, those that [`TICK_CYCLES`] are of for speed. So many per cent of their
/// instructions a tick takes: 220 and 208 of arms of 3 and 6 servos on the emulated F446, 186 of 20 servos in QEMU.
const SMALL_PERCENT: u64 = 210;

/// What a tick takes a board besides its bus, µs, by [`TICK_CYCLES`] and the size of its image, at the clock of its
/// processor, Hz. O(1).
///
/// An estimate: a board measures its own. It is what `ControllerSettings::compute_us` should be at least.
pub fn estimated_us(servos: usize, clock_hz: u32) -> u32 {
    let [fixed, each] = TICK_CYCLES.map(u64::from);
    let servos = u64::try_from(servos).unwrap_or(u64::MAX);
    let cycles = fixed.saturating_add(each.saturating_mul(servos));
    let cycles = cycles.saturating_mul(SMALL_PERCENT) / 100;
    let us = cycles.saturating_mul(1_000_000).div_ceil(u64::from(clock_hz.max(1)));
    u32::try_from(us).unwrap_or(u32::MAX)
}
