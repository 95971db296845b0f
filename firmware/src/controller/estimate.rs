//! Estimate of a board's computation time per tick.

/// Cycles of the loop's tick on a Cortex-M4F: a fixed number, and a number for each servo. They are a straight line
/// through the values of `budget.toml` for 6, 20 and 40 servos (`estimated_cycles.loop_recommended`: current mode,
/// `recommended`, all servos read in every tick). A test of `xtask` compares them. Cycles are the manual's cycles per
/// instruction, without wait states of the flash.
pub const TICK_CYCLES: [u32; 2] = [21_000, 16_200];

/// Ratio of instructions per tick in a board's image to those of [`TICK_CYCLES`], percent: a board's image is
/// optimized for size, the image of the estimate for speed. Measured: 220 and 208 for arms of 3 and 6 servos on the
/// emulated F446, 186 for 20 servos in QEMU.
const SMALL_PERCENT: u64 = 210;

/// Returns the computation time of a tick, without the bus, µs. It follows from [`TICK_CYCLES`], `SMALL_PERCENT`
/// and the processor's clock, Hz. O(1).
///
/// This is an estimate: a board measures its own time. `ControllerSettings::compute_us` should be at least as large.
pub fn estimated_us(servos: usize, clock_hz: u32) -> u32 {
    let [fixed, each] = TICK_CYCLES.map(u64::from);
    let servos = u64::try_from(servos).unwrap_or(u64::MAX);
    let cycles = fixed.saturating_add(each.saturating_mul(servos));
    let cycles = cycles.saturating_mul(SMALL_PERCENT) / 100;
    let us = cycles.saturating_mul(1_000_000).div_ceil(u64::from(clock_hz.max(1)));
    u32::try_from(us).unwrap_or(u32::MAX)
}
