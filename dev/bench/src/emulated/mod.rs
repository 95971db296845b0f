//! Counting on QEMU's `mps2-an386`: what the images that `cargo xtask budget` runs have in common.
//!
//! With `-icount shift=0` one instruction takes 1 ns of the machine's time, and its 25 MHz `SysTick` counts once in 40
//! instructions. The command counts them one by one in QEMU's trace, between [`begin`] and [`end`], and compares.

mod stack;

use core::hint::black_box;

use cortex_m::Peripherals;
use cortex_m::asm;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_semihosting::{debug, hprintln};
use sinew_core::control::{ControlLaw, Gains};
use sinew_core::dynamics::{BodyMotion, inverse_dynamics};
use sinew_core::glam::Vec3;
use sinew_core::state_error::Method;
use sinew_core::{JointState, TorqueController, Transform, Tree, Twist, Wrench};

use crate::states;

/// How often each is run, after a first time that is not counted. Ticks are of successive frames.
const RUNS: u16 = 16;

/// So many frames come before the first that is asked for: the rig is late.
pub const LAG_FRAMES: usize = 4;

/// As many as the ticks look at, and one more of the rig's.
pub const FRAMES: usize = LAG_FRAMES + RUNS as usize + 4;

/// The performer of shows is as much larger than the rig.
const LARGER: f32 = 1.1;

/// Gravity of all rigs, world axes.
pub const GRAVITY_M_S2: Vec3 = Vec3::new(0.0, -9.81, 0.0);

const INSTRUCTIONS_PER_COUNT: u32 = 40;
const COUNTER_MASK: u32 = 0x00ff_ffff;

/// Measures, and ends the emulation.
pub fn run(measure: impl FnOnce() -> Result<(), &'static str>) -> ! {
    match start_counter().and_then(|()| measure()) {
        Ok(()) => debug::exit(debug::EXIT_SUCCESS),
        Err(problem) => {
            hprintln!("error: {}", problem);
            debug::exit(debug::EXIT_FAILURE);
        }
    }
    loop {
        asm::wfi();
    }
}

fn start_counter() -> Result<(), &'static str> {
    let mut syst = Peripherals::take().ok_or("the peripherals are taken")?.SYST;
    syst.set_clock_source(SystClkSource::Core);
    syst.set_reload(COUNTER_MASK);
    syst.clear_current();
    syst.enable_counter();
    Ok(())
}

/// What is executed after this is counted.
#[inline(never)]
fn begin() {
    asm::nop();
}

/// What is executed after this is not counted. Of another length than [`begin`], or the compiler makes one of both.
#[inline(never)]
fn end() {
    asm::nop();
    asm::nop();
}

/// Runs a kernel on rigs of `N` bodies; its argument counts the runs.
pub fn count<const N: usize>(name: &str, kernel: impl FnMut(usize)) {
    count_runs::<N, RUNS>(name, kernel);
}

/// The same `TIMES` times.
#[inline(never)]
pub fn count_runs<const N: usize, const TIMES: u16>(name: &str, mut kernel: impl FnMut(usize)) {
    kernel(0);
    let mut counted = 0;
    for run in 1..=TIMES {
        let start = SYST::get_current();
        begin();
        kernel(usize::from(run));
        end();
        // The counter runs down and wraps at 24 bits.
        counted += start.wrapping_sub(SYST::get_current()) & COUNTER_MASK;
    }
    let instructions = counted * INSTRUCTIONS_PER_COUNT / u32::from(TIMES);
    hprintln!("kernel={} bodies={} runs={} instructions={}", name, N, TIMES, instructions);
}

/// A kind of tick: what it executes, and how much stack it has taken.
///
/// # Errors
/// If a tick fails.
pub fn count_tick<const N: usize, E: Copy>(
    name: &str,
    tick: impl FnMut(usize) -> Result<(), E>,
) -> Result<(), &'static str> {
    count_ticks::<N, RUNS, E>(name, tick)
}

/// The same `TIMES` times.
///
/// # Errors
/// If a tick fails.
pub fn count_ticks<const N: usize, const TIMES: u16, E: Copy>(
    name: &str,
    mut tick: impl FnMut(usize) -> Result<(), E>,
) -> Result<(), &'static str> {
    let mut result = Ok(());
    let mut checked = |run| result = result.and(tick(run));
    count_runs::<N, TIMES>(name, &mut checked);
    // Once more from the first frame: what is remembered from tick to tick starts anew.
    let painted = stack::high_water_bytes(|| (0..=usize::from(TIMES)).for_each(&mut checked));
    hprintln!("stack={} bodies={} bytes={}", name, N, painted);
    result.map_err(|_| "a tick was refused")
}

/// Counts inverse dynamics.
pub fn inverse<const N: usize>(name: &str, tree: &Tree<N>) {
    let mut joints = [JointState::default(); N];
    let mut accelerations = [Twist::ZERO; N];
    states(tree.bodies(), &mut joints, &mut accelerations);
    let mut scratch = [BodyMotion::default(); N];
    let mut wrenches = [Wrench::ZERO; N];
    count::<N>(name, |_| {
        let (bodies, joints) = black_box((tree.bodies(), &joints[..]));
        let (scratch, wrenches) = (&mut scratch, &mut wrenches);
        inverse_dynamics(bodies, joints, &accelerations, GRAVITY_M_S2, &[], scratch, wrenches);
    });
    black_box(wrenches);
}

/// Poses of a performer who is larger than the rig.
pub fn enlarge(poses: &mut [Transform]) {
    for pose in poses.iter_mut().skip(1) {
        pose.translation_m *= LARGER;
    }
}

/// A controller with the paper's gain.
///
/// # Errors
/// If the method is not one of the tree.
pub fn controller<const N: usize>(
    tree: &Tree<N>,
    method: Method<N>,
) -> Result<TorqueController<N>, &'static str> {
    let gains = Gains::critically_damped(200.0).map_err(|_| "no such gains")?;
    TorqueController::new(tree.clone(), gains, method)
        .and_then(|controller| controller.with_law(ControlLaw::InverseDynamics))
        .map_err(|_| "no such controller")
}
