//! Rigs of servos: rotating joints on a fixed base, and a motion of their angles.

use sinew_core::coordinates::CoordinatesError;
use sinew_core::glam::Vec3;
use sinew_core::{Body, JointKind, JointStates, Transform, Tree, TreeError, math};

use crate::{Root, figure};

/// The largest number of joints of a rig.
pub const MOST_JOINTS: usize = 20;

/// Kind of all joints of a rig.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Joints {
    /// A servo for each joint.
    Revolute,
    /// Ball joints with the same motion as the servos.
    Ball,
}

/// Returns a rig of `N` joints and bodies with the shape of [`figure`]; the base is not one of its bodies.
///
/// # Errors
/// [`TreeError`] as in [`figure`].
pub fn rig<const N: usize>(joints: Joints) -> Result<Tree<N>, TreeError> {
    let mut tree = Tree::new();
    for (index, body) in figure::<N>(N, Root::Turning)?.bodies().iter().enumerate() {
        let joint = match joints {
            Joints::Revolute => JointKind::Revolute { axis: axis(index) },
            Joints::Ball => JointKind::Spherical,
        };
        tree.push(Body { joint, ..*body })?;
    }
    Ok(tree)
}

/// State of a rig of at most [`MOST_JOINTS`] joints at an instant.
#[derive(Debug, Clone, Copy)]
pub struct Instant {
    /// Poses of the joints in their parents' frames.
    pub poses: [Transform; MOST_JOINTS],
    /// Positions of the joints: angles in rad, or quaternions.
    pub q: [f32; 4 * MOST_JOINTS],
    /// Speeds along the dofs, rad/s.
    pub qd: [f32; 3 * MOST_JOINTS],
    /// Accelerations along the dofs, rad/s².
    pub qdd: [f32; 3 * MOST_JOINTS],
}

impl Instant {
    /// An instant with all numbers zero, and all poses the identity.
    pub const NOTHING: Self = Self {
        poses: [Transform::IDENTITY; MOST_JOINTS],
        q: [0.0; 4 * MOST_JOINTS],
        qd: [0.0; 3 * MOST_JOINTS],
        qdd: [0.0; 3 * MOST_JOINTS],
    };

    /// Returns the state of a [`rig`] at a time: each joint swings by 0.6 rad.
    ///
    /// # Errors
    /// [`CoordinatesError`] if the rig has more joints than there is room for.
    pub fn of<const N: usize>(tree: &Tree<N>, time_s: f32) -> Result<Self, CoordinatesError> {
        let mut instant = Self::NOTHING;
        let (mut q, mut qd, mut qdd) =
            (instant.q.iter_mut(), instant.qd.iter_mut(), instant.qdd.iter_mut());
        for (index, body) in tree.bodies().iter().enumerate() {
            let (sine, cosine) = math::sin_cos(3.0 * time_s + index as f32);
            let [angle, speed, acceleration] = [0.6 * sine, 1.8 * cosine, -5.4 * sine];
            let about = axis(index);
            if body.joint == JointKind::Spherical {
                write(math::exp(about * angle).to_array(), &mut q);
                write((about * speed).to_array(), &mut qd);
                write((about * acceleration).to_array(), &mut qdd);
            } else {
                write([angle], &mut q);
                write([speed], &mut qd);
                write([acceleration], &mut qdd);
            }
        }
        let mut states = JointStates::rest(tree);
        let q = instant.q.get(..tree.coordinate_count()).unwrap_or_default();
        states.set_coordinates_at_rest(tree, q)?;
        for (pose, state) in instant.poses.iter_mut().zip(states.as_slice()) {
            *pose = state.pose;
        }
        Ok(instant)
    }
}

/// Returns the axis of a joint: x, y and z in turn.
fn axis(joint: usize) -> Vec3 {
    match joint % 3 {
        0 => Vec3::X,
        1 => Vec3::Y,
        _ => Vec3::Z,
    }
}

fn write<'a, const K: usize>(numbers: [f32; K], to: &mut impl Iterator<Item = &'a mut f32>) {
    for (number, slot) in numbers.into_iter().zip(to) {
        *slot = number;
    }
}
