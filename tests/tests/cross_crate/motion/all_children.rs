//! Compensation for several children at once. A search in f64 that shares no code with the core shows that the core
//! finds the best turn.

use glam::{DMat3, DMat4, DQuat, DVec3, DVec4};
use proptest::prelude::*;
use sinew_core::glam::{Quat, Vec3};
use sinew_core::state_error::{
    Aim, AimStatus, Aims, Compensation, RateTerm, StateError, compensate, compensate_all,
    linear_compensation, world,
};
use sinew_core::{BodySet, BodyState, Transform, Twist, kinematics, math};
use sinew_test_support::property;
use sinew_test_support::rig::{CAPACITY, figures};

/// Maximum number of bodies of a figure: more than the paper's 18.
const MOST: usize = 24;

/// About ten roundings of 1.2e-7 in f32.
const SMALL: f32 = 2e-6;

/// The least-squares problem of one body, solved by Davenport's quaternion method: the best rotation is the
/// eigenvector of the largest eigenvalue of a symmetric 4 x 4 matrix, found by repeated squaring.
struct Wahba {
    arms: Vec<DVec3>,
    shift: DVec3,
}

impl Wahba {
    fn new(arms: &[Vec3], shift: Vec3) -> Self {
        Self { arms: arms.iter().map(|arm| arm.as_dvec3()).collect(), shift: shift.as_dvec3() }
    }

    /// Returns the sum of the squared distances of all children from their goals, m².
    fn cost(&self, turn: DQuat) -> f64 {
        self.arms.iter().map(|arm| (turn * *arm - (*arm + self.shift)).length_squared()).sum()
    }

    /// Returns the scale of the cost, m²: the largest possible value of `Σ b · R a`, the only part of the cost that
    /// depends on the turn `R`.
    fn scale(&self) -> f64 {
        self.arms.iter().map(|arm| arm.length() * (*arm + self.shift).length()).sum()
    }

    /// Returns the sum of the arms' lengths, m. If all goals are shifted, `Σ b · R a` changes by at most the length
    /// of the shift times this sum.
    fn levers(&self) -> f64 {
        self.arms.iter().map(|arm| arm.length()).sum()
    }

    /// Returns the profile matrix `Σ b aᵀ`.
    fn profile(&self) -> DMat3 {
        self.arms.iter().fold(DMat3::ZERO, |sum, a| {
            let b = *a + self.shift;
            sum + DMat3::from_cols(b * a.x, b * a.y, b * a.z)
        })
    }

    fn best(&self) -> DQuat {
        let b = self.profile();
        let trace = b.x_axis.x + b.y_axis.y + b.z_axis.z;
        let z = self.arms.iter().fold(DVec3::ZERO, |sum, a| sum + a.cross(*a + self.shift));
        let s = b + b.transpose() - DMat3::from_diagonal(DVec3::splat(trace));
        // In the order x y z w, plus a multiple of the identity that makes every eigenvalue positive.
        let mut k = DMat4::from_cols(
            s.x_axis.extend(z.x),
            s.y_axis.extend(z.y),
            s.z_axis.extend(z.z),
            z.extend(trace),
        ) + DMat4::from_diagonal(DVec4::splat(2.0 * self.scale()));
        for _ in 0..60 {
            k *= 1.0 / k.to_cols_array().iter().fold(0.0f64, |largest, x| largest.max(x.abs()));
            k *= k;
        }
        let columns = [k.x_axis, k.y_axis, k.z_axis, k.w_axis];
        let longest = columns.into_iter().max_by(|a, b| a.length().total_cmp(&b.length()));
        DQuat::from_vec4(longest.expect("four columns").normalize())
    }

    /// Returns approximately the smallest curvature of the cost at a turn, relative to its scale: how well the best
    /// turn is defined.
    fn definite(&self, turn: DQuat) -> f64 {
        let c = self.profile() * DMat3::from_quat(turn.inverse());
        let trace = c.x_axis.x + c.y_axis.y + c.z_axis.z;
        let curvature = DMat3::from_diagonal(DVec3::splat(trace)) - (c + c.transpose()) * 0.5;
        let inverse = curvature.inverse().to_cols_array();
        1.0 / (inverse.iter().map(|x| x * x).sum::<f64>().sqrt() * self.scale())
    }

