//! Image that contains only the core: World and Linear Compensation with inverse dynamics, for 18 bodies, and their
//! construction. `cargo xtask budget` measures its flash. The image can run, but prints nothing.

#![no_std]
#![no_main]

use core::hint::black_box;

use cortex_m_rt::entry;
use sinew_bench::rig::Rig;
use sinew_core::control::Gains;
use sinew_core::glam::Vec3;
use sinew_core::state_error::{Aims, Compensation, Method};
use sinew_core::{
    Body, Inertia, JointKind, RotationalInertia, TorqueController, Transform, Tree, Workspace,
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
    rotor_inertia: 0.0,
};

#[entry]
fn main() -> ! {
    if let Some((mut world, mut linear_compensation)) = rigs() {
        while black_box(true) {
            for rig in [&mut world, &mut linear_compensation] {
                let [desired, measured, _] = poses();
                let _ = black_box(rig.tick(&desired, &measured).is_ok());
            }
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
    let [first, second, _] = poses();
    let rig = |method| {
        let controller = TorqueController::new(tree.clone(), gains, method).ok()?;
        Rig::new(controller, Workspace::new(), [&first, &second]).ok()
    };
    Some((rig(Method::World)?, rig(Method::LinearCompensation { aims, settings })?))
}

/// Returns poses that a board would read from its flash and its sensors.
fn poses() -> [[Transform; BODIES]; 3] {
    black_box([[Transform::IDENTITY; BODIES]; 3])
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}
