use sinew_core::{
    Body, Inertia, JointKind, JointStates, JointTargets, TorqueController, Transform,
};
use sinew_core::{Tree, Workspace, control::Gains, glam::Vec3, state_error::Method};

fn main() -> Result<(), Box<dyn core::error::Error>> {
    // An arm of six links of 0.2 kg and 0.1 m: boxes along y. Its joints turn about y, x, y, x, y, x.
    let link = |i: usize| Body {
        parent: i.checked_sub(1),
        joint: JointKind::Revolute { axis: [Vec3::Y, Vec3::X][i % 2] },
        placement: Transform::from_translation(Vec3::Y * 0.1),
        inertia: Inertia::of_box(0.2, Vec3::Y * 0.05, Vec3::new(0.04, 0.1, 0.04)),
        rotor_inertia: 0.0,
    };
    let arm = Tree::<6>::from_bodies(&[0, 1, 2, 3, 4, 5].map(link))?;
    let (mut target, mut measured) = (JointTargets::rest(&arm), JointStates::rest(&arm));
    // 200 rad/s² for 1 rad of error; at most 2 N m. For an arm that hangs: `.with_gravity(Vec3::Y * 9.81)?`.
    let controller = TorqueController::new(arm, Gains::critically_damped(200.0)?, Method::Local)?
        .with_limits(&[sinew_core::control::TorqueLimit::new(2.0, 0.0)?; 6])?;
    let (mut workspace, mut torques_nm) = (Workspace::new(), [0.0; 6]);
    // The rest runs every tick. Readings of the encoders, in rad and rad/s, and the desired positions.
    measured.set_coordinates(controller.tree(), &[0.0; 6], &[0.0; 6])?;
    target.set_coordinates(controller.tree(), &[0.1; 6], &[0.0; 6], &[0.0; 6])?;
    let wrenches = controller.tick(&mut target, &measured, &[], &mut workspace);
    controller.tree().efforts(measured.as_slice(), wrenches, &mut torques_nm)?;
    println!("{torques_nm:?}");
    Ok(())
}
