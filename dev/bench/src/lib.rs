//! Data for the benches: rigs of any number of bodies, and motions of them.
//!
//! Everything follows from the number of bodies alone, so that a host and a board measure the same work.
//!
//! # Files
//! - `rig`, `servo`, `show`: a rig and its tick; rigs of servos; a show of 20 servos.
//! - `emulated/`: counts and stack depth on QEMU.
//! - `bin/`: one image for each group of measurements.

#![no_std]

#[cfg(feature = "mps2_an386")]
pub mod emulated;
pub mod rig;
pub mod servo;
pub mod show;

use sinew_core::glam::{Quat, Vec3};
use sinew_core::tracker::{Frame, FrameSource, extrapolate_before_start};
use sinew_core::{
    Body, Inertia, JointKind, JointState, RotationalInertia, Transform, Tree, TreeError, Twist,
    math,
};

/// Connection of the root to the world.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Root {
    /// The root turns about a fixed point.
    Turning,
    /// The root floats freely.
    Floating,
}

/// Returns a rig of `count` bodies (at most `N`) in branches of four bodies: two branches begin at the root, and two at
/// the end of each branch. All joints are spherical, except that of a floating root.
///
/// # Errors
/// [`TreeError`] if there are more bodies than the tree has room for.
pub fn figure<const N: usize>(count: usize, root: Root) -> Result<Tree<N>, TreeError> {
    let mut numbers = Numbers::new();
    let mut tree = Tree::new();
    for index in 0..count {
        // Branches of four bodies: two begin at body 0, and two at the end of each branch.
        let parent = match index {
            0 => None,
            _ if index % 4 == 1 => Some((index / 8) * 4),
            _ => Some(index - 1),
        };
        let joint = match (index, root) {
            (0, Root::Floating) => JointKind::Free,
            _ => JointKind::Spherical,
        };
        let [x, y, z] = [0; 3].map(|_| 0.03 + 0.02 * (numbers.next() + 1.0));
        let inertia = Inertia {
            mass_kg: 2.0 + numbers.next(),
            center_of_mass_m: numbers.vector() * 0.1,
            rotational_kg_m2: RotationalInertia {
                xx: y + z,
                yy: x + z,
                zz: x + y,
                xy: 0.005 * numbers.next(),
                xz: 0.005 * numbers.next(),
                yz: 0.005 * numbers.next(),
            },
        };
        let placement = Transform::from_translation(numbers.vector() * 0.3);
        tree.push(Body { parent, joint, placement, inertia, rotor_inertia: 0.0 })?;
    }
    Ok(tree)
}

/// Writes the poses of all joints at a time: a smooth motion, in which each joint turns by up to 1.7 rad from a
/// pseudo-random orientation.
pub fn poses(bodies: &[Body], time_s: f32, out: &mut [Transform]) {
    let mut numbers = Numbers::new();
    for (body, pose) in bodies.iter().zip(out) {
        let (axis, about) = (numbers.vector(), numbers.vector());
        let phase = math::sin_cos(3.0 * time_s + numbers.next()).0;
        *pose = body.placement * turned(math::exp(axis * phase) * math::exp(about));
        if body.joint == JointKind::Free {
            pose.translation_m += numbers.vector() * phase;
        }
        pose.rotation = math::unit(pose.rotation);
    }
}

/// Frames in memory, one list of poses after the other. Frames before the first continue the first step backwards;
/// after the end, the last frame is held.
#[derive(Debug)]
pub struct Frames<'a, const N: usize> {
    frames: &'a [[Transform; N]],
    before: [Transform; N],
}

impl<'a, const N: usize> Frames<'a, N> {
    /// Creates a source from a list of frames.
    pub fn new(frames: &'a [[Transform; N]]) -> Self {
        Self { frames, before: [Transform::IDENTITY; N] }
    }
}

impl<const N: usize> FrameSource for Frames<'_, N> {
    fn frame(&mut self, index: i32) -> Frame<'_> {
        let last = self.frames.len().saturating_sub(1);
        let at = |index: usize| self.frames.get(index.min(last)).map_or(&[][..], |frame| frame);
        if let Ok(index) = usize::try_from(index) {
            return Frame::Poses(at(index));
        }
        for (pose, (first, second)) in self.before.iter_mut().zip(at(0).iter().zip(at(1))) {
            *pose = extrapolate_before_start(first, second, index.unsigned_abs());
        }
        Frame::Poses(&self.before)
    }
}

/// Writes the states of all joints, each with a velocity of about 1 rad/s, and accelerations of some rad/s².
pub fn states(bodies: &[Body], joints: &mut [JointState], accelerations: &mut [Twist]) {
    let mut numbers = Numbers::new();
    for ((body, joint), acceleration) in bodies.iter().zip(joints).zip(accelerations) {
        let velocity = Twist::new(numbers.vector(), numbers.vector());
        let pose = body.placement * turned(math::exp(numbers.vector()));
        let wanted = Twist::new(numbers.vector() * 5.0, numbers.vector() * 5.0);
        *joint = JointState { pose, velocity: body.joint.project_twist(Quat::IDENTITY, velocity) };
        *acceleration = body.joint.project_twist(Quat::IDENTITY, wanted);
    }
}

/// Numbers in [-1, 1), the same in every run: a linear congruential generator (Numerical Recipes).
struct Numbers(u32);

impl Numbers {
    fn new() -> Self {
        Self(2_463_534_242)
    }

    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        // The upper bits: the lower bits of such a generator repeat soon.
        f32::from((self.0 >> 16) as u16) / 32_768.0 - 1.0
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }
}

fn turned(rotation: Quat) -> Transform {
    Transform::new(rotation, Vec3::ZERO)
}