    /// Returns the share of the squared arms perpendicular to their best common line: zero if all are on one line.
    fn width(&self) -> f64 {
        let (squares, moment) =
            self.arms.iter().fold((0.0, DMat3::ZERO), |(squares, moment), a| {
                let outer = DMat3::from_cols(*a * a.x, *a * a.y, *a * a.z);
                (squares + a.length_squared(), moment + outer)
            });
        let m = moment * (1.0 / squares);
        0.5 * (1.0 - (m * m).x_axis.x - (m * m).y_axis.y - (m * m).z_axis.z)
    }
}

fn state(rotation: Quat, position_m: Vec3) -> BodyState {
    BodyState { pose: Transform::new(rotation, position_m), velocity: Twist::ZERO }
}

/// Returns the turn of the desired orientation that corresponds to an error.
fn turn_of(error: &StateError, desired: &BodyState, measured: &BodyState) -> DQuat {
    let turned = error_rotation(error.angular_rad) * measured.pose.rotation.as_dquat();
    turned * desired.pose.rotation.as_dquat().inverse()
}

/// Returns the rotation vector of the shorter of the two turns that a quaternion describes.
fn rotation_vector(turn: DQuat) -> DVec3 {
    (if turn.w < 0.0 { -turn } else { turn }).to_scaled_axis()
}

fn error_rotation(angular_rad: Vec3) -> DQuat {
    DQuat::from_scaled_axis(angular_rad.as_dvec3())
}

fn all(arms: &[Vec3], desired: &BodyState, measured: &BodyState) -> (StateError, AimStatus) {
    compensate_all(arms.iter().copied(), Compensation::default(), desired, measured)
}

/// Returns the turn for arms whose body is shifted by `shift`. The desired and the measured body have the same
/// orientation.
fn turn(arms: &[Vec3], shift: Vec3) -> (Vec3, AimStatus) {
    let (error, status) = all(arms, &state(Quat::IDENTITY, shift), &BodyState::WORLD);
    (error.angular_rad, status)
}

fn vector() -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-1.0f32..1.0).prop_map(Vec3::from_array)
}

fn arms() -> impl Strategy<Value = Vec<Vec3>> {
    prop::collection::vec(vector().prop_map(|v| v * 0.4), 2..6)
}

fn run(
    aims: &Aims<CAPACITY>,
    settings: Compensation,
    desired: &[BodyState],
    measured: &[BodyState],
) -> (Vec<StateError>, Vec<AimStatus>) {
    let mut errors = vec![StateError::ZERO; desired.len()];
    let mut status = vec![AimStatus::Leaf; desired.len()];
    linear_compensation(aims.as_slice(), settings, desired, measured, &mut errors, &mut status);
    (errors, status)
}

