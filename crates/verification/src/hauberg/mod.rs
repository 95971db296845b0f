//! Verifies distances of poses, curves and geodesics (`hauberg/1`): the first two in the core, geodesics in the
//! host's f64 solver.

mod case;
mod line;

use glam::{DQuat, DVec3, Vec3};
use sinew_core::pose_space::{
    BodyPoses, JointCoordinates, LineWorkspace, PoseCoordinates, PoseSpace,
};
use sinew_core::{JointKind, Transform, Twist, math};
use sinew_pose_metrics::geodesic::{JointPosition, Options, solve};

use super::error::CaseError;
use super::golden::{Vector, expect_count, largest};
use super::rounding::{DOUBLE, Number};
use super::tally::{Quantity, Tallies};
use super::tolerance as limit;
use case::{CAPACITY, Case, kind};
use line::Line;

pub(super) fn check(name: &str, case: &Case, tallies: &mut Tallies) -> Result<(), CaseError> {
    let count = case.parent.len();
    for (field, found) in [
        ("offset", case.offset.len()),
        ("theta0", case.theta0.len()),
        ("theta1", case.theta1.len()),
        ("line.theta_mid", case.line.theta_mid.len()),
    ] {
        expect_count(field, found, count)?;
    }
    for (field, found) in
        [("F0", case.F0.len()), ("F1", case.F1.len()), ("line.F_mid", case.line.f_mid.len())]
    {
        expect_count(field, found, 3 * count)?;
    }
    let inner = usize::from(case.N).saturating_sub(1);
    for (field, found) in [
        ("line.gradient_rotvec", case.line.gradient_rotvec.len()),
        ("line.gradient_tangent_body", case.line.gradient_tangent_body.len()),
        ("geodesic.F", case.geodesic.f.len()),
    ] {
        expect_count(field, found, inner)?;
    }
    check_core(name, case, tallies)?;
    check_geodesic(name, case, tallies)
}

/// Checks distances, curve and gradient of the straight line in the core.
fn check_core(name: &str, case: &Case, tallies: &mut Tallies) -> Result<(), CaseError> {
    let tree = case.tree()?;
    let space = PoseSpace::new(&tree);
    let coordinates = |vectors: &[Vector]| {
        let poses: Vec<Transform> = tree
            .bodies()
            .iter()
            .zip(vectors)
            .map(|(body, vector)| {
                body.placement * Transform::new(math::exp(vector.rounded()), Vec3::ZERO)
            })
            .collect();
        space.coordinates(&poses).map_err(|error| CaseError::new("theta", error))
    };
    let (a, b) = (coordinates(&case.theta0)?, coordinates(&case.theta1)?);
    let line: Vec<PoseCoordinates<CAPACITY>> =
        (0..=case.N).map(|k| space.on_line(&a, &b, f32::from(k) / f32::from(case.N))).collect();
    let placed: Vec<BodyPoses<CAPACITY>> =
        line.iter().map(|point| space.body_poses(point)).collect();
    let [first, last] = [&placed[0], &placed[placed.len() - 1]];
    let at = format_args!("case {name}");

    let rounded = Line::new(case);
    let mut number = |name: &str, unit, rounded: Number, got: f32, expected: f64| {
        let quantity = Quantity { name, unit, limit: rounded.limit(), scale: expected };
        tallies.add_error(quantity, at, f64::from(got) - expected);
    };
    let got = space.angle_distance(&a, &b);
    number("joint_angle_distance", "rad", rounded.angle_distance(), got, case.joint_angle_distance);
    let got = space.rotation_distance(&space.joint_rotations(&a), &space.joint_rotations(&b));
    number("so3_distance", "rad", rounded.rotation_distance(), got, case.so3_distance);
    let got = space.position_distance(first, last);
    number("chord", "m", rounded.distance(0, usize::from(case.N)), got, case.chord);
    let (length, energy) = (rounded.length(), rounded.energy());
    number("line length", "m", length, space.curve_length(&placed), case.line.length);
    let four_at_a_time = space.line_distance(&a, &b, case.N, &mut LineWorkspace::new());
    let name = "line length, four points at a time";
    number(name, "m", Line::by_fours(case).length(), four_at_a_time, case.line.length);
    number("line energy", "m²", energy, space.curve_energy(&placed), case.line.energy);

    let middle = space.body_poses(&coordinates(&case.line.theta_mid)?);
    let middle_rounded = line::placed(case, &line::coordinates(&case.line.theta_mid));
    for (poses, rounded, expected) in [
        (first, &rounded.places[0], &case.F0),
        (last, &rounded.places[usize::from(case.N)], &case.F1),
        (&middle, &middle_rounded, &case.line.f_mid),
    ] {
        let scale = expected.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        for ((position, rounded), expected) in
            poses.positions_m().zip(rounded).zip(expected.chunks_exact(3))
        {
            let limit = rounded.position.limit();
            let quantity = Quantity { name: "F", unit: "m", limit, scale };
            tallies.add(quantity, at, position, DVec3::from_slice(expected));
        }
    }

    let mut of_motions = vec![Twist::ZERO; tree.len()];
    let mut of_coordinates = vec![JointCoordinates::ZERO; tree.len()];
    for (k, (of_vectors, of_bodies)) in
        case.line.gradient_rotvec.iter().zip(&case.line.gradient_tangent_body).enumerate()
    {
        expect_count("line.gradient_rotvec", of_vectors.len(), tree.len())?;
        expect_count("line.gradient_tangent_body", of_bodies.len(), tree.len())?;
        space.energy_gradient(&placed[k], &placed[k + 1], &placed[k + 2], &mut of_motions);
        space.in_coordinates(&line[k + 1], &of_motions, &mut of_coordinates);
        let [rounded_motions, rounded_vectors] = rounded.gradient(case, k + 1);
        for (name, got, rounded, expected) in [
            (
                "gradient, body axes",
                of_motions.iter().map(|of| of.angular).collect::<Vec<_>>(),
                rounded_motions,
                of_bodies,
            ),
            (
                "gradient, rotation vectors",
                of_coordinates.iter().map(|of| of.angular_rad).collect(),
                rounded_vectors,
                of_vectors,
            ),
        ] {
            let scale = largest(expected);
            for ((got, rounded), expected) in got.into_iter().zip(rounded).zip(expected) {
                let quantity = Quantity { name, unit: "m²", limit: rounded.limit(), scale };
                tallies.add(quantity, at, got, expected.0);
            }
        }
    }
    Ok(())
}

