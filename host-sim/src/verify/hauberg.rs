//! Distances of poses, curves and geodesics (`hauberg/1`): the first two by the core, geodesics by the host in f64.

use glam::{DQuat, DVec3, Vec3};
use serde::Deserialize;
use sinew_core::pose_space::{
    BodyPoses, JointCoordinates, LineWorkspace, PoseCoordinates, PoseSpace,
};
use sinew_core::projection::JointRange;
use sinew_core::{Body, Inertia, JointKind, Transform, Tree, Twist, math};

use super::CaseError;
use super::golden::{Vector, expect_count};
use super::tally::{Limit, Quantity, Tallies};
use super::tolerance as limit;
use crate::geodesic::{JointPosition, Options, Rig, RigJoint, solve};

/// The core's largest capacity.
const CAPACITY: usize = 128;

#[derive(Deserialize)]
#[expect(non_snake_case, reason = "as in the files")]
pub(super) struct Case {
    parent: Vec<i64>,
    offset: Vec<Vector>,
    N: u16,
    theta0: Vec<Vector>,
    theta1: Vec<Vector>,
    F0: Vec<f64>,
    F1: Vec<f64>,
    joint_angle_distance: f64,
    so3_distance: f64,
    chord: f64,
    line: Line,
    slerp_line: Length,
    geodesic: Geodesic,
    ratio_slerp: f64,
}

#[derive(Deserialize)]
struct Line {
    energy: f64,
    length: f64,
    gradient_rotvec: Vec<Vec<Vector>>,
    gradient_tangent_body: Vec<Vec<Vector>>,
    theta_mid: Vec<Vector>,
    #[serde(rename = "F_mid")]
    f_mid: Vec<f64>,
}

#[derive(Deserialize)]
struct Length {
    energy: f64,
    length: f64,
}

#[derive(Deserialize)]
struct Geodesic {
    energy: f64,
    length: f64,
    #[serde(rename = "F")]
    f: Vec<Vec<f64>>,
}

impl Case {
    fn parent(&self, joint: usize) -> Option<usize> {
        usize::try_from(self.parent[joint]).ok()
    }

    fn tree(&self) -> Result<Tree<CAPACITY>, CaseError> {
        let bodies: Vec<Body> = (0..self.parent.len())
            .map(|joint| Body {
                parent: self.parent(joint),
                joint: kind(joint),
                placement: Transform::from_translation(self.offset[joint].rounded()),
                inertia: Inertia::default(),
                rotor_inertia: 0.0,
            })
            .collect();
        Tree::from_bodies(&bodies).map_err(|error| CaseError::new("parent", error))
    }

    fn rig(&self) -> Result<Rig, CaseError> {
        let joints: Vec<RigJoint> = (0..self.parent.len())
            .map(|joint| RigJoint {
                parent: self.parent(joint),
                kind: kind(joint),
                rotation: DQuat::IDENTITY,
                offset_m: self.offset[joint].0,
                range: JointRange::Any,
                weight: 1.0,
            })
            .collect();
        Rig::new(&joints).map_err(|error| CaseError::new("parent", error))
    }
}

/// The root is fixed, all else turns as it likes.
fn kind(joint: usize) -> JointKind {
    if joint == 0 { JointKind::Fixed } else { JointKind::Spherical }
}

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

/// Distances, curve and gradient of the straight line, by the core.
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

    let mut number = |quantity: &str, limit: Limit, got: f32, expected: f64| {
        let quantity = Quantity { name: quantity, limit, scale: expected.abs() };
        tallies.add_error(quantity, at, f64::from(got) - expected);
    };
    number(
        "joint_angle_distance",
        limit::ANGLE_DISTANCE,
        space.angle_distance(&a, &b),
        case.joint_angle_distance,
    );
    number(
        "so3_distance",
        limit::ANGLE_DISTANCE,
        space.rotation_distance(&a, &b),
        case.so3_distance,
    );
    number("chord", limit::POSE_DISTANCE, space.position_distance(first, last), case.chord);
    number("line length", limit::POSE_DISTANCE, space.curve_length(&placed), case.line.length);
    let four_at_a_time = space.line_distance(&a, &b, case.N, &mut LineWorkspace::new());
    number(
        "line length, four points at a time",
        limit::POSE_DISTANCE,
        four_at_a_time,
        case.line.length,
    );
    number("line energy", limit::CURVE_ENERGY, space.curve_energy(&placed), case.line.energy);

    let middle = space.body_poses(&coordinates(&case.line.theta_mid)?);
    for (poses, expected) in [(first, &case.F0), (last, &case.F1), (&middle, &case.line.f_mid)] {
        let scale = expected.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        for (position, expected) in poses.positions_m().zip(expected.chunks_exact(3)) {
            let quantity = Quantity { name: "F", limit: limit::CHAIN_POSITION, scale };
            tallies.add_error(
                quantity,
                at,
                (position.as_dvec3() - DVec3::from_slice(expected)).abs().max_element(),
            );
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
        let got = of_motions.iter().map(|of| of.angular);
        add_gradient("gradient, body axes", case, got, of_bodies, tallies, at);
        let got = of_coordinates.iter().map(|of| of.angular_rad);
        add_gradient("gradient, rotation vectors", case, got, of_vectors, tallies, at);
    }
    Ok(())
}

/// Differences of gradients, which are of positions of the size of the figure, over its squared size.
fn add_gradient(
    name: &str,
    case: &Case,
    got: impl Iterator<Item = Vec3>,
    expected: &[Vector],
    tallies: &mut Tallies,
    at: std::fmt::Arguments<'_>,
) {
    let size_m = case.F0.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
    let scale = size_m * size_m * case.parent.len() as f64;
    for (got, expected) in got.zip(expected) {
        let error = (got.as_dvec3() - expected.0).abs().max_element();
        tallies.add_error(Quantity { name, limit: limit::ENERGY_GRADIENT, scale }, at, error);
    }
}

/// The geodesic, by the host's solver.
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
    let mut number = |quantity: &str, limit: Limit, error: f64, scale: f64| {
        tallies.add_error(Quantity { name: quantity, limit, scale }, at, error);
    };
    // Lower is better, and no mistake.
    let above = (geodesic.energy_m2 - case.geodesic.energy).max(0.0);
    number("geodesic energy, above", limit::GEODESIC_ENERGY, above, case.geodesic.energy);
    number(
        "geodesic length",
        limit::GEODESIC_PATH,
        geodesic.length_m - case.geodesic.length,
        case.geodesic.length,
    );
    number(
        "slerp line length",
        limit::SOLID,
        geodesic.line_length_m - case.slerp_line.length,
        case.slerp_line.length,
    );
    let ratio = geodesic.length_m / geodesic.line_length_m;
    number("ratio", limit::GEODESIC_PATH, ratio - case.ratio_slerp, case.ratio_slerp);
    let bound = case.slerp_line.energy;
    number(
        "geodesic energy, above the line's",
        limit::SOLID,
        (geodesic.energy_m2 - bound).max(0.0),
        bound,
    );
    for (pose, expected) in geodesic.poses[1..].iter().zip(&case.geodesic.f) {
        expect_count("geodesic.F", expected.len(), 3 * case.parent.len())?;
        for (position, expected) in rig.positions_m(pose).into_iter().zip(expected.chunks_exact(3))
        {
            let error = (position - DVec3::from_slice(expected)).abs().max_element();
            number("geodesic F", limit::GEODESIC_PATH, error, case.geodesic.length);
        }
    }
    Ok(())
}
