//! Tests of drives: servo to joint and back, equal work on both sides, derivatives, and refused input.

use std::f64::consts::TAU;

use proptest::prelude::*;
use sinew_core::{glam::Vec3, math};
use sinew_rig::drive::{
    CURVE_CAPACITY, Curve, Drive, DriveError, DriveInputError, FourBar, Links, Matrix,
};
use sinew_rig::limited::LimitReason;

/// Tolerance of positions after conversion and back, as a share of the largest: the condition number, at most 100,
/// times a few roundings of f32.
const THERE_AND_BACK: f32 = 1e-4;

fn dot(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn size(numbers: &[f32]) -> f32 {
    numbers.iter().fold(1.0, |largest, x| largest.max(x.abs()))
}

#[track_caller]
fn assert_near(found: &[f32], expected: &[f32], share: f32) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() <= share * size(expected), "{found:?} for {expected:?}");
    }
}

/// Asserts equal power on both sides, relative to the size of the sums' terms.
#[track_caller]
fn assert_same_power(a: (&[f32], &[f32]), b: (&[f32], &[f32])) {
    let (left, right) = (dot(a.0, a.1), dot(b.0, b.1));
    let terms = [a, b].map(|(x, y)| size(x) * size(y)).into_iter().fold(1.0, f32::max);
    // Sums of up to six terms, whose factors differ by at most `THERE_AND_BACK`.
    assert!((left - right).abs() <= THERE_AND_BACK * terms, "{left} and {right}");
}

fn numbers(count: usize) -> impl Strategy<Value = Vec<f32>> {
    prop::collection::vec(-2.0_f32..2.0, count)
}

/// Positions, velocities and efforts.
type Side = [Vec<f32>; 3];

/// Creates a random matrix, with positions, velocities and efforts for its dofs and servos.
fn matrices() -> impl Strategy<Value = (Vec<Vec<f32>>, Vec<f32>, Side, Side)> {
    (1..=4_usize, 1..=4_usize).prop_flat_map(|(dofs, servos)| {
        let sides = |count| [numbers(count), numbers(count), numbers(count)];
        (prop::collection::vec(numbers(servos), dofs), numbers(dofs), sides(dofs), sides(servos))
    })
}

