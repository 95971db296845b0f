//! Dynamics and control in the coordinates of joints.

use core::hint::black_box;

use sinew_core::glam::Vec3;
use sinew_core::{Body, Inertia, JointController, Transform, Tree};

use super::{N, slice, slice_mut, tree};

#[inline(never)]
pub(crate) fn bodies() {
    let (parent, inertia) = (black_box(Some(1)), black_box(Inertia::default()));
    let [axis, offset_m] = black_box([Vec3::X, Vec3::Y]);
    black_box(&[
        Body::fixed(parent, offset_m, inertia),
        Body::revolute(parent, axis, offset_m, inertia),
        Body::prismatic(parent, axis, offset_m, inertia),
        Body::spherical(parent, black_box(Transform::IDENTITY), inertia),
    ]);
    black_box(&Tree::<N>::serial_chain(slice()));
}

#[inline(never)]
pub(crate) fn dynamics() {
    let tree = tree();
    black_box(tree.inverse_dynamics(slice(), slice(), slice(), slice_mut()).is_ok());
    black_box(tree.forward_dynamics(slice(), slice(), slice(), slice_mut()).is_ok());
    black_box(tree.gravity(slice(), slice_mut()).is_ok());
    black_box(tree.mass_matrix(slice(), slice_mut()).is_ok());
    let on_the_moon = black_box(tree.under_gravity(black_box(Vec3::Z)));
    black_box(on_the_moon.inverse_dynamics(slice(), slice(), slice(), slice_mut()).is_ok());
    black_box(on_the_moon.forward_dynamics(slice(), slice(), slice(), slice_mut()).is_ok());
    black_box(on_the_moon.gravity(slice(), slice_mut()).is_ok());
}

#[inline(never)]
pub(crate) fn controller() {
    let Ok(controller) = JointController::new(tree(), black_box(1.0), slice()) else { return };
    let Ok(controller) = controller.with_gravity(black_box(Vec3::Z)) else { return };
    let Ok(controller) = controller.with_joint_gains(slice()) else { return };
    let mut controller = black_box(controller);
    black_box(controller.tick(slice(), slice(), slice(), slice_mut()).is_ok());
    let target = [slice(), slice(), slice()];
    black_box(controller.follow(target, slice(), slice(), slice_mut()).is_ok());
    black_box((controller.limited(black_box(1)), controller.tree().len()));
    black_box(controller.controller().limits());
}
