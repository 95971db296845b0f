//! Image with nothing but the core in it: World and Linear Compensation over inverse dynamics, for 18 bodies, and what
//! they are made with. `cargo xtask budget` looks at how much flash it takes; it can be run, but says nothing.

#![no_std]
#![no_main]

use core::hint::black_box;

use cortex_m_rt::entry;
use sinew_bench::rig::Rig;
use sinew_core::control::Gains;
use sinew_core::glam::Vec3;
use sinew_core::state_error::{Aims, Compensation, Method};
use sinew_core::{
    Body, Controller, Inertia, JointKind, RotationalInertia, StateInputError, Transform, Tree,
};

const BODIES: usize = 18;

const LINK: Body = Body {
    parent: None,
    joint: JointKind::Spherical,
    placement: Transform::from_translation(Vec3::Y),
    inertia: Inertia {
        mass_kg: 1.0,
        center_of_mass_m: Vec3::ZERO,
        rotational_kg_m2: RotationalInertia {
            xx: 0.1,
            yy: 0.1,
            zz: 0.1,
            xy: 0.0,
            xz: 0.0,
            yz: 0.0,
        },
    },
};

#[entry]
fn main() -> ! {
    if let Some((mut world, mut linear_compensation)) = rigs() {
        while black_box(true) {
            // What a board would have from its sensors and its flash.
            let poses = black_box([[Transform::IDENTITY; BODIES]; 5]);
            let _ = black_box(tick(&mut world, &poses));
            let _ = black_box(tick(&mut linear_compensation, &poses));
        }
    }
    loop {
        cortex_m::asm::wfi();
    }
}

fn rigs() -> Option<(Rig<BODIES>, Rig<BODIES>)> {
    let mut tree = Tree::<BODIES>::new();
    for index in 0..BODIES {
        tree.push(black_box(Body { parent: index.checked_sub(1), ..LINK })).ok()?;
    }
    let gains = Gains::critically_damped(black_box(200.0)).ok()?;
    let (aims, settings) = (Aims::heaviest_child(&tree), Compensation::default());
    let compensating =
        Controller::new(tree.clone(), gains, Method::LinearCompensation { aims, settings }).ok()?;
    Some((Rig::new(Controller::new(tree, gains, Method::World).ok()?), Rig::new(compensating)))
}

fn tick(rig: &mut Rig<BODIES>, poses: &[[Transform; BODIES]; 5]) -> Result<(), StateInputError> {
    let [before, now, desired @ ..] = poses.each_ref().map(|frame| &frame[..]);
    rig.tick(desired, [before, now]).map(|torques| _ = black_box(torques))
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}