proptest! {
    #[test]
    fn a_matrix_goes_there_and_back_and_does_the_same_work(
        (rows, offset, [q, qd, effort], [s, sd, torque]) in matrices()
    ) {
        let matrix = match Matrix::new(&rows, &offset) {
            Err(DriveError::Singular { .. }) => return Ok(()),
            made => Drive::from(made.unwrap()),
        };
        let (dofs, servos) = (matrix.dofs(), matrix.servos());
        if dofs >= servos {
            let pose = matrix.at_servos(&s).unwrap();
            assert_near(matrix.at_joints(pose.joints()).unwrap().servos(), &s, THERE_AND_BACK);
            let moved = pose.joint_velocities(&sd).unwrap();
            assert_near(&pose.servo_velocities(&moved).unwrap(), &sd, THERE_AND_BACK);
            let given = pose.joint_efforts(&torque).unwrap();
            assert_same_power((&given, &moved), (&torque, &sd));
            assert_same_power((&effort, &moved), (&pose.servo_torques(&effort).unwrap(), &sd));
        }
        if dofs <= servos {
            let pose = matrix.at_joints(&q).unwrap();
            assert_near(matrix.at_servos(pose.servos()).unwrap().joints(), &q, THERE_AND_BACK);
            let moved = pose.servo_velocities(&qd).unwrap();
            assert_near(&pose.joint_velocities(&moved).unwrap(), &qd, THERE_AND_BACK);
            let given = pose.servo_torques(&effort).unwrap();
            assert_near(&pose.joint_efforts(&given).unwrap(), &effort, THERE_AND_BACK);
            assert_same_power((&effort, &qd), (&given, &moved));
        }
    }

    #[test]
    fn a_ball_joint_turns_and_takes_power_as_its_rotation_vector_says(
        rows in prop::collection::vec(numbers(3), 3),
        direction in numbers(3), angle in 0.0_f32..3.1, sd in numbers(3), torque in numbers(3),
    ) {
        prop_assume!(dot(&direction, &direction) > 0.01);
        let drive = match Matrix::of_ball(&rows, &[]) {
            Err(DriveError::Singular { .. }) => return Ok(()),
            made => Drive::from(made.unwrap()),
        };
        let phi = Vec3::from_slice(&direction).normalize() * angle;
        let pose = drive.at_joints(&phi.to_array()).unwrap();
        prop_assert_eq!(pose.reason(), None);
        // Power, and conversion back of velocities and efforts.
        let omega = pose.joint_velocities(&sd).unwrap();
        assert_near(&pose.servo_velocities(&omega).unwrap(), &sd, 10.0 * THERE_AND_BACK);
        let moment = pose.joint_efforts(&torque).unwrap();
        assert_same_power((&moment, &omega), (&torque, &sd));
        // Angular velocity in body axes, from rotations slightly before and after.
        let h = 5e-3;
        let at = |time: f32| {
            let s: Vec<f32> = pose.servos().iter().zip(&sd).map(|(s, sd)| s + time * sd).collect();
            let rows = rows.iter().map(|row| dot(row, &s));
            math::exp(Vec3::from_slice(&rows.collect::<Vec<_>>()))
        };
        let moved = math::log(at(-h).conjugate() * at(h)) / (2.0 * h);
        // Rounding over 2 h, plus h² times third derivatives for speeds of up to 12 rad/s.
        let tolerance = 2e-3 * (1.0 + size(&omega).powi(3));
        prop_assert!((moved - Vec3::from_slice(&omega)).length() < tolerance, "{} {:?}", moved, omega);
    }

    #[test]
    fn a_curve_is_there_and_back_monotone_and_smooth(
        steps in prop::collection::vec((0.05_f32..0.4, 0.05_f32..0.4), 1..CURVE_CAPACITY),
        start in (-2.0_f32..2.0, -2.0_f32..2.0), falling: bool, effort in -5.0_f32..5.0,
    ) {
        let sign = if falling { -1.0 } else { 1.0 };
        let mut points = vec![[start.0, start.1]];
        for (ds, dq) in steps {
            let [s, q] = points[points.len() - 1];
            points.push([s + ds, q + sign * dq]);
        }
        let curve = match Curve::new(&points) {
            Err(DriveError::Flat { .. }) => return Ok(()),
            made => Drive::from(made.unwrap()),
        };
        let ([first, ..], [last, ..]) = (points[0], points[points.len() - 1]);
        let joint_at = |s: f32| curve.at_servos(&[s]).unwrap().joints()[0];
        for [s, q] in &points {
            assert_near(&[joint_at(*s)], &[*q], 1e-6);
        }
        let mut before = f32::NEG_INFINITY;
        for step in 0..=200_u8 {
            let s = first + (last - first) * f32::from(step) / 200.0;
            let pose = curve.at_servos(&[s]).unwrap();
            let q = pose.joints()[0];
            prop_assert!(sign * q > before);
            before = sign * q;
            // After conversion back, the joint's position is equal within a few roundings of positions of up to 8.
            let back = curve.at_joints(&[q]).unwrap();
            prop_assert!((back.joints()[0] - q).abs() < 4e-6, "{} {}", back.joints()[0], q);
            let slope = pose.joint_velocities(&[1.0]).unwrap()[0];
            // The servo's position is equal within the same roundings, divided by the slope.
            let tolerance = 4e-6 * (1.0 + 1.0 / slope.abs());
            prop_assert!((back.servos()[0] - s).abs() < tolerance, "{} {}", back.servos()[0], s);
            let torque = pose.servo_torques(&[effort]).unwrap()[0];
            assert_same_power((&[effort], &[slope]), (&[torque], &[1.0]));
        }
        let slope_at = |s: f32| curve.at_servos(&[s]).unwrap().joint_velocities(&[1.0]).unwrap()[0];
        for pair in points.windows(2) {
            let ([from, _], width) = (pair[0], (pair[1][0] - pair[0][0]) / 8.0);
            for part in 0..8_u8 {
                let (a, b) = (from + width * f32::from(part), from + width * f32::from(part + 1));
                // Simpson's rule is exact for the slope of a cubic: only rounding of positions of up to 8 remains.
                let area = (slope_at(a) + 4.0 * slope_at(0.5 * (a + b)) + slope_at(b)) * (b - a) / 6.0;
                prop_assert!((area - (joint_at(b) - joint_at(a))).abs() < 1e-5, "{} {}", a, b);
            }
            // The slope has no step at a point. It may differ by the curvature, at most 6 * 8 / 0.05, times a
            // rounding of the servo's position.
            let [left, right] = [from.next_down(), from.next_up()].map(slope_at);
            prop_assert!((left - right).abs() < 2e-3, "{} {}", left, right);
        }
        for beyond in [first - 0.1, last + 0.1] {
            let pose = curve.at_servos(&[beyond]).unwrap();
            prop_assert_eq!(pose.reason(), Some(LimitReason::Range));
            prop_assert!(pose.servos() == [first] || pose.servos() == [last]);
        }
    }

    #[test]
    fn a_four_bar_is_refused_where_it_is_singular_and_right_where_it_is_not(
        crank in 0.2_f32..1.5, coupler in 0.3_f32..2.5, rocker in 0.3_f32..2.0,
        middle in -3.0_f32..3.0, half in 0.05_f32..1.5, crossed: bool, effort in -5.0_f32..5.0,
    ) {
        let links = Links {
            ground_m: 0.05,
            crank_m: 0.05 * crank,
            coupler_m: 0.05 * coupler,
            rocker_m: 0.05 * rocker,
            crank_zero_rad: middle,
            rocker_zero_rad: 0.0,
            crossed,
        };
        try_four_bar(links, half, effort);
    }
}

