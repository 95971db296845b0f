//! Image for QEMU's `mps2-an386` (Cortex-M4F): performs a show of the human figure with each method and reports.
//!
//! `SINEW_RIG` and `SINEW_SHOW` are the absolute paths of the files that are built in: the figure in a rig's compact
//! form, and a show of its coordinates. `cargo xtask firmware` makes both.
//!
//! Run it with `-icount shift=0`: one instruction then takes 1 ns of the machine's time, and its 25 MHz `SysTick`
//! counts once in 40 instructions. Sums over a whole run are exact to a fraction of an instruction per tick. The
//! image counts instructions, not cycles: stalls and flash wait states are not emulated.
//!
//! A hash of all torques is compared with the host's; `cargo xtask parity` reports the first difference.

use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use sinew_bit_parity::replay::{METHODS, Replay, TorqueHash, ticks, tree};
use sinew_show::Show;

static RIG: &[u8] = include_bytes!(env!("SINEW_RIG", "`cargo xtask firmware mps2_an386` sets it"));
static SHOW: &[u8] =
    include_bytes!(env!("SINEW_SHOW", "`cargo xtask firmware mps2_an386` sets it"));

/// Numbers of bodies, dofs and coordinates of the figure, which has a free root and ball joints.
const BODIES: usize = 18;
const DOFS: usize = 6 + 3 * (BODIES - 1);
const COORDINATES: usize = 7 + 4 * (BODIES - 1);

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

    let tree = tree::<BODIES, DOFS>(RIG).map_err(|_| "the rig is not usable")?;
    let show = Show::open(SHOW).map_err(|_| "the show is not valid")?;
    let ticks = ticks(&show);
    for method in METHODS {
        let mut replay = Replay::<BODIES, COORDINATES>::new(&tree, show, method)
            .map_err(|_| "the show cannot be performed by the rig")?;
        let mut hash = TorqueHash::default();
        let (mut counts, mut most_counts) = (0, 0);
        for tick in 0..ticks {
            replay.sense(tick);
            let start = SYST::get_current();
            let asked = replay.step(tick).map_err(|_| "a tick was refused")?;
            // The counter counts down and wraps at 24 bits.
            let taken = u64::from(start.wrapping_sub(SYST::get_current()) & COUNTER_MASK);
            counts += taken;
            most_counts = most_counts.max(taken);
            hash.update(asked.torques());
        }
        hprintln!(
            "method={} ticks={} tick={} worst={} hash={:016x}",
            method.as_str(),
            ticks,
            counts * INSTRUCTIONS_PER_COUNT / u64::from(ticks),
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