proptest! {
    #![proptest_config(property(400))]

    #[test]
    fn no_turn_brings_the_children_nearer(
        (arms, shift, size) in (arms(), vector(), prop_oneof![Just(0.01f32), Just(0.1), Just(1.0)]),
    ) {
        let problem = Wahba::new(&arms, shift * size);
        prop_assume!(problem.width() > 2e-4);
        let best = problem.best();
        let (got, status) = turn(&arms, shift * size);
        prop_assert!(matches!(status, AimStatus::Compensated), "{status:?}");
        let got = error_rotation(got);
        let allowed = 1e-6 * problem.scale();
        let (cost, least) = (problem.cost(got), problem.cost(best));
        prop_assert!(cost <= least + allowed, "{cost} m², the least is {least} m²");
        // The less the turn is defined, the more rounding changes it.
        let angle = rotation_vector(got * best.inverse()).length();
        let definite = problem.definite(best);
        prop_assert!(angle * definite < f64::from(SMALL), "{angle} rad off, {definite}");
    }

    #[test]
    fn the_search_in_f64_finds_the_least(
        (arms, shift, other, step) in (arms(), vector(), vector(), 1e-3f32..3.0),
    ) {
        let problem = Wahba::new(&arms, shift * 0.3);
        let best = problem.best();
        let other = DQuat::from_scaled_axis((other * step).as_dvec3()) * best;
        prop_assert!(problem.cost(best) <= problem.cost(other) * (1.0 + 1e-12));
    }

    #[test]
    fn figures_are_compensated_as_well_as_they_can(
        ((desired, measured), factor) in
            (figures(MOST, 0.6), prop_oneof![Just(1.0f32), Just(1.1), 0.7f32..1.4]),
    ) {
        let d = desired.world();
        let mut m = vec![BodyState::WORLD; d.len()];
        kinematics::body_states(measured.tree.bodies(), measured.scaled_states(factor).as_slice(), &mut m);
        let aims = Aims::all_children(&desired.tree);
        let (errors, status) = run(&aims, Compensation::default(), &d, &m);
        let (of_one, status_of_one) =
            run(&Aims::heaviest_child(&desired.tree), Compensation::default(), &d, &m);
        for (index, aim) in aims.as_slice().iter().enumerate() {
            let Aim::Children(children) = *aim else {
                prop_assert_eq!((&errors[index], status[index]), (&of_one[index], status_of_one[index]));
                continue;
            };
            let origin = d[index].pose.translation_m;
            let arms: Vec<_> = children.iter().map(|c| d[c].pose.translation_m - origin).collect();
            let problem = Wahba::new(&arms, origin - m[index].pose.translation_m);
            if problem.scale() < 1e-3 || problem.width() < 2e-4 || status[index] == AimStatus::Antiparallel {
                continue;
            }
            let (got, best) = (turn_of(&errors[index], &d[index], &m[index]), problem.best());
            let (cost, least) = (problem.cost(got), problem.cost(best));
            // The core knows the vectors between the figures only to the f32 precision of their positions. A goal
            // that is off by δ changes the cost of a turn by at most 2 δ times its arm, for both turns.
            let (desired_m, measured_m) = (origin, m[index].pose.translation_m);
            let rounding_m = f64::from(f32::EPSILON * (desired_m.length() + measured_m.length()));
            let allowed = 1e-6 * problem.scale() + 4.0 * rounding_m * problem.levers();
            prop_assert!(cost <= least + allowed, "{index}: {cost} m², the least is {least} m²");
        }
    }

    #[test]
    fn without_weight_it_is_the_world_error((desired, measured) in figures(MOST, 0.5)) {
        let (d, m) = (desired.world(), measured.world());
        let settings = Compensation { beta: 0.0, ..Compensation::default() };
        let mut expected = vec![StateError::ZERO; d.len()];
        world(&d, &m, &mut expected);
        prop_assert_eq!(run(&Aims::all_children(&desired.tree), settings, &d, &m).0, expected);
    }

    #[test]
    fn one_child_is_one_aim((arm, shift, turned) in (vector(), vector(), vector())) {
        let (desired, measured) = (state(math::exp(turned), shift), BodyState::WORLD);
        let one = compensate(Some(arm), Compensation::default(), &desired, &measured);
        prop_assert_eq!(all(&[arm], &desired, &measured), one, "to the last bit");
    }

    #[test]
    fn children_on_a_line_do_not_turn_about_it(
        (arm, shift, far) in (vector(), vector(), prop_oneof![-3.0f32..-0.1, 0.1f32..3.0]),
    ) {
        prop_assume!(arm.length() > 0.1 && (far + 1.0).abs() > 0.1);
        let (got, _) = turn(&[arm, arm * far], shift * 0.2);
        let along = got.dot(arm / math::length(arm)).abs();
        prop_assert!(along < 4.0 * SMALL, "{along} rad about the line");
        let problem = Wahba::new(&[arm, arm * far], shift * 0.2);
        let (cost, least) = (problem.cost(error_rotation(got)), problem.cost(problem.best()));
        prop_assert!(cost <= least + 1e-6 * problem.scale(), "{cost} m², the least is {least} m²");
    }

    #[test]
    fn the_weight_is_a_share_of_the_turn((arms, shift, beta) in (arms(), vector(), 0.0f32..1.0)) {
        let desired = state(Quat::IDENTITY, shift * 0.2);
        let of = |beta| {
            let settings = Compensation { beta, ..Compensation::default() };
            compensate_all(arms.iter().copied(), settings, &desired, &BodyState::WORLD).0.angular_rad
        };
        let (whole, share) = (of(1.0), of(beta));
        prop_assert!((whole * beta - share).abs().max_element() < 2.0 * SMALL, "{whole} {share}");
    }

    #[test]
    fn the_rate_is_that_of_the_turn(
        (arms, shift, rate, spin) in (arms(), vector(), vector(), vector()),
    ) {
        // The desired body turns with its arms and moves past the measured body, 0.1 mm away.
        let shift = shift * 1e-4;
        let problem = Wahba::new(&arms, shift);
        prop_assume!(problem.width() > 1e-2);
        let turned_after = |t: f64| {
            let turn = DQuat::from_scaled_axis(spin.as_dvec3() * t);
            let arms = problem.arms.iter().map(|arm| turn * *arm).collect();
            let shift = problem.shift + rate.as_dvec3() * t;
            Wahba { arms, shift }.best() * turn
        };
        let h = 1e-5;
        let expected = rotation_vector(turned_after(h) * turned_after(-h).inverse()) / (2.0 * h);

        let desired = BodyState {
            pose: Transform::new(Quat::IDENTITY, shift),
            velocity: Twist::new(spin, rate),
        };
        let of = |rate_term| {
            let settings = Compensation { rate_term, ..Compensation::default() };
            compensate_all(arms.iter().copied(), settings, &desired, &BodyState::WORLD).0.angular_rate_rad_s
        };
        let got = of(RateTerm::Corrected);
        let off = (got.as_dvec3() - expected).length();
        // The method is of first order. It neglects the turn that a shift of this length can make, times the speeds
        // of arms and goals: this changes the balanced moments, and the rate by as much divided by the curvature.
        let speeds = f64::from(spin.length() + (got - spin).length());
        let definite = problem.definite(DQuat::IDENTITY);
        let largest_turn = problem.shift.length() * problem.levers() / (definite * problem.scale());
        let allowed = (largest_turn + f64::from(SMALL)) * speeds / definite;
        prop_assert!(off <= allowed, "{off} rad/s off, allowed {allowed}");
        prop_assert_eq!(of(RateTerm::None), spin);
        let printed = of(RateTerm::AsPrinted) - spin;
        prop_assert!((printed + (got - spin)).abs().max_element() < SMALL * (1.0 + printed.length()));
    }
}

