//! Image for ST's NUCLEO-F446RE: the control tick at the show's rate, and a breathing status light.
//!
//! Two executors: the tick runs in an interrupt of high priority and pre-empts everything else, woken by the
//! hardware timer behind `embassy-time` (TIM5); the light (LD2 on PA5, TIM2 channel 1) runs in thread mode.
//! The independent watchdog is fed by a completed, valid tick alone ([`Watchdog`] takes nothing else): without one the
//! board resets within [`WATCHDOG_US`].
//!
//! Not there yet: servos. Until a bus is driven, the measured joints are those of the stand-in
//! ([`sinew_parity::replay`]), and the torques go nowhere but the log.

#![expect(
    unsafe_code,
    reason = "the interrupt that drives the control executor; its macro copies the function"
)]

use defmt_rtt as _;
use embassy_executor::{InterruptExecutor, Spawner};
use embassy_stm32::Peri;
use embassy_stm32::gpio::OutputType;
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::peripherals::{IWDG, PA5, TIM2};
use embassy_stm32::time::hz;
use embassy_stm32::timer::low_level::CountingMode;
use embassy_stm32::timer::simple_pwm::{PwmPin, SimplePwm};
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_time::{Duration, Instant, Ticker};
use panic_probe as _;
use sinew_core::tracker::MethodName;
use sinew_firmware::indicator;
use sinew_firmware::show::Show;
use sinew_firmware::watchdog::Watchdog;
use sinew_parity::replay::Replay;
use static_cell::StaticCell;

// `SHOW` and `CAPACITY`.
include!(concat!(env!("OUT_DIR"), "/baked.rs"));

/// Ten ticks of 10 ms: long enough for a debugger's hiccup, short enough that servos cannot run away.
const WATCHDOG_US: u32 = 100_000;

/// The PWM's steps are those of [`indicator::breath`]; 500 Hz does not flicker.
const LIGHT_HZ: u32 = 500;

static CONTROL: InterruptExecutor = InterruptExecutor::new();
static REPLAY: StaticCell<Replay<'static, CAPACITY>> = StaticCell::new();

/// An interrupt that no peripheral of this board uses: software raises it to run the control executor.
#[embassy_stm32::interrupt]
unsafe fn UART5() {
    // SAFETY: called from the interrupt that `CONTROL` was started with.
    unsafe { CONTROL.on_interrupt() }
}

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let peripherals = embassy_stm32::init(embassy_stm32::Config::default());

    let show = defmt::unwrap!(Show::parse(SHOW).ok(), "the baked show is not valid");
    let replay = Replay::new(show, MethodName::LinearCompensation).ok();
    let replay = REPLAY.init(defmt::unwrap!(replay, "the show's rig is not usable"));
    defmt::info!("{} bodies, {} frames", show.body_count(), show.frame_count());

    interrupt::UART5.set_priority(Priority::P6);
    let control = CONTROL.start(interrupt::UART5);
    control.spawn(defmt::unwrap!(run_control(replay, show, peripherals.IWDG)));
    spawner.spawn(defmt::unwrap!(run_light(peripherals.TIM2, peripherals.PA5)));
}

/// The control tick. Deadline: the show's time step; a tick that misses it makes the next one start late,
/// and a stuck one lets the watchdog bite.
#[embassy_executor::task]
async fn run_control(
    replay: &'static mut Replay<'static, CAPACITY>,
    show: Show<'static>,
    iwdg: Peri<'static, IWDG>,
) {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a positive step")]
    let period_us = (show.dt_s() * 1e6) as u64;
    let mut ticker = Ticker::every(Duration::from_micros(period_us));
    let mut watchdog = unleash(iwdg);
    let mut tick = 0u32;
    loop {
        ticker.next().await;
        let start = Instant::now();
        match replay.step(tick) {
            Ok(asked) => {
                let limited =
                    asked.torques().iter().filter(|torque| torque.reason.is_some()).count();
                if tick.is_multiple_of(100) {
                    let took_us = start.elapsed().as_micros();
                    defmt::info!("tick {}: {} us, {} limited", tick, took_us, limited);
                }
                watchdog.feed(asked.into());
            }
            Err(error) => defmt::error!("tick {}: no torques: {}", tick, error),
        }
        // To the show's end and no further: its last frame is held. Starting over would be a jump.
        tick = tick.saturating_add(1);
    }
}

/// The watchdog, running: from here on the board must have a tick within [`WATCHDOG_US`], again and again.
fn unleash(iwdg: Peri<'static, IWDG>) -> Watchdog<impl FnMut()> {
    let mut iwdg = IndependentWatchdog::new(iwdg, WATCHDOG_US);
    iwdg.unleash();
    Watchdog::new(move || iwdg.pet())
}

#[embassy_executor::task]
async fn run_light(timer: Peri<'static, TIM2>, pin: Peri<'static, PA5>) {
    let pin = PwmPin::new(pin, OutputType::PushPull);
    let mut pwm = SimplePwm::new(
        timer,
        Some(pin),
        None,
        None,
        None,
        hz(LIGHT_HZ),
        CountingMode::EdgeAlignedUp,
    );
    let mut light = pwm.ch1();
    light.enable();
    let mut ticker = Ticker::every(Duration::from_millis(20));
    loop {
        ticker.next().await;
        let now_ms = Instant::now().as_millis() % 0x1_0000_0000;
        let duty = indicator::breath(u32::try_from(now_ms).unwrap_or_default());
        light.set_duty_cycle_fraction(u32::from(duty), u32::from(u8::MAX));
    }
}
