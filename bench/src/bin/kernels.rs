//! Image for QEMU's `mps2-an386` (Cortex-M4F): counts the instructions of each kernel.
//!
//! Run it with `-icount shift=0`: one instruction then takes 1 ns of the machine's time, and its 25 MHz `SysTick`
//! counts once in 40 instructions. Each kernel is run often enough that this does not matter.

#![no_std]
#![no_main]

use core::hint::black_box;

use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use sinew_bench::{Root, figure, poses, states};
use sinew_core::control::Gains;
use sinew_core::dynamics::{BodyMotion, inverse_dynamics};
use sinew_core::glam::Vec3;
use sinew_core::state_error::{self, AimStatus, Aims, Compensation, Method, StateError};
use sinew_core::trajectory::{aligned_targets, backward_states, forward_targets_of_bodies};
use sinew_core::{
    BodyState, Controller, JointState, JointStates, JointTargets, Motion, Transform, Workspace,
    Wrench, kinematics,
};

const CAPACITY: usize = 32;
const RUNS: u32 = 40;
const INSTRUCTIONS_PER_COUNT: u32 = 40;
const COUNTER_MASK: u32 = 0x00ff_ffff;
const DT_S: f32 = 0.01;

#[entry]
fn main() -> ! {
    if let Some(peripherals) = Peripherals::take() {
        let mut syst = peripherals.SYST;
        syst.set_clock_source(SystClkSource::Core);
        syst.set_reload(COUNTER_MASK);
        syst.clear_current();
        syst.enable_counter();
        for count in [6, 18, 32] {
            measure(count);
        }
    }
    debug::exit(debug::EXIT_SUCCESS);
    loop {
        cortex_m::asm::wfi();
    }
}

/// Instructions of one run of a kernel, the mean of many; the first, which may differ, is not counted.
#[inline(never)]
fn count(name: &str, bodies: usize, mut kernel: impl FnMut()) {
    kernel();
    let start = SYST::get_current();
    for _ in 0..RUNS {
        kernel();
    }
    // The counter runs down and wraps at 24 bits.
    let counted = start.wrapping_sub(SYST::get_current()) & COUNTER_MASK;
    hprintln!(
        "kernel={} bodies={} instructions={}",
        name,
        bodies,
        counted * INSTRUCTIONS_PER_COUNT / RUNS
    );
}

fn measure(size: usize) {
    for (name, root) in [("rnea_fixed_root", Root::Turning), ("rnea_free_root", Root::Floating)] {
        let Ok(tree) = figure::<CAPACITY>(size, root) else { return };
        let mut joints = [JointState::default(); CAPACITY];
        let mut accelerations = [Motion::ZERO; CAPACITY];
        states(tree.bodies(), &mut joints, &mut accelerations);
        let mut scratch = [BodyMotion::default(); CAPACITY];
        let mut wrenches = [Wrench::ZERO; CAPACITY];
        let gravity = Vec3::new(0.0, -9.81, 0.0);
        count(name, size, || {
            let joints = black_box(&joints[..size]);
            let accelerations = &accelerations[..size];
            inverse_dynamics(
                tree.bodies(),
                joints,
                accelerations,
                gravity,
                &[],
                &mut scratch,
                &mut wrenches,
            );
        });
        black_box(&wrenches);
        let mut world = [BodyState::WORLD; CAPACITY];
        if root == Root::Floating {
            count("kinematics", size, || {
                kinematics::body_states(tree.bodies(), black_box(&joints[..size]), &mut world)
            });
            let mut errors = [StateError::ZERO; CAPACITY];
            let other = world.map(|state| BodyState {
                pose: state.pose
                    * Transform::new(
                        sinew_core::math::exp(Vec3::new(0.1, 0.05, -0.02)),
                        Vec3::new(0.01, 0.02, 0.03),
                    ),
                ..state
            });
            count("world", size, || {
                state_error::world(&other[..size], black_box(&world[..size]), &mut errors)
            });
            let aims = Aims::heaviest_child(&tree);
            let mut status = [AimStatus::Leaf; CAPACITY];
            count("linear_compensation", size, || {
                state_error::linear_compensation(
                    aims.as_slice(),
                    Compensation::default(),
                    &other[..size],
                    black_box(&world[..size]),
                    &mut errors,
                    &mut status,
                )
            });
        }
    }
    let Ok(tree) = figure::<CAPACITY>(size, Root::Floating) else { return };
    let frames = [0.0, DT_S, 2.0 * DT_S, 3.0 * DT_S].map(|time_s| {
        let mut frame = [Transform::IDENTITY; CAPACITY];
        poses(tree.bodies(), time_s + 0.3, &mut frame);
        frame
    });
    let mut targets = JointTargets::rest(&tree);
    let mut measured = JointStates::rest(&tree);
    let [before, now, next, after] = frames.each_ref().map(|frame| &frame[..size]);
    count("forward_targets_of_bodies", size, || {
        let _ = forward_targets_of_bodies(&tree, black_box([now, next, after]), DT_S, &mut targets);
    });
    count("aligned_targets", size, || {
        let _ = aligned_targets(black_box([now, next, after]), DT_S, &mut targets);
    });
    count("backward_states", size, || {
        let _ = backward_states(black_box([before, now]), DT_S, &mut measured);
    });
    let Ok(gains) = Gains::critically_damped(200.0) else { return };
    let aims = Aims::heaviest_child(&tree);
    let methods = [
        ("tick_local", Method::Local),
        ("tick_world", Method::World),
        (
            "tick_linear_compensation",
            Method::LinearCompensation { aims, settings: Compensation::default() },
        ),
    ];
    for (name, method) in methods {
        let Ok(controller) = Controller::new(tree.clone(), gains, method) else { return };
        let mut workspace = Workspace::new();
        count(name, size, || {
            let _ =
                forward_targets_of_bodies(&tree, black_box([now, next, after]), DT_S, &mut targets);
            let _ = backward_states(black_box([before, now]), DT_S, &mut measured);
            black_box(controller.tick(&targets, &measured, &[], &mut workspace));
        });
    }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    hprintln!("{}", info);
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
