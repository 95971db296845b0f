//! Image for QEMU's `mps2-an386` (Cortex-M4F): a show of 20 servos is opened, and played tick by tick and jump by
//! jump. Prints a hash of the results.

#![no_std]
#![no_main]

use core::hint::black_box;

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use sinew_bench::emulated::{self, count_runs, count_ticks};
use sinew_bench::show::{self, BYTES, JOINTS, JUMPS, TICK_S, TICKS};
use sinew_show::{Player, Position, Show, ShowError};

#[entry]
fn main() -> ! {
    emulated::run(|| measure::<JOINTS>().map_err(|_| "the show cannot be played"))
}

fn measure<const N: usize>() -> Result<(), ShowError> {
    let show = Show::open(BYTES)?;
    count_runs::<N, 1>("show_open", |_| _ = black_box(Show::open(black_box(BYTES)).is_ok()));
    count_runs::<N, 1>("show_check_blocks", |_| _ = black_box(show.check_blocks().is_ok()));
    let pace = show.pace(TICK_S);
    play::<N, TICKS>("show_frame", &show, |run| show::next(pace, run))?;
    play::<N, JUMPS>("show_frame_of_jump", &show, |run| show::jump(pace, run))?;
    hprintln!("type=Player bodies={} bytes={}", N, size_of::<Player<'_, N>>());
    for (name, bits) in show::hashes()? {
        hprintln!("hash={} bits={:016x}", name, bits);
    }
    Ok(())
}

fn play<const N: usize, const TIMES: u16>(
    name: &str,
    show: &Show<'_>,
    position: impl Fn(usize) -> Position,
) -> Result<(), ShowError> {
    let mut player = Player::<N>::new(*show)?;
    let mut coordinates = [[0.0; N]; 3];
    let mut result = Ok(());
    let _ = count_ticks::<N, TIMES, ShowError>(name, |run| {
        result = show_frame(&mut player, position(run), &mut coordinates);
        result
    });
    result
}

/// Returns the show's values at a tick, in a separate function.
#[inline(never)]
fn show_frame<const N: usize>(
    player: &mut Player<'_, N>,
    position: Position,
    [q, qd, qdd]: &mut [[f32; N]; 3],
) -> Result<(), ShowError> {
    player.state_at(position, q, qd, qdd)
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    hprintln!("{}", info);
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
