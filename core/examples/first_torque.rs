use sinew_core::{Body, Inertia, JointController, Tree, glam::Vec3};

fn main() -> Result<(), Box<dyn core::error::Error>> {
    // An arm of six links of 0.2 kg and 0.1 m, boxes along y, that turn about y, x, y, x, y, x. At most 2 N m.
    let inertia = Inertia::of_box(0.2, Vec3::Y * 0.05, Vec3::new(0.04, 0.1, 0.04));
    let link = |i: usize| Body::revolute(None, [Vec3::Y, Vec3::X][i % 2], Vec3::Y * 0.1, inertia);
    let arm = Tree::<6>::serial_chain(&[0, 1, 2, 3, 4, 5].map(link))?;
    let mut controller = JointController::new(arm, 200.0, &[2.0; 6])?;
    let mut torques_nm = [0.0; 6];
    // Every tick: where the joints should be, where they are (rad), and how fast (rad/s).
    controller.tick(&[0.1; 6], &[0.0; 6], &[0.0; 6], &mut torques_nm)?;
    println!("{torques_nm:?}");
    Ok(())
}