#[test]
fn evenly_placed_children_need_no_turn() {
    let hips = [Vec3::new(0.1, 0.0, 0.0), Vec3::new(-0.1, 0.0, 0.0)];
    for shift in [Vec3::ZERO, Vec3::X * 0.05, Vec3::Y * 0.3, Vec3::new(0.1, -0.2, 0.3)] {
        assert_eq!(turn(&hips, shift), (Vec3::ZERO, AimStatus::Parallel), "{shift}");
    }
    // In a plane parallel to one through the origin: a shift in the plane causes no turn out of it.
    let hips = hips.map(|hip| hip - Vec3::Y * 0.1);
    let (turned, status) = turn(&hips, Vec3::new(0.05, 0.0, 0.0));
    assert_eq!(status, AimStatus::Compensated);
    assert!(turned.x == 0.0 && turned.y == 0.0 && turned.z > 0.1, "{turned}");
}

#[test]
fn what_has_no_one_best_turn_is_not_turned() {
    // The body is far beyond its goals: the best turn is a half turn, about X or -X.
    let even = [Vec3::new(0.1, -0.3, 0.0), Vec3::new(-0.1, -0.3, 0.0)];
    let shift = Vec3::Y * 2.0;
    assert_eq!(turn(&even, shift), (Vec3::ZERO, AimStatus::Antiparallel));
    // If the shift is a little to the side, the turn is well defined and almost as large, as with one child.
    let (error, status) = turn(&even, shift + Vec3::Z * 0.01);
    assert_eq!(status, AimStatus::Compensated);
    assert!(error.x.abs() > 3.0, "{error}");
    let short = [Vec3::X * 1e-4, Vec3::Y * 1e-4];
    assert_eq!(turn(&short, Vec3::X), (Vec3::ZERO, AimStatus::ZeroAim));
    assert_eq!(turn(&[], Vec3::X), (Vec3::ZERO, AimStatus::Leaf));
    let none = BodySet::EMPTY;
    let errors = &mut [StateError::ZERO];
    let status = &mut [AimStatus::Parallel];
    let states = [BodyState::WORLD];
    linear_compensation(
        &[Aim::Children(none)],
        Compensation::default(),
        &states,
        &states,
        errors,
        status,
    );
    assert_eq!(status, &[AimStatus::Leaf]);
}