/// Checks the geodesic of the host's solver.
fn check_geodesic(name: &str, case: &Case, tallies: &mut Tallies) -> Result<(), CaseError> {
    let rig = case.rig()?;
    let pose = |vectors: &[Vector]| -> Vec<JointPosition> {
        let turn = |(joint, vector): (usize, &Vector)| match kind(joint) {
            JointKind::Fixed => JointPosition::Fixed,
            _ => JointPosition::Turn(DQuat::from_scaled_axis(vector.0)),
        };
        vectors.iter().enumerate().map(turn).collect()
    };
    let options = Options { steps: usize::from(case.N), ..Options::default() };
    let geodesic = solve(&rig, &pose(&case.theta0), &pose(&case.theta1), &options)
        .map_err(|error| CaseError::new("theta", error))?;
    let at = format_args!("case {name}");
    let mut number = |name: &str, unit, limit: f64, error: f64, scale: f64| {
        tallies.add_error(Quantity { name, unit, limit, scale }, at, error);
    };
    // A lower energy is better, and not an error.
    let above = (geodesic.energy_m2 - case.geodesic.energy).max(0.0);
    let (length, energy) = (case.geodesic.length, case.geodesic.energy);
    let (path, least) = (limit::geodesic_path(), limit::geodesic_energy());
    number("geodesic energy, above", "m²", least * energy, above, energy);
    number("geodesic length", "m", path * length, geodesic.length_m - length, length);
    // Both sides have been rounded, in f64.
    let rounded = Line::new(case);
    let of_line = |rounded: Number| 2.0 * DOUBLE * rounded.limit();
    let expected = case.slerp_line.length;
    let error = geodesic.line_length_m - expected;
    number("slerp line length", "m", of_line(rounded.length()), error, expected);
    let ratio = geodesic.length_m / geodesic.line_length_m;
    let expected = case.ratio_slerp;
    number("ratio", "1", path * expected, ratio - expected, expected);
    let (bound, limit) = (case.slerp_line.energy, of_line(rounded.energy()));
    let above = (geodesic.energy_m2 - bound).max(0.0);
    number("geodesic energy, above the line's", "m²", limit, above, bound);
    for (pose, expected) in geodesic.poses[1..].iter().zip(&case.geodesic.f) {
        expect_count("geodesic.F", expected.len(), 3 * case.parent.len())?;
        for (position, expected) in rig.positions_m(pose).into_iter().zip(expected.chunks_exact(3))
        {
            let error = (position - DVec3::from_slice(expected)).length();
            number("geodesic F", "m", path * length, error, length);
        }
    }
    Ok(())
}
