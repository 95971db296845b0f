//! The kernels alone, with slices of different lengths: in the tick all have the same length.

use core::hint::black_box;

use sinew_core::control::{Limited, TorqueLimit};
use sinew_core::dynamics::{
    dof_count, forward_dynamics, inverse_dynamics, mass_matrix, resolved_acceleration,
};
use sinew_core::glam::{Quat, Vec3};
use sinew_core::projection::BodyWeights;
use sinew_core::state_error::{
    Compensation, StateError, accumulated, compensate, compensate_all, linear_compensation, local,
    world,
};
use sinew_core::{BodyState, JointKind, JointState, Transform, Twist, Wrench, kinematics, math};

use super::{gains, slice, slice_mut, tree};

#[inline(never)]
pub(crate) fn kinematics() {
    kinematics::body_states(slice(), slice(), slice_mut());
    kinematics::joint_states(slice(), slice(), slice_mut());
    kinematics::body_accelerations(slice(), slice(), slice(), slice_mut());
    kinematics::joint_accelerations(slice(), slice(), slice_mut());
    let state = black_box(BodyState::WORLD);
    let other = black_box(BodyState::WORLD);
    black_box((state.seen_from(&other), state.joint_state(&other)));
    black_box(state.child(&black_box(JointState::default())));
}

#[inline(never)]
pub(crate) fn state_errors() {
    local(slice(), slice(), slice_mut());
    world(slice(), slice(), slice_mut());
    accumulated(slice(), slice(), slice(), slice_mut());
    let settings = black_box(Compensation::default());
    linear_compensation(slice(), settings, slice(), slice(), slice_mut(), slice_mut());
    let (desired, measured) = (black_box(BodyState::WORLD), black_box(BodyState::WORLD));
    black_box(&compensate(black_box(Some(Vec3::X)), settings, &desired, &measured));
    black_box(&compensate_all(slice().iter().copied(), settings, &desired, &measured));
    black_box(&StateError::between(&desired, &measured));
}

#[inline(never)]
pub(crate) fn dynamics() {
    let gravity_m_s2 = black_box(Vec3::Y);
    let wrenches = slice_mut::<Wrench>();
    inverse_dynamics(slice(), slice(), slice(), gravity_m_s2, slice(), slice_mut(), wrenches);
    let torques = slice_mut::<Limited<Wrench>>();
    inverse_dynamics(slice(), slice(), slice(), gravity_m_s2, slice(), slice_mut(), torques);
    forward_dynamics(slice(), slice(), slice(), gravity_m_s2, slice(), slice_mut(), slice_mut());
    black_box(mass_matrix(slice(), slice(), slice_mut(), slice_mut()));
    black_box(dof_count(slice()));
    let Ok(weights) = BodyWeights::new(&tree(), slice()) else { return };
    let weights = black_box(weights);
    resolved_acceleration(slice(), slice(), slice(), &weights, slice_mut(), slice_mut());
    let Some(gains) = gains() else { return };
    black_box(gains.apply(&black_box(StateError::default())));
    let (rotation, motion) = (black_box(Quat::IDENTITY), black_box(Twist::ZERO));
    let (joint, wrench) = (black_box(JointKind::Free), black_box(Wrench::ZERO));
    black_box((joint.project_twist(rotation, motion), joint.project_wrench(rotation, wrench)));
    black_box(&joint.motion_subspace(rotation));
    black_box(joint.bias_acceleration(rotation, motion));
    let allowed: Limited<Wrench> = black_box(TorqueLimit::NONE).apply(wrench);
    black_box(&allowed);
}

#[inline(never)]
pub(crate) fn elementary() {
    let (x, v, q) = (black_box(1.0), black_box(Vec3::X), black_box(Quat::IDENTITY));
    black_box((math::sqrt(x), math::sin_cos(x), math::atan2(x, black_box(1.0))));
    black_box((math::exponential(x), math::logarithm(x)));
    black_box((math::length(v), math::unit(q), math::log(q)));
    black_box((math::exp(v), math::slerp(q, black_box(Quat::IDENTITY), x)));
    let transform = black_box(Transform::IDENTITY);
    black_box((transform.transform_point(v), transform.inverse(), transform.is_finite()));
}
