//! Compares our inverse dynamics (RNEA) with that of the crates `dynibo` and `featherstone`, on the same rig with the
//! same motion in one run: first whether all agree, then the time of each.
//!
//! Similarities and differences:
//! - All get the same state and return the torques of all joints and the wrench of the root, in release code for a
//!   generic machine of the target.
//! - `dynibo` computes in f64 and has no spherical joints: each is replaced by three revolute joints with two
//!   massless links. On the rig of revolute joints it has as many links as the others.
//! - `featherstone` computes in f32 and has all joints, but allocates in each call.
//! - Ours computes in f32 from states (rotations, not angles). The others start from joint coordinates. The
//!   additional time for the conversion and the checks of our states has a line of its own.
//!
//! With `SINEW_PEERS`, which `cargo xtask peers` sets, four kernels are also compared with Pinocchio's and MuJoCo's.
//! Both have all joints and start from coordinates. Pinocchio is compiled as its users compile it, for a generic
//! machine of the target. MuJoCo's kernels are the stages of its pipeline that are needed, without contacts.

mod dynibo;
mod featherstone;
#[path = "../common/interleaved.rs"]
mod interleaved;
mod motion;
#[path = "../common/options.rs"]
mod options;
mod ours;
mod peer;
mod peers;
mod sinew;

use std::error::Error;

use sinew_bench::{Root, figure};
use sinew_core::glam::Vec3;
use sinew_core::{JointKind, Tree};

use interleaved::{Median, medians};
use motion::RigMotion;

/// Number of bodies of the rigs.
const BODIES: usize = 18;
/// Gravity, as in `dynibo`.
const GRAVITY_M_S2: Vec3 = Vec3::new(0.0, 0.0, -9.806_65);
/// Largest difference of a torque, as a share of the largest torque: rounding of f32 along the deepest branch.
const TOLERANCE: f64 = 1e-5;
/// Largest allowed ratio of our time to the time of the faster of the other crates, on the first rig.
const BOUND: f64 = 0.4;

/// An implementation of inverse dynamics with a rig.
trait Contender {
    fn name(&self) -> &'static str;

    /// Converts a motion to its own form. This is not timed.
    fn set(&mut self, motion: &RigMotion);

    /// Computes inverse dynamics of that motion.
    fn run(&mut self);

    /// Returns the result of the last [`Self::run`]: moment and force on the root in world axes about its origin, in
    /// N m and N; then the torque of each turn of the motion, in N m.
    fn torques(&self, motion: &RigMotion) -> Vec<f64>;
}

fn main() -> Result<(), Box<dyn Error>> {
    let spherical = figure::<BODIES>(BODIES, Root::Floating)?;
    let mut revolute = Tree::<BODIES>::new();
    for (body, axis) in spherical.bodies().iter().zip([Vec3::X, Vec3::Y, Vec3::Z].iter().cycle()) {
        let mut body = *body;
        if body.joint == JointKind::Spherical {
            body.joint = JointKind::Revolute { axis: *axis };
        }
        revolute.push(body)?;
    }
    let ratio = compare(&spherical)?;
    compare(&revolute)?;
    let met = if ratio <= BOUND { "met" } else { "MISSED" };
    println!(
        "sinew's ratio to the faster of both on the first rig: {ratio:.2} (must be at most {BOUND}: {met})"
    );
    if let Some(programs) = std::env::var_os("SINEW_PEERS") {
        peers::compare(&spherical, &programs)?;
        peers::compare(&revolute, &programs)?;
    }
    Ok(())
}

/// Prints a table, and returns our ratio to the faster of the other crates.
fn compare(tree: &Tree<BODIES>) -> Result<f64, Box<dyn Error>> {
    let mut contenders: Vec<Box<dyn Contender>> = vec![
        Box::new(sinew::Sinew::new(tree)),
        Box::new(sinew::FromCoordinates::new(tree)),
        Box::new(dynibo::Dynibo::new(tree.bodies())?),
        Box::new(featherstone::Featherstone::new(tree.bodies())?),
    ];
    let (motions, rounds) = if options::quick() { (20, 200) } else { (1000, 5000) };
    let motions: Vec<_> = (0..motions).map(|seed| RigMotion::random(tree.bodies(), seed)).collect();
    let dofs = tree.dof_count();
    println!("\nRNEA, {BODIES} bodies, {dofs} degrees of freedom");

    let worst = disagreement(&mut contenders, &motions);
    println!(
        "largest difference of a torque in {} motions: {worst:.1e} of the largest",
        motions.len()
    );
    if worst > TOLERANCE {
        return Err(
            format!("the torques disagree by {worst:.1e}, more than {TOLERANCE:.0e}").into()
        );
    }

    let names: Vec<_> = contenders.iter().map(|contender| contender.name()).collect();
    let mut runs: Vec<_> = contenders.iter_mut().map(|contender| || contender.run()).collect();
    let mut runs: Vec<_> = runs.iter_mut().map(|run| run as &mut dyn FnMut()).collect();
    let found = medians(rounds, &mut runs);
    println!("{:24}{:>12}{:>16}", "", "median, ns", "sinew / this");
    for (name, Median { time_ns, to_first }) in names.iter().zip(&found) {
        println!("{name:24}{time_ns:>12.0}{:>16.2}", 1.0 / to_first);
    }
    let others = found.iter().skip(2);
    Ok(others.map(|other| 1.0 / other.to_first).fold(0.0, f64::max))
}

/// Returns the largest difference between any two contenders: of a joint's torque as a share of the largest torque
/// of the motion, and of the root's wrench likewise. Infinite if a result is not a number, or has another length.
fn disagreement(contenders: &mut [Box<dyn Contender>], motions: &[RigMotion]) -> f64 {
    let mut worst = 0.0_f64;
    for motion in motions {
        let found: Vec<_> = contenders
            .iter_mut()
            .map(|contender| {
                contender.set(motion);
                contender.run();
                contender.torques(motion)
            })
            .collect();
        for (index, first) in found.iter().enumerate() {
            for second in &found[..index] {
                let ((root, joints), (other_root, other_joints)) =
                    (first.split_at(6), second.split_at(6));
                worst = worst.max(apart(root, other_root)).max(apart(joints, other_joints));
            }
        }
    }
    worst
}

fn apart(first: &[f64], second: &[f64]) -> f64 {
    let finite = first.iter().chain(second).all(|value| value.is_finite());
    if !finite || first.len() != second.len() {
        return f64::INFINITY;
    }
    let largest = first.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let pairs = first.iter().zip(second);
    pairs.map(|(first, second)| (first - second).abs()).fold(0.0, f64::max) / largest
}
