//! Properties of the error methods (the list of the paper's method description), on random figures.

use proptest::prelude::*;
use sinew_core::glam::{Quat, Vec3};
use sinew_core::state_error::{
    AimStatus, Aims, Compensation, RateTerm, References, StateError, accumulated,
    linear_compensation, local, world,
};
use sinew_core::{BodyState, JointState, Transform, Twist, kinematics, math};
use sinew_test_support::property;
use sinew_test_support::rig::{CAPACITY, Rig, figures};
use sinew_test_support::rounded::Rounded;
use sinew_verification::rounding::{Difference, Rotation, Vector};

/// Maximum number of bodies of a figure: more than the paper's 18.
const MOST: usize = 24;

/// Largest difference between two ways of computing a rotation or a position of such a figure, rad or m: about ten
/// roundings of 1.2e-7 (positions of up to 4 m).
const SMALL: f32 = 2e-6;

/// Largest difference for velocities of up to 50 rad/s and 50 m/s.
const SMALL_RATE: f32 = 4e-5;

type Errors = Vec<StateError>;

fn compute(count: usize, method: impl FnOnce(&mut [StateError])) -> Errors {
    let mut errors = vec![StateError::ZERO; count];
    method(&mut errors);
    errors
}

fn world_errors(desired: &[BodyState], measured: &[BodyState]) -> Errors {
    compute(desired.len(), |out| world(desired, measured, out))
}

fn local_errors(desired: &[JointState], measured: &[JointState]) -> Errors {
    compute(desired.len(), |out| local(desired, measured, out))
}

fn seen_from(
    references: &References<CAPACITY>,
    desired: &[BodyState],
    measured: &[BodyState],
) -> Errors {
    compute(desired.len(), |out| accumulated(references.as_slice(), desired, measured, out))
}

fn compensated(
    figure: &Rig,
    settings: Compensation,
    desired: &[BodyState],
    measured: &[BodyState],
) -> (Errors, Vec<AimStatus>) {
    let aims = Aims::heaviest_child(&figure.tree);
    let mut status = vec![AimStatus::Leaf; desired.len()];
    let errors = compute(desired.len(), |out| {
        linear_compensation(aims.as_slice(), settings, desired, measured, out, &mut status);
    });
    (errors, status)
}

fn parents(figure: &Rig) -> References<CAPACITY> {
    let parents: Vec<_> = figure.tree.bodies().iter().map(|body| body.parent).collect();
    References::new(&figure.tree, &parents).expect("parents are ancestors")
}

/// Returns the states of a figure whose root is moved by `root`: joints, and bodies in the world.
fn moved(figure: &Rig, root: Transform) -> (Vec<JointState>, Vec<BodyState>) {
    let mut joints = figure.states().as_slice().to_vec();
    joints[0].pose = root * joints[0].pose;
    let mut world = vec![BodyState::WORLD; joints.len()];
    kinematics::body_states(figure.tree.bodies(), &joints, &mut world);
    (joints, world)
}

fn near(got: &StateError, expected: &StateError) -> Result<(), String> {
    let parts = [
        (got.angular_rad, expected.angular_rad, SMALL),
        (got.linear_m, expected.linear_m, SMALL),
        (got.angular_rate_rad_s, expected.angular_rate_rad_s, SMALL_RATE),
        (got.linear_rate_m_s, expected.linear_rate_m_s, SMALL_RATE),
    ];
    if parts.iter().all(|(got, expected, limit)| (*got - *expected).abs().max_element() < *limit) {
        Ok(())
    } else {
        Err(format!("{got:?}, expected {expected:?}"))
    }
}

/// Returns the rounding limits of errors of two states relative to their references. The root of both is moved by
/// `root`, and the errors are turned by `after`.
fn limits(
    figures: [&Rig; 2],
    root: Transform,
    references: &[Option<usize>],
    after: Quat,
) -> Vec<Difference> {
    let [desired, measured] = figures.map(|figure| {
        let states = figure.states();
        let mut rounded = Rounded::of_states(figure.tree.bodies(), states.as_slice());
        let (turn, joint) = (Rotation::known(root.rotation), &mut rounded.joints[0]);
        joint.arm = Vector::known(root.translation_m) + turn.turn(joint.arm);
        joint.rotation = turn.after(joint.rotation);
        rounded.world()
    });
    let mut differences = Rounded::differences(&desired, &measured, references);
    let after = Rotation::known(after);
    for difference in &mut differences {
        let Difference { angular, linear, angular_rate, linear_rate } = difference;
        for vector in [angular, linear, angular_rate, linear_rate] {
            *vector = after.turn(*vector);
        }
    }
    differences
}

