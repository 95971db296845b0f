//! Time since the start, µs: TIM5, which has 32 bits and keeps counting while the processor is stalled.
//!
//! embassy-stm32's own driver counts half-periods of a 16-bit timer in the timer's interrupt, whichever timer it
//! uses. An erase of flash stalls the processor, interrupts too, for up to 2 s, and that driver stays behind
//! afterwards (a stall of 400 ms put it 330 ms behind). This driver only reads the counter. The counter must be read
//! once in 71 minutes, and a node reads it in every step.

use core::cell::Cell;
use core::task::Waker;

use critical_section::Mutex;
use embassy_stm32::{pac, peripherals, rcc};
use embassy_time_driver::Driver;

static CLOCK: Mutex<Cell<Extended>> = Mutex::new(Cell::new(Extended { last: 0, turns: 0 }));

#[derive(Clone, Copy)]
struct Extended {
    last: u32,
    turns: u32,
}

/// Starts the clock at 0.
pub fn start() {
    rcc::enable_and_reset::<peripherals::TIM5>();
    let ticks = rcc::frequency::<peripherals::TIM5>().0 / 1_000_000;
    pac::TIM5.psc().write_value(u16::try_from(ticks.saturating_sub(1)).unwrap_or(u16::MAX));
    pac::TIM5.arr().write_value(u32::MAX);
    pac::TIM5.egr().write(|w| w.set_ug(true));
    pac::TIM5.cr1().modify(|w| w.set_cen(true));
}

/// Returns the time since the start, µs. The control loop and the background task may both call it.
pub fn now_us() -> u64 {
    critical_section::with(|cs| {
        let clock = CLOCK.borrow(cs);
        let Extended { last, turns } = clock.get();
        let now = pac::TIM5.cnt().read();
        let turns = turns.wrapping_add(u32::from(now < last));
        clock.set(Extended { last: now, turns });
        u64::from(turns) << 32 | u64::from(now)
    })
}

/// Waits for a time in µs, without sleeping.
pub fn wait_us(us: u64) {
    let until = now_us().saturating_add(us);
    while now_us() < until {}
}

/// Time driver for embassy's I2C, which needs it for its time-out. Nothing sleeps on this board, so nothing is woken.
struct Hardware;

impl Driver for Hardware {
    fn now(&self) -> u64 {
        now_us()
    }
    fn schedule_wake(&self, _: u64, _: &Waker) {}
}

embassy_time_driver::time_driver_impl!(static DRIVER: Hardware = Hardware);