/// Tries a four-bar: asserts that a refusal is confirmed by samples, or that the drive is correct at every sample.
/// Returns the outcome.
fn try_four_bar(links: Links, half: f32, effort: f32) -> &'static str {
    let sampled = sampled_least_angle(&links, half);
    let mut links = links;
    let mut made = FourBar::new(links, [-half, half]);
    if made == Err(DriveError::RockerWraps) {
        // If the rocker turns by more than 180 deg from its zero, its zero is moved to the middle of its range.
        let angles = (-500..=500)
            .filter_map(|k| rocker_angle(&links, f64::from(half) * f64::from(k) / 500.0));
        let (mut last, mut range) = (None, [f64::INFINITY, f64::NEG_INFINITY]);
        for angle in angles {
            // Continues the angle beyond 180 deg.
            let turn = |last: f64| ((last - angle) / TAU).round() * TAU;
            let angle = angle + last.map_or(0.0, turn);
            (last, range) = (Some(angle), [range[0].min(angle), range[1].max(angle)]);
        }
        #[expect(clippy::cast_possible_truncation, reason = "a zero may be anywhere")]
        let rocker_zero_rad = (0.5 * (range[0] + range[1])) as f32;
        links.rocker_zero_rad = rocker_zero_rad;
        made = FourBar::new(links, [-half, half]);
    }
    let refused = match made {
        Ok(four_bar) => {
            let least = sampled.expect("it closes everywhere");
            assert!(least > 4.99_f64.to_radians(), "{}", least.to_degrees());
            check_four_bar(&Drive::from(four_bar), &links, half, effort);
            return "made";
        }
        Err(DriveError::Open { .. }) => "open",
        Err(DriveError::Toggle { .. }) => "toggle",
        Err(DriveError::Transmission { .. }) => "transmission",
        Err(other) => panic!("{other}"),
    };
    // 4000 samples may miss the minimum by 4e-4 rad of the crank.
    assert!(sampled.is_none_or(|least| least < 5.2_f64.to_radians()), "{sampled:?} {made:?}");
    refused
}