/// Compares two computations of an error: each has its own rounding.
fn all_within(
    got: &[StateError],
    expected: &[StateError],
    limits: [&[Difference]; 2],
) -> Result<(), TestCaseError> {
    for (index, (got, expected)) in got.iter().zip(expected).enumerate() {
        let both = |of: fn(&Difference) -> f64| limits.iter().map(|side| of(&side[index])).sum();
        let parts: [(Vec3, Vec3, f64); 4] = [
            (got.angular_rad, expected.angular_rad, both(|limit| limit.angular.limit())),
            (got.linear_m, expected.linear_m, both(|limit| limit.linear.limit())),
            (
                got.angular_rate_rad_s,
                expected.angular_rate_rad_s,
                both(|limit| limit.angular_rate.limit()),
            ),
            (
                got.linear_rate_m_s,
                expected.linear_rate_m_s,
                both(|limit| limit.linear_rate.limit()),
            ),
        ];
        for (got, expected, limit) in parts {
            let off = (got - expected).as_dvec3().length();
            prop_assert!(off <= limit, "body {index}: {got}, expected {expected}");
        }
    }
    Ok(())
}

fn all_near(got: &[StateError], expected: &[StateError]) -> Result<(), TestCaseError> {
    for (index, (got, expected)) in got.iter().zip(expected).enumerate() {
        near(got, expected)
            .map_err(|problem| TestCaseError::fail(format!("body {index}: {problem}")))?;
    }
    Ok(())
}

/// Returns the compensated desired orientation, from its error.
fn turned(error: &StateError, measured: &BodyState) -> Quat {
    math::exp(error.angular_rad) * measured.pose.rotation
}

fn rotation() -> impl Strategy<Value = Quat> {
    prop::array::uniform3(-2.0f32..2.0).prop_map(|v| math::exp(Vec3::from_array(v)))
}

