//! The hardware watchdog (IWDG). Its time-out is short while torque may be on, and longer than any erase while it is
//! off.
//!
//! An erase stalls the processor for up to 2 s, and happens only while torque is off. The time-out therefore depends
//! on torque, not on the erase: the loop sets it when it switches the outputs, and the watchdog applies it when it is
//! fed. Only a complete tick feeds it. The watchdog counts its own clock, nominally 32 kHz: 17 to 47 kHz over all
//! chips.

use core::sync::atomic::{AtomicBool, AtomicU8, Ordering};

use embassy_stm32::pac;
use embassy_stm32::pac::iwdg::vals::{Key, Pr};
use sinew_firmware::watchdog::Watchdog;

/// Time-out while torque may be on, in units of 2 ms: 100 ms (68 to 190 ms).
const SHORT: u16 = 50;
/// Time-out while torque is off, in units of 2 ms: 4 s (2.7 to 7.5 s).
const LONG: u16 = 2000;

static IS_STARTED: AtomicBool = AtomicBool::new(false);
static IS_LONG: AtomicBool = AtomicBool::new(false);
/// Number of feeds since the time-out was set to the long value, up to 2.
static LONG_MEALS: AtomicU8 = AtomicU8::new(0);

/// Starts the watchdog with the long time-out. It cannot be stopped again.
pub(crate) fn start() -> Watchdog<fn()> {
    pac::IWDG.kr().write(|w| w.set_key(Key::START));
    pac::IWDG.kr().write(|w| w.set_key(Key::ENABLE));
    pac::IWDG.pr().write(|w| w.set_pr(Pr::DIVIDE_BY64));
    IS_STARTED.store(true, Ordering::Relaxed);
    set(LONG);
    IS_LONG.store(true, Ordering::Relaxed);
    Watchdog::new(feed)
}

/// Sets the time-out for outputs that are on or off.
pub(crate) fn for_outputs(on: bool) {
    if IS_LONG.swap(!on, Ordering::Relaxed) == on {
        LONG_MEALS.store(0, Ordering::Relaxed);
        set(if on { SHORT } else { LONG });
    }
}

fn set(reload: u16) {
    pac::IWDG.kr().write(|w| w.set_key(Key::ENABLE));
    pac::IWDG.rlr().write(|w| w.set_rl(reload));
}

fn feed() {
    // A time-out that is still being transferred to the slow clock's domain is applied at the next feed.
    if IS_LONG.load(Ordering::Relaxed) && !pac::IWDG.sr().read().rvu() {
        let meals = LONG_MEALS.load(Ordering::Relaxed);
        LONG_MEALS.store(meals.saturating_add(1).min(2), Ordering::Relaxed);
    }
    pac::IWDG.kr().write(|w| w.set_key(Key::RESET));
}

/// Waits until the long time-out is applied. Does not return if the loop has stopped: then the watchdog resets the
/// chip.
pub(crate) fn wait_for_long() {
    while IS_STARTED.load(Ordering::Relaxed) && LONG_MEALS.load(Ordering::Relaxed) == 0 {
        core::hint::spin_loop();
    }
}
