//! The path from frames of a performance to targets.

use core::hint::black_box;

use sinew_core::finite_difference::{Scheme, of_rotations, of_rotations_in_world, of_vectors};
use sinew_core::trajectory::{
    aligned_targets, backward_states, forward_targets, interpolate, interpolate_smoothly,
    live_targets,
};
use sinew_core::{ForwardDifferences, Trajectory, Transform};

use super::{desired, measured, slice, slice_mut, tree};

#[inline(never)]
pub(crate) fn trajectories() {
    let Ok(trajectory) = Trajectory::new(slice(), black_box(1), black_box(1.0)) else { return };
    let trajectory = black_box(trajectory);
    black_box((trajectory.len(), trajectory.is_empty(), trajectory.frame(black_box(1))));
    trajectory.sample(black_box(1.0), slice_mut());
    black_box(&trajectory.targets(black_box(1), &mut desired()));
    let frames = black_box([Transform::IDENTITY; 4]);
    let [from, to, ..] = &frames;
    black_box(&interpolate(from, to, black_box(0.5)));
    black_box(&interpolate_smoothly(frames.each_ref(), black_box(0.5)));
}

#[inline(never)]
pub(crate) fn differences() {
    let (mut targets, dt_s) = (desired(), black_box(1.0));
    let window = [slice(), slice(), slice()];
    black_box(&forward_targets(window, dt_s, &mut targets));
    black_box(&aligned_targets(window, dt_s, &mut targets));
    black_box(&live_targets(window, dt_s, &mut targets));
    let mut differences = black_box(ForwardDifferences::new());
    black_box(&differences.restart(&tree(), dt_s, slice()));
    black_box(&differences.advance(&tree(), slice(), &mut targets));
    black_box(&backward_states([slice(), slice()], dt_s, &mut measured()));
    black_box(&measured().set_at_rest(slice()));
    black_box(&measured().update_poses(slice(), dt_s));
    let (scheme, order) = (black_box(Scheme::Central), black_box(2));
    black_box(&of_vectors(scheme, order, slice(), dt_s));
    black_box(&of_rotations(scheme, order, slice(), dt_s));
    black_box(&of_rotations_in_world(scheme, order, slice(), dt_s));
    black_box(scheme.sample_count(order));
}
