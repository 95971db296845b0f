//! Counts on QEMU's `mps2-an386`: shared by the images that `cargo xtask budget` runs.
//!
//! With `-icount shift=0` one instruction takes 1 ns of the machine's time, and its 25 MHz `SysTick` counts once in
//! 40 instructions. The command counts instructions individually in QEMU's trace, between [`begin`] and [`end`], and
//! compares both counts.

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

/// Number of counted runs, after a first run that is not counted. Ticks use successive frames.
const RUNS: u16 = 16;

/// Number of frames before the first desired frame, so that the measured poses lag behind.
pub const LAG_FRAMES: usize = 4;

/// Number of frames in memory: enough for the first tick and the counted ones.
pub const FRAMES: usize = LAG_FRAMES + RUNS as usize + 4;

/// Scale of the shows' performer relative to the rig.
const LARGER: f32 = 1.1;

/// Gravity for all rigs, in world axes, m/s².
pub const GRAVITY_M_S2: Vec3 = Vec3::new(0.0, -9.81, 0.0);

const INSTRUCTIONS_PER_COUNT: u32 = 40;
const COUNTER_MASK: u32 = 0x00ff_ffff;

/// Runs measurements, and ends the emulation.
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

/// Marks the start of the counted instructions.
#[inline(never)]
fn begin() {
    asm::nop();
}

/// Marks the end of the counted instructions. The length of this function differs from that of [`begin`]; otherwise
/// the compiler would merge both.
#[inline(never)]
fn end() {
    asm::nop();
    asm::nop();
}

/// Counts a kernel on rigs of `N` bodies. The kernel's argument is the number of the run.
pub fn count<const N: usize>(name: &str, kernel: impl FnMut(usize)) {
    count_runs::<N, RUNS>(name, kernel);
}

/// Counts a kernel with `TIMES` runs.
#[inline(never)]
pub fn count_runs<const N: usize, const TIMES: u16>(name: &str, mut kernel: impl FnMut(usize)) {
    kernel(0);
    let mut counted = 0;
    for run in 1..=TIMES {
        let start = SYST::get_current();
        begin();
        kernel(usize::from(run));
        end();
        // The counter counts down and wraps at 24 bits.
        counted += start.wrapping_sub(SYST::get_current()) & COUNTER_MASK;
    }
    let instructions = counted * INSTRUCTIONS_PER_COUNT / u32::from(TIMES);
    hprintln!("kernel={} bodies={} runs={} instructions={}", name, N, TIMES, instructions);
}

/// Counts the instructions of a kind of tick, and measures its stack.
///
/// # Errors
/// If a tick fails.
pub fn count_tick<const N: usize, E: Copy>(
    name: &str,
    tick: impl FnMut(usize) -> Result<(), E>,
) -> Result<(), &'static str> {
    count_ticks::<N, RUNS, E>(name, tick)
}

/// Counts a kind of tick with `TIMES` runs, and measures its stack.
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
    // Runs once more from the first frame: the state between ticks starts anew.
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

/// Scales poses to a performer who is larger than the rig.
pub fn enlarge(poses: &mut [Transform]) {
    for pose in poses.iter_mut().skip(1) {
        pose.translation_m *= LARGER;
    }
}

/// Returns a controller with the paper's gain.
///
/// # Errors
/// If the method does not fit the tree.
pub fn controller<const N: usize>(
    tree: &Tree<N>,
    method: Method<N>,
) -> Result<TorqueController<N>, &'static str> {
    let gains = Gains::critically_damped(200.0).map_err(|_| "no such gains")?;
    TorqueController::new(tree.clone(), gains, method)
        .and_then(|controller| controller.with_law(ControlLaw::InverseDynamics))
        .map_err(|_| "no such controller")
}