#[test]
fn four_bars_of_a_grid_are_made_and_refused_for_every_reason() {
    let mut ends = std::collections::BTreeMap::new();
    for step in 0..3000_u16 {
        let digit = |place: u32, count: u16| f32::from(step / 6_u16.pow(place) % count);
        let links = Links {
            ground_m: 0.05,
            crank_m: 0.01 + 0.012 * digit(0, 6),
            coupler_m: 0.02 + 0.02 * digit(1, 6),
            rocker_m: 0.02 + 0.015 * digit(2, 6),
            crank_zero_rad: 0.9 * digit(3, 6) - 2.4,
            rocker_zero_rad: 0.0,
            crossed: step % 2 == 1,
        };
        *ends.entry(try_four_bar(links, 0.6, 1.0)).or_insert(0) += 1;
    }
    // Each of the four outcomes occurs often enough.
    assert!(ends.len() == 4 && ends.values().all(|count| *count > 40), "{ends:?}");
    assert!(ends["made"] > 500, "{ends:?}");
}

/// Returns the angle of the rocker from the ground line in f64, by an independent method: intersection of the
/// circles of rod and lever. `None` if they do not intersect.
fn rocker_angle(links: &Links, servo: f64) -> Option<f64> {
    let [g, a, b, c] =
        [links.ground_m, links.crank_m, links.coupler_m, links.rocker_m].map(f64::from);
    let zero = f64::from(links.crank_zero_rad);
    let (x, y) = (a * (servo + zero).cos() - g, a * (servo + zero).sin());
    // x cosφ + y sinφ = k on the lever's circle.
    let k = (x * x + y * y + c * c - b * b) / (2.0 * c);
    let length = x.hypot(y);
    let side = if (zero.sin() < 0.0) == links.crossed { 1.0 } else { -1.0 };
    ((k / length).abs() <= 1.0).then(|| y.atan2(x) - side * (k / length).acos())
}

/// Returns the minimum angle between crank and rod, or rod and lever, at samples in the range; `None` if the links
/// cannot be connected.
fn sampled_least_angle(links: &Links, half: f32) -> Option<f64> {
    let [g, a, c] = [links.ground_m, links.crank_m, links.rocker_m].map(f64::from);
    let mut least = f64::INFINITY;
    for step in 0..=4000 {
        let servo = f64::from(half) * (f64::from(step) / 2000.0 - 1.0);
        let phi = rocker_angle(links, servo)?;
        let theta = servo + f64::from(links.crank_zero_rad);
        let (tip, lever) = ([a * theta.cos(), a * theta.sin()], [c * phi.cos(), c * phi.sin()]);
        let rod = [g + lever[0] - tip[0], lever[1] - tip[1]];
        for link in [tip, lever] {
            let cross = (link[0] * rod[1] - link[1] * rod[0]).abs();
            let along = (link[0] * rod[0] + link[1] * rod[1]).abs();
            least = least.min(cross.atan2(along));
        }
    }
    Some(least)
}

