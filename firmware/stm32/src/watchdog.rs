//! The hardware watchdog (IWDG): short while torque may be on, longer than any erase while it is off.
//!
//! An erase stalls the processor for up to 2 s, and happens only while torque is off. So the time-out depends on that,
//! and not on the erase: the loop sets it as it switches outputs, and the watchdog takes it over as it is fed. Nothing
//! but a whole tick feeds it, here too. It counts a clock of its own, nominally 32 kHz: 17 to 47 kHz over all parts.

use core::sync::atomic::{AtomicBool, AtomicU8, Ordering};

use embassy_stm32::pac;
use embassy_stm32::pac::iwdg::vals::{Key, Pr};
use sinew_firmware::watchdog::Watchdog;

/// With torque, of 2 ms: 100 ms (68 to 190).
const SHORT: u16 = 50;
/// Without, of 2 ms: 4 s (2.7 to 7.5).
const LONG: u16 = 2000;

static IS_STARTED: AtomicBool = AtomicBool::new(false);
static IS_LONG: AtomicBool = AtomicBool::new(false);
/// Meals since it is long, up to 2.
static LONG_MEALS: AtomicU8 = AtomicU8::new(0);

/// Starts it, long. It cannot be stopped any more.
pub(crate) fn start() -> Watchdog<fn()> {
    pac::IWDG.kr().write(|w| w.set_key(Key::START));
    pac::IWDG.kr().write(|w| w.set_key(Key::ENABLE));
    pac::IWDG.pr().write(|w| w.set_pr(Pr::DIVIDE_BY64));
    IS_STARTED.store(true, Ordering::Relaxed);
    set(LONG);
    IS_LONG.store(true, Ordering::Relaxed);
    Watchdog::new(feed)
}

/// For outputs that are on, or off.
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
    // What is still on its way into the slow clock's domain is taken over by the next meal.
    if IS_LONG.load(Ordering::Relaxed) && !pac::IWDG.sr().read().rvu() {
        let meals = LONG_MEALS.load(Ordering::Relaxed);
        LONG_MEALS.store(meals.saturating_add(1).min(2), Ordering::Relaxed);
    }
    pac::IWDG.kr().write(|w| w.set_key(Key::RESET));
}

/// Waits until the long time-out counts. It does not come back if the loop stands still: then the watchdog bites.
pub(crate) fn wait_for_long() {
    while IS_STARTED.load(Ordering::Relaxed) && LONG_MEALS.load(Ordering::Relaxed) == 0 {
        core::hint::spin_loop();
    }
}
