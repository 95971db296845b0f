//! Image for `cargo xtask audit`: everything that a board's program may call of the libraries, linked but never run.
//!
//! Every input is hidden from the compiler, so that no check is removed for a constant value. A reachable panic calls
//! a function that does not exist, so the image does not link. `cargo xtask audit` reports where the panic is, and
//! finds other forbidden content in the image.

mod bus;
mod construct;
mod controller;
mod coordinates;
mod decode;
mod drives;
mod kernels;
mod link;
mod node;
mod show;
mod storage;
mod supervisor;
mod targets;
mod tick;

use core::hint::black_box;

use cortex_m_rt::entry;
use sinew_audit::{slice, slice_mut};
use sinew_core::control::Gains;
use sinew_core::{Body, Inertia, JointKind, JointStates, JointTargets, Transform, Tree};

/// Number of bodies of the figure on the boards.
const N: usize = 18;

/// Calls every part of the audit. `cargo xtask audit` finds the parts by their names.
#[entry]
fn main() -> ! {
    loop {
        decode::coordinates();
        construct::trees();
        construct::controllers();
        construct::projections();
        construct::observers();
        construct::importance();
        construct::pose_space();
        coordinates::bodies();
        coordinates::dynamics();
        coordinates::controller();
        targets::trajectories();
        targets::differences();
        tick::controller();
        tick::controller_of_little_room();
        tick::tracker();
        tick::replay();
        tick::parity();
        kernels::kinematics();
        kernels::state_errors();
        kernels::dynamics();
        kernels::elementary();
        show::decoder();
        show::frames();
        show::blend();
        bus::dynamixel_bus();
        bus::dynamixel_packets();
        bus::dynamixel_groups();
        bus::dynamixel_device();
        bus::feetech_bus();
        bus::feetech_packets();
        bus::feetech_device();
        bus::pca9685();
        bus::readings();
        drives::rig();
        drives::classes();
        link::frames();
        link::controller();
        link::host();
        link::live();
        link::telemetry();
        storage::tables();
        storage::items();
        storage::uploads();
        storage::faults();
        supervisor::states();
        supervisor::faults();
        supervisor::detectors();
        supervisor::guard();
        controller::ticks();
        node::nodes();
    }
}

fn body() -> Body {
    black_box(Body {
        parent: None,
        joint: JointKind::Spherical,
        placement: Transform::IDENTITY,
        inertia: Inertia::default(),
        rotor_inertia: 0.0,
    })
}

fn tree() -> Tree<N> {
    black_box(Tree::new())
}

fn gains() -> Option<Gains> {
    black_box(Gains::critically_damped(black_box(1.0)).ok())
}

fn measured() -> JointStates<N> {
    black_box(JointStates::rest(&tree()))
}

fn desired() -> JointTargets<N> {
    black_box(JointTargets::rest(&tree()))
}