fn check_four_bar(drive: &Drive, links: &Links, half: f32, effort: f32) {
    for step in 0..=100_u8 {
        let s = half * (f32::from(step) / 50.0 - 1.0);
        let pose = drive.at_servos(&[s]).unwrap();
        let q = pose.joints()[0];
        let exact = rocker_angle(links, f64::from(s)).unwrap() - f64::from(links.rocker_zero_rad);
        let off = (f64::from(q) - exact).rem_euclid(TAU);
        // At 5 deg the uncertainty of a triangle's angle is eleven times that of its sides, and this occurs twice.
        assert!(off.min(TAU - off) < 5e-5, "{s}: {q} for {exact}");
        let back = drive.at_joints(&[q]).unwrap();
        let slope = pose.joint_velocities(&[1.0]).unwrap()[0];
        let tolerance = 5e-5 * (1.0 + 1.0 / slope.abs());
        assert!((back.servos()[0] - s).abs() < tolerance, "{s}: {:?}", back.servos());
        let torque = pose.servo_torques(&[effort]).unwrap()[0];
        assert_same_power((&[effort], &[slope]), (&[torque], &[1.0]));
        // Slope of the chord by the f64 method, between 1e-5 rad to each side.
        let h = 1e-5;
        if let [Some(before), Some(after)] = [-h, h].map(|h| rocker_angle(links, f64::from(s) + h))
        {
            let turned = (after - before + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
            let chord = turned / (2.0 * h);
            assert!(
                (f64::from(slope) - chord).abs() < 2e-3 * (1.0 + chord.abs()),
                "{slope} {chord}"
            );
        }
    }
    for beyond in [-half - 0.1, half + 0.1] {
        let pose = drive.at_servos(&[beyond]).unwrap();
        assert_eq!(pose.reason(), Some(LimitReason::Range));
        assert_eq!(pose.servos(), [beyond.clamp(-half, half)]);
    }
}

#[test]
fn drives_of_the_workshop() {
    let one = |rows: &[&[f32]]| Drive::from(Matrix::new(rows, &[]).unwrap());
    // Two servos that face each other: each supplies half of the effort.
    let mirrored = one(&[&[0.5, -0.5]]);
    let pose = mirrored.at_joints(&[0.4]).unwrap();
    assert_near(pose.servos(), &[0.4, -0.4], 1e-6);
    assert_near(&pose.servo_torques(&[3.0]).unwrap(), &[1.5, -1.5], 1e-6);
    assert_near(&pose.reflected_to_joints(&[0.002, 0.002]).unwrap(), &[0.004], 1e-6);
    // A mimic joint: one servo turns both, and its rotor is counted once.
    let mimic = one(&[&[1.0], &[0.5]]);
    let pose = mimic.at_servos(&[0.6]).unwrap();
    assert_near(pose.joints(), &[0.6, 0.3], 1e-6);
    let speeds = pose.joint_velocities(&[2.0]).unwrap();
    let inertia = pose.reflected_to_joints(&[0.002]).unwrap();
    let energy: f32 = inertia.iter().zip(&speeds).map(|(i, v)| 0.5 * i * v * v).sum();
    assert!((energy - 0.5 * 0.002 * 4.0).abs() < 1e-8, "{energy}");
    // A differential pair: each dof has both rotors.
    let pair = one(&[&[0.5, 0.5], &[0.5, -0.5]]);
    let pose = pair.at_joints(&[0.0, 0.0]).unwrap();
    assert_near(&pose.reflected_to_joints(&[0.002, 0.002]).unwrap(), &[0.004, 0.004], 1e-6);
    // A four-bar of equal sides has a ratio of one: the servo's rotor inertia is the joint's.
    let links = Links {
        ground_m: 0.05,
        crank_m: 0.02,
        coupler_m: 0.05,
        rocker_m: 0.02,
        crank_zero_rad: math::PI / 2.0,
        rocker_zero_rad: math::PI / 2.0,
        crossed: false,
    };
    let parallel = Drive::from(FourBar::new(links, [-1.0, 1.0]).unwrap());
    let pose = parallel.at_servos(&[0.7]).unwrap();
    assert_near(pose.joints(), &[0.7], 1e-5);
    assert_near(&pose.reflected_to_joints(&[0.002]).unwrap(), &[0.002], 1e-5);
    // If crank and ground are in line, all four links are in line, and the linkage may change its side.
    let too_far = FourBar::new(links, [-1.0, 1.6]).unwrap_err();
    assert!(
        matches!(too_far, DriveError::Transmission { .. } | DriveError::Toggle { .. }),
        "{too_far:?}"
    );
}

#[test]
fn singular_drives_are_refused_by_number() {
    let refused = |rows: &[&[f32]]| Matrix::new(rows, &[]).unwrap_err().to_string();
    let message = refused(&[&[1.0, 1.0], &[1.0, 1.0]]);
    assert!(
        message.starts_with("the matrix is singular or near it: its condition number is"),
        "{message}"
    );
    assert!(matches!(
        Matrix::new(&[[1.0, 1.0], [1.0, 1.03]], &[]),
        Err(DriveError::Singular { condition, most: 100.0 }) if (condition - 135.0).abs() < 1.0
    ));
    // The different units of the rows (metres and radians) do not matter.
    assert!(Matrix::new(&[[0.001, 0.001], [0.5, -0.5]], &[]).is_ok());
    assert_eq!(
        refused(&[&[1.0], &[0.0]]),
        "no servo moves dof 1: the largest number of its row is 0; it must be at least 1e-6 in size"
    );
    assert!(matches!(Matrix::new(&[[1.0, 0.0]], &[]), Err(DriveError::Idle { servo: 1, .. })));
    assert!(matches!(
        Matrix::new(&[vec![1.0, 0.0], vec![1.0]], &[]),
        Err(DriveError::Length { index: 1, found: 1, expected: 2, .. })
    ));
    for bad in [f32::NAN, f32::INFINITY, 2e6] {
        assert!(matches!(Matrix::new(&[[bad]], &[]), Err(DriveError::Number { .. })));
        assert!(matches!(Curve::new(&[[0.0, 0.0], [bad, 1.0]]), Err(DriveError::Number { .. })));
    }
    assert!(matches!(Curve::new(&[[0.0, 0.0]]), Err(DriveError::TooFew { found: 1, .. })));
    assert!(matches!(
        Curve::new(&[[0.0, 0.0], [0.0, 1.0]]),
        Err(DriveError::NotRising { point: 1 })
    ));
    assert!(matches!(
        Curve::new(&[[0.0, 0.0], [1.0, 1.0], [2.0, 0.5]]),
        Err(DriveError::NotMonotone { .. })
    ));
    assert!(matches!(
        Curve::new(&[[0.0, 0.0], [1.0, 1.0], [2.0, 1.002], [3.0, 2.0]]),
        Err(DriveError::Flat { .. })
    ));
}

#[test]
fn drives_end_at_their_capacity() {
    let wide = |count: usize| vec![vec![1.0; count]];
    assert!(Matrix::new(&wide(6), &[]).is_ok());
    assert_eq!(
        Matrix::new(&wide(7), &[]).unwrap_err(),
        DriveError::TooMany { what: "servos", found: 7, most: 6 }
    );
    let square = |count: usize| -> Vec<Vec<f32>> {
        (0..count).map(|i| (0..count).map(|j| if i == j { 1.0 } else { 0.0 }).collect()).collect()
    };
    assert!(Matrix::new(&square(4), &[]).is_ok());
    let full = Matrix::new(&square(5), &[]).unwrap_err();
    assert_eq!(full.to_string(), "the drive has 25 numbers; it holds 16");
    let none: [[f32; 1]; 0] = [];
    assert!(matches!(Matrix::new(&none, &[]), Err(DriveError::TooFew { .. })));
    #[expect(clippy::cast_precision_loss, reason = "small")]
    let line =
        |count: usize| -> Vec<[f32; 2]> { (0..count).map(|i| [i as f32, i as f32]).collect() };
    assert!(Curve::new(&line(CURVE_CAPACITY)).is_ok());
    assert!(matches!(
        Curve::new(&line(CURVE_CAPACITY + 1)),
        Err(DriveError::TooMany { found: 17, .. })
    ));
}

#[test]
fn what_is_no_number_is_refused_before_it_is_held() {
    let curve = Drive::from(Curve::new(&[[0.0, 0.0], [1.0, 2.0]]).unwrap());
    for bad in [f32::NAN, f32::INFINITY, -2e6] {
        let refused = curve.at_joints(&[bad]).unwrap_err();
        assert!(matches!(refused, DriveInputError::Number { index: 0, .. }), "{refused}");
        let pose = curve.at_joints(&[1.0]).unwrap();
        assert!(pose.servo_torques(&[bad]).is_err() && pose.servo_velocities(&[bad]).is_err());
        assert!(pose.joint_efforts(&[bad]).is_err() && pose.joint_velocities(&[bad]).is_err());
    }
    let message = curve.at_joints(&[0.0, 1.0]).unwrap_err().to_string();
    assert_eq!(message, "the drive takes 1 joint positions, not 2");
}
