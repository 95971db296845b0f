//! Image for QEMU's `mps2-an386` (Cortex-M4F): performs the baked show with each method and reports.
//!
//! Run it with `-icount shift=0`: one instruction then takes 1 ns of the machine's time, and its 25 MHz
//! `SysTick` counts once in 40 instructions. Sums over a whole run are exact to a fraction of an instruction
//! per tick. It counts instructions, not cycles: stalls and flash wait states are not there.
//!
//! All torques go to the host's file `torques.bin` in QEMU's working directory, so that a difference can be
//! named; the summary goes to the console.

#![no_std]
#![no_main]

use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln, syscall};
use sinew_firmware::replay::{METHODS, Replay, TorqueHash, components};
use sinew_firmware::show::Show;

static SHOW: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/show.snws"));

const CAPACITY: usize = 18;
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
    let dump = open(c"torques.bin")?;
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
            let mut bytes = [0u8; CAPACITY * 24];
            let numbers = torques.iter().flat_map(|torque| components(&torque.value));
            for (slot, number) in bytes.chunks_exact_mut(4).zip(numbers) {
                slot.copy_from_slice(&number.to_bits().to_le_bytes());
            }
            write(dump, bytes.get(..torques.len() * 24).unwrap_or_default())?;
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

/// Opens a file of the host for writing, binary.
#[expect(unsafe_code, reason = "a semihosting call is a breakpoint instruction with arguments")]
fn open(path: &core::ffi::CStr) -> Result<usize, &'static str> {
    const WRITE_BINARY: usize = 5;
    // SAFETY: SYS_OPEN reads the path, which ends with a zero byte, and its length without it.
    let handle = unsafe { syscall!(OPEN, path.as_ptr(), WRITE_BINARY, path.count_bytes()) };
    if handle == usize::MAX { Err("torques.bin cannot be opened") } else { Ok(handle) }
}

#[expect(unsafe_code, reason = "a semihosting call is a breakpoint instruction with arguments")]
fn write(handle: usize, bytes: &[u8]) -> Result<(), &'static str> {
    // SAFETY: SYS_WRITE reads `bytes.len()` bytes from the address, both of one live slice.
    let left = unsafe { syscall!(WRITE, handle, bytes.as_ptr(), bytes.len()) };
    if left == 0 { Ok(()) } else { Err("torques.bin cannot be written") }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    hprintln!("{}", info);
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