proptest! {
    #![proptest_config(property(200))]

    #[test]
    fn without_weight_compensation_is_the_world_error((desired, measured) in figures(MOST, 0.5)) {
        let settings = Compensation { beta: 0.0, ..Compensation::default() };
        let (d, m) = (desired.world(), measured.world());
        prop_assert_eq!(compensated(&desired, settings, &d, &m).0, world_errors(&d, &m));
    }

    #[test]
    fn a_single_body_has_one_error((desired, measured) in figures(1, 1.0)) {
        let (d, m) = (desired.world(), measured.world());
        let world = world_errors(&d, &m);
        let (compensation, status) = compensated(&desired, Compensation::default(), &d, &m);
        prop_assert_eq!(&compensation, &world);
        prop_assert_eq!(status, [AimStatus::Leaf]);
        prop_assert_eq!(&seen_from(&References::egocentric(&desired.tree), &d, &m), &world);
        let local = local_errors(desired.states().as_slice(), measured.states().as_slice());
        all_near(&local, &world)?;
    }

    #[test]
    fn without_a_difference_there_is_no_error((figure, _) in figures(CAPACITY, 0.0)) {
        let (joints, states) = (figure.states(), figure.world());
        let (compensation, status) = compensated(&figure, Compensation::default(), &states, &states);
        for errors in [
            local_errors(joints.as_slice(), joints.as_slice()),
            world_errors(&states, &states),
            seen_from(&References::egocentric(&figure.tree), &states, &states),
            seen_from(&parents(&figure), &states, &states),
            compensation,
        ] {
            for error in errors {
                // The four products of a rotation and its inverse do not cancel to the last bit.
                prop_assert!(error.angular_rad.abs().max_element() <= 2.0 * f32::EPSILON);
                prop_assert_eq!(StateError { angular_rad: Vec3::ZERO, ..error }, StateError::ZERO);
            }
        }
        prop_assert!(!status.contains(&AimStatus::Compensated));
    }

    #[test]
    fn the_sign_of_a_quaternion_does_not_matter((desired, measured) in figures(MOST, 1.0)) {
        let (d, m) = (desired.world(), measured.world());
        let negated: Vec<_> = m
            .iter()
            .map(|state| BodyState {
                pose: Transform::new(-state.pose.rotation, state.pose.translation_m),
                ..*state
            })
            .collect();
        prop_assert_eq!(world_errors(&d, &negated), world_errors(&d, &m));
        let egocentric = References::egocentric(&desired.tree);
        prop_assert_eq!(seen_from(&egocentric, &d, &negated), seen_from(&egocentric, &d, &m));
        let of = |measured: &[BodyState]| compensated(&desired, Compensation::default(), &d, measured).0;
        prop_assert_eq!(of(&negated), of(&m));
    }

    #[test]
    fn moving_both_figures_turns_world_errors_and_leaves_inner_ones(
        ((desired, measured), turn, way) in
            (figures(MOST, 0.5), rotation(), prop::array::uniform3(-1.0f32..1.0)),
    ) {
        let motion = Transform::new(turn, Vec3::from_array(way));
        let ((dj, d), (mj, m)) = (moved(&desired, Transform::IDENTITY), moved(&measured, Transform::IDENTITY));
        let ((dj2, d2), (mj2, m2)) = (moved(&desired, motion), moved(&measured, motion));
        let turned = |errors: Errors| -> Errors {
            errors
                .iter()
                .map(|e| StateError {
                    angular_rad: turn * e.angular_rad,
                    linear_m: turn * e.linear_m,
                    angular_rate_rad_s: turn * e.angular_rate_rad_s,
                    linear_rate_m_s: turn * e.linear_rate_m_s,
                })
                .collect()
        };
        let limits = |root, seen_by: &[Option<usize>], after| {
            limits([&desired, &measured], root, seen_by, after)
        };
        let (still, world) = (Transform::IDENTITY, vec![None; d.len()]);
        all_within(
            &world_errors(&d2, &m2),
            &turned(world_errors(&d, &m)),
            [&limits(motion, &world, Quat::IDENTITY), &limits(still, &world, turn)],
        )?;
        let egocentric = References::egocentric(&desired.tree);
        let [before, after] = [still, motion].map(|root| limits(root, egocentric.as_slice(), Quat::IDENTITY));
        let (got, expected) = (seen_from(&egocentric, &d2, &m2), seen_from(&egocentric, &d, &m));
        all_within(&got[1..], &expected[1..], [&before[1..], &after[1..]])?;
        prop_assert_eq!(&local_errors(&dj2, &mj2)[1..], &local_errors(&dj, &mj)[1..]);
    }

    #[test]
    fn seen_from_the_parent_it_is_the_local_error((desired, measured) in figures(MOST, 1.0)) {
        let parents = parents(&desired);
        let got = seen_from(&parents, &desired.world(), &measured.world());
        let (d, m) = (desired.states(), measured.states());
        let expected = local_errors(d.as_slice(), m.as_slice());
        let still = Transform::IDENTITY;
        let limits = limits([&desired, &measured], still, parents.as_slice(), Quat::IDENTITY);
        all_within(&got, &expected, [&limits, &limits])?;
    }

    #[test]
    fn generations_lead_from_the_local_to_the_world_error(
        (desired, measured) in figures(MOST, 1.0), count in 1usize..6,
    ) {
        let (tree, d, m) = (&desired.tree, desired.world(), measured.world());
        let of = |references| seen_from(&references, &d, &m);
        prop_assert_eq!(of(References::generations(tree, 1)), of(parents(&desired)));
        let depth = (0..tree.len()).map(|body| tree.supporters(body).len()).max().unwrap_or(0);
        prop_assert_eq!(of(References::generations(tree, depth)), world_errors(&d, &m));
        let some = References::generations(tree, count);
        prop_assert_eq!(&References::new(tree, some.as_slice()), &Ok(some.clone()), "ancestors all");
        for (joint, reference) in some.as_slice().iter().enumerate() {
            // The supporters of a joint, including itself, from the root outwards.
            let supporters: Vec<_> = tree.supporters(joint).iter().collect();
            let expected = supporters.len().checked_sub(1 + count).map(|index| supporters[index]);
            prop_assert_eq!(*reference, expected, "joint {}", joint);
        }
    }

    #[test]
    fn an_ancestor_is_the_reference_of_what_it_moves((figure, _) in figures(MOST, 0.1), pick in 0usize..MOST) {
        let tree = &figure.tree;
        let ancestor = pick % tree.len();
        let references = References::of_ancestor(tree, ancestor);
        prop_assert_eq!(&References::new(tree, references.as_slice()), &Ok(references.clone()));
        let moved = tree.subtree(ancestor);
        for (joint, reference) in references.as_slice().iter().enumerate() {
            let expected = (joint != ancestor && moved.contains(joint)).then_some(ancestor);
            prop_assert_eq!(*reference, expected, "joint {}", joint);
        }
    }

    #[test]
    fn without_a_linear_error_nothing_is_compensated((desired, measured) in figures(MOST, 1.0)) {
        let d = desired.world();
        let m: Vec<_> = d
            .iter()
            .zip(measured.world())
            .map(|(d, m)| BodyState {
                pose: Transform::new(m.pose.rotation, d.pose.translation_m),
                ..m
            })
            .collect();
        let (errors, status) = compensated(&desired, Compensation::default(), &d, &m);
        let plain = compensated(
            &desired,
            Compensation { rate_term: RateTerm::None, ..Compensation::default() },
            &d,
            &m,
        );
        prop_assert_eq!(&plain.0, &world_errors(&d, &m), "no rotation without a linear error");
        for (index, status) in status.iter().enumerate() {
            prop_assert!(*status != AimStatus::Compensated, "{index}");
            // The rate of the turn is still present, perpendicular to the vector to the child.
            let extra = errors[index].angular_rate_rad_s - plain.0[index].angular_rate_rad_s;
            prop_assert!(
                (*status == AimStatus::Parallel) || extra == Vec3::ZERO,
                "{index} {status:?} {extra}"
            );
        }
    }

    #[test]
    fn compensation_brings_the_child_nearer_to_its_goal(
        ((desired, measured), factor) in (figures(MOST, 0.6), prop_oneof![Just(1.0f32), Just(1.1), 0.7f32..1.4]),
    ) {
        let d = desired.world();
        let mut m = vec![BodyState::WORLD; d.len()];
        kinematics::body_states(measured.tree.bodies(), measured.scaled_states(factor).as_slice(), &mut m);
        let (errors, status) = compensated(&desired, Compensation::default(), &d, &m);
        let aims = Aims::heaviest_child(&desired.tree);
        for (index, aim) in aims.as_slice().iter().enumerate() {
            let sinew_core::state_error::Aim::Child(child) = *aim else { continue };
            if status[index] != AimStatus::Compensated {
                continue;
            }
            let goal = d[child].pose.translation_m;
            let arm = goal - d[index].pose.translation_m;
            let from = m[index].pose.translation_m;
            let turned = turned(&errors[index], &m[index]);
            let turn = turned * d[index].pose.rotation.conjugate();
            let (before, after) = (math::length(from + arm - goal), math::length(from + turn * arm - goal));
            prop_assert!(after <= before + SMALL, "{index}: {after} m instead of {before} m");
            // The nearest point of the sphere that the child can reach.
            let nearest = (math::length(goal - from) - math::length(arm)).abs();
            prop_assert!((after - nearest).abs() < SMALL, "{index}: {after}, {nearest}");
            // A turn about the arm would be useless. Near a half turn the axis is only as exact as the sine.
            let phi = math::log(turn);
            let sine = math::length((turn * arm).cross(arm)) / arm.length_squared();
            let along = phi.dot(arm) / math::length(arm);
            let opposite = math::length(phi) > 2.0;
            let allowed = if opposite { 4.0 * SMALL / sine } else { 4.0 * SMALL };
            prop_assert!(along.abs() < allowed, "{index}: {along} rad about the arm");
        }
    }

    #[test]
    fn the_rate_of_half_the_squared_error_is_its_product_with_the_rate(
        (desired, measured) in figures(MOST, 1.0),
    ) {
        // d/dt |e|²/2 = e · ė exactly. Computed over 4 ms, in which a state turns by its velocity.
        let h = 2e-3f32;
        let at = |state: &BodyState, t: f32| BodyState {
            pose: Transform::new(
                math::exp(state.velocity.angular * t) * state.pose.rotation,
                state.pose.translation_m + state.velocity.linear * t,
            ),
            velocity: Twist::ZERO,
        };
        for (d, m) in desired.world().iter().zip(&measured.world()) {
            let error = StateError::between(d, m);
            let of = |t: f32| {
                let error = StateError::between(&at(d, t), &at(m, t));
                0.5 * (error.angular_rad.length_squared() + error.linear_m.length_squared())
            };
            let rate = (of(h) - of(-h)) / (2.0 * h);
            let expected = error.angular_rad.dot(error.angular_rate_rad_s)
                + error.linear_m.dot(error.linear_rate_m_s);
            let angle = math::length(error.angular_rad);
            let (speed, way) =
                (math::length(d.velocity.angular) + math::length(m.velocity.angular), math::length(error.linear_m));
            // The chord differs from the tangent by (ω h)² of the rate; each half square has an error of 1e-7 of its
            // size.
            let turning = speed * h;
            let allowed = turning * turning * speed * (1.0 + angle) + 5e-7 * (angle * angle + way * way) / h + 2e-4;
            prop_assume!(angle < 3.0);
            prop_assert!((rate - expected).abs() < allowed, "{rate} {expected} {allowed}");
        }
    }
}
