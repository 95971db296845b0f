//! Image for QEMU's `mps2-an386` (Cortex-M4F): a tick of the whole loop of an arm with XL330 that plays a show.
//!
//! The tick includes everything from the servos' answers to the next packets: detectors, supervisor, show, tracker,
//! drives, guards and the bus. Commands of the host link and telemetry are not included.

#![no_std]
#![no_main]

mod test_rig;

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use sinew_bench::emulated::{self, count_tick};

use test_rig::{Bus, MotionController, Rig, TestRig};

/// An arm with this number of servos, and a show for it (`build.rs`).
macro_rules! arm {
    ($count:literal) => {
        (
            &include_bytes!(concat!(env!("OUT_DIR"), "/arm_", $count, ".rig"))[..],
            &include_bytes!(concat!(env!("OUT_DIR"), "/arm_", $count, ".show"))[..],
        )
    };
}

/// A rig's number of servos as a type: it alone identifies the rig's tick.
struct Servos<const N: usize>;

trait Of {
    type TestRig<'a>: Ticks;
}

impl Of for Servos<6> {
    type TestRig<'a> = TestRig<'a, 7, 6>;
}

impl Of for Servos<20> {
    type TestRig<'a> = TestRig<'a, 21, 20>;
}

impl Of for Servos<40> {
    type TestRig<'a> = TestRig<'a, 41, 40>;
}

/// A rig that can run ticks.
trait Ticks {
    /// Runs a tick. Returns an error if the tick was incomplete, or the show does not run.
    fn tick(&mut self) -> Result<(), &'static str>;
}

impl<const BODIES: usize, const N: usize> Ticks for TestRig<'_, BODIES, N> {
    #[expect(
        clippy::inline_always,
        reason = "the frame of the function that is measured has it all"
    )]
    #[inline(always)]
    fn tick(&mut self) -> Result<(), &'static str> {
        self.plays()
    }
}

#[entry]
fn main() -> ! {
    emulated::run(|| {
        measure::<7, 6>(arm!("6"))?;
        measure::<21, 20>(arm!("20"))?;
        measure::<41, 40>(arm!("40"))
    })
}

fn measure<const BODIES: usize, const N: usize>(
    (rig, show): (&[u8], &[u8]),
) -> Result<(), &'static str>
where
    Servos<N>: for<'a> Of<TestRig<'a> = TestRig<'a, BODIES, N>>,
{
    let crc = u32::from_le_bytes(*rig.last_chunk().ok_or("there is no rig")?);
    let board = Rig::<BODIES, N>::decode(rig).map_err(|_| "the rig cannot be read")?;
    let mut test_rig = TestRig::new(&board, crc, show)?;
    count_tick::<N, _>("loop_recommended", |_| loop_tick::<N>(&mut test_rig))?;
    for (name, bytes) in [
        ("loop_controller", size_of::<MotionController<BODIES, N>>()),
        ("loop_rig", size_of::<Rig<BODIES, N>>()),
        ("loop_bus", size_of::<Bus<N>>()),
        // Files in flash, not in RAM.
        ("loop_rig_file", rig.len()),
        ("loop_show_file", show.len()),
    ] {
        hprintln!("type={} bodies={} bytes={}", name, N, bytes);
    }
    Ok(())
}

/// Runs a tick, in a separate function.
#[inline(never)]
fn loop_tick<const N: usize>(
    test_rig: &mut <Servos<N> as Of>::TestRig<'_>,
) -> Result<(), &'static str>
where
    Servos<N>: Of,
{
    test_rig.tick()
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    hprintln!("{}", info);
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
