//! Image for QEMU's `mps2-an386` (Cortex-M4F): performs the baked show with each method and reports.
//!
//! Run it with `-icount shift=0`: one instruction then takes 1 ns of the machine's time, and its 25 MHz
//! `SysTick` counts once in 40 instructions. Sums over a whole run are exact to a fraction of an instruction
//! per tick. It counts instructions, not cycles: stalls and flash wait states are not there.
//!
//! A hash of all torques is compared with the host's; `cargo xtask parity` names what differs.

use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use sinew_firmware::show::Show;
use sinew_parity::replay::{METHODS, Replay, TorqueHash};

// `SHOW` and `CAPACITY`.
include!(concat!(env!("OUT_DIR"), "/baked.rs"));

const INSTRUCTIONS_PER_COUNT: u64 = 40;
const COUNTER_MASK: u32 = 0x00ff_ffff;

#[entry]
fn main() -> ! {
    match perform() {
        Ok(()) => debug::exit(debug::EXIT_SUCCESS),
        Err(problem) => {
            hprintln!("error: {}", problem);
            debug::exit(debug::EXIT_FAILURE);
        }
    }
    loop {
        cortex_m::asm::wfi();
    }
}

fn perform() -> Result<(), &'static str> {
    let mut peripherals = Peripherals::take().ok_or("the peripherals are taken")?;
    peripherals.SYST.set_clock_source(SystClkSource::Core);
    peripherals.SYST.set_reload(COUNTER_MASK);
    peripherals.SYST.clear_current();
    peripherals.SYST.enable_counter();

    let show = Show::parse(SHOW).map_err(|_| "the baked show is not valid")?;
    for name in METHODS {
        let mut replay =
            Replay::<CAPACITY>::new(show, name).map_err(|_| "the show's rig is not usable")?;
        let mut hash = TorqueHash::default();
        let (mut observe_counts, mut control_counts, mut most_counts) = (0u64, 0u64, 0u64);
        for tick in 0..show.frame_count() {
            let start = SYST::get_current();
            replay.observe(tick).map_err(|_| "a measured state was refused")?;
            let observed = SYST::get_current();
            let torques = replay.control();
            let end = SYST::get_current();
            // The counter runs down and wraps at 24 bits.
            let between = |start: u32, end: u32| u64::from(start.wrapping_sub(end) & COUNTER_MASK);
            observe_counts += between(start, observed);
            control_counts += between(observed, end);
            most_counts = most_counts.max(between(start, end));
            hash.update(torques);
        }
        let ticks = show.frame_count() as u64;
        hprintln!(
            "method={} ticks={} control={} observe={} worst={} hash={:016x}",
            name,
            ticks,
            control_counts * INSTRUCTIONS_PER_COUNT / ticks,
            observe_counts * INSTRUCTIONS_PER_COUNT / ticks,
            most_counts * INSTRUCTIONS_PER_COUNT,
            hash.value()
        );
    }
    Ok(())
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    hprintln!("{}", info);
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
