//! Distances between poses, geodesics, and the importance of joints.

use std::path::PathBuf;

use glam::DQuat;
use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use sinew_core::{Body, JointKind};
use sinew_figure::measured::UnitOverrides;
use sinew_mocap::Skeleton;
use sinew_pose_metrics::character::{self, Character, Joint, Options};
use sinew_pose_metrics::geodesic::{
    JointPosition, Options as GeodesicOptions, Rig as GeodesicRig, RigJoint, solve,
};
use sinew_pose_metrics::spatial::{
    BODY_COUNT, BODY_COUNT_MAX, Measure, MeasuredPose, Metric, RigMeasure, SpatialRig, Workspace,
};
use sinew_pose_metrics::weights::{Method, Settings, weigh};

use crate::arrays::{Rows, array};
use crate::clip::NativeClip;
use crate::error::value;
use crate::rig::NativeRig;
use crate::work::in_pieces;

/// Returns the local rotations of a row. The error names the row and the joint of an invalid rotation.
fn rotations(name: &str, rows: &Rows, row: usize) -> PyResult<Vec<DQuat>> {
    let one = |(joint, numbers): (usize, &[f64])| {
        let rotation = DQuat::from_slice(numbers);
        let length = rotation.length();
        // NaN is in no range.
        if !(0.999..=1.001).contains(&length) {
            return Err(value(format!(
                "{name}[{row}, {joint}]: expected a unit quaternion x y z w, found one of length {length:.4}"
            )));
        }
        Ok(rotation.normalize())
    };
    rows.row(row).chunks(4).enumerate().map(one).collect()
}

/// Pairs of poses from two lists. If a list has only one pose, this pose is paired with all poses of the other list.
struct Pairs {
    a: Rows,
    b: Rows,
    count: usize,
}

impl Pairs {
    fn of(
        joints: usize,
        a: &PyReadonlyArray2<'_, f64>,
        b: &PyReadonlyArray2<'_, f64>,
    ) -> PyResult<Self> {
        let [a, b] = [Rows::of("a", a, 4 * joints)?, Rows::of("b", b, 4 * joints)?];
        if a.count != b.count && a.count != 1 && b.count != 1 {
            let [a, b] = [a.count, b.count];
            return Err(value(format!(
                "a and b: expected equally many poses, or one of one, found {a} and {b}"
            )));
        }
        let count = if a.count == 1 { b.count } else { a.count };
        Ok(Self { a, b, count })
    }

    fn rotations(&self, pair: usize) -> PyResult<[Vec<DQuat>; 2]> {
        let row = |rows: &Rows| if rows.count == 1 { 0 } else { pair };
        Ok([rotations("a", &self.a, row(&self.a))?, rotations("b", &self.b, row(&self.b))?])
    }
}

fn measure_of(metric: &str, weighted: bool, steps: u16) -> PyResult<Measure> {
    let names = || Metric::ALL.map(Metric::name).join(", ");
    let found = Metric::ALL.into_iter().chain([Metric::Geodesic]);
    let metric = found.into_iter().find(|of| of.name() == metric).ok_or_else(|| {
        value(format!("metric: expected one of {}, geodesic, found `{metric}`", names()))
    })?;
    if !(1..=1000).contains(&steps) {
        return Err(value(format!("steps: expected 1 to 1000, found {steps}")));
    }
    let measure = Measure { steps, ..Measure::new(metric) };
    Ok(if weighted { measure.weighted() } else { measure })
}

/// Returns the distance of each pair of poses.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the function of Python has names for them")]
pub(crate) fn pose_distance<'py>(
    py: Python<'py>,
    clip: PyRef<'py, NativeClip>,
    a: PyReadonlyArray2<'py, f64>,
    b: PyReadonlyArray2<'py, f64>,
    metric: &str,
    weighted: bool,
    steps: u16,
    root: Option<&str>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let measure = measure_of(metric, weighted, steps)?;
    let skeleton = &clip.clip().skeleton;
    let pairs = Pairs::of(skeleton.joints.len(), &a, &b)?;
    // A root that is not the skeleton's root needs one more body.
    let out = if skeleton.joints.len() < BODY_COUNT {
        distances::<BODY_COUNT>(py, skeleton, &pairs, measure, root)?
    } else {
        distances::<BODY_COUNT_MAX>(py, skeleton, &pairs, measure, root)?
    };
    array(py, [out.len()], out)
}

fn distances<const N: usize>(
    py: Python<'_>,
    skeleton: &Skeleton,
    pairs: &Pairs,
    measure: Measure,
    root: Option<&str>,
) -> PyResult<Vec<f64>> {
    let rig = SpatialRig::<N>::sized(skeleton, root).map_err(value)?;
    let measuring = RigMeasure::new(&rig, measure);
    let mut workspace = Box::new(Workspace::new());
    let mut out = Vec::with_capacity(pairs.count);
    in_pieces(py, pairs.count, |rows| {
        for pair in rows {
            let [a, b] = pairs.rotations(pair)?;
            let pose = |rotations: &[DQuat]| -> PyResult<Box<MeasuredPose<N>>> {
                Ok(Box::new(measuring.pose(rotations).map_err(value)?))
            };
            out.push(f64::from(measuring.distance(&*pose(&a)?, &*pose(&b)?, &mut workspace)));
        }
        Ok(())
    })?;
    Ok(out)
}

/// Result of a geodesic: its length, length of the straight line, whether the solver converged, and the local rotations
/// of the joints along the geodesic.
type GeodesicNumbers<'py> = (f64, f64, bool, Bound<'py, PyArray2<f64>>);

/// Finds the shortest path between two poses.
#[pyfunction]
pub(crate) fn geodesic<'py>(
    py: Python<'py>,
    clip: PyRef<'py, NativeClip>,
    a: PyReadonlyArray2<'py, f64>,
    b: PyReadonlyArray2<'py, f64>,
    weighted: bool,
    steps: u16,
) -> PyResult<GeodesicNumbers<'py>> {
    let measure = measure_of("geodesic", weighted, steps)?;
    let skeleton = &clip.clip().skeleton;
    let joints = skeleton.joints.len();
    let pairs = Pairs::of(joints, &a, &b)?;
    let [a, b] = pairs.rotations(0)?;
    let spatial = SpatialRig::<BODY_COUNT_MAX>::sized(skeleton, None).map_err(value)?;
    let weights = if weighted { spatial.importance().to_vec() } else { vec![1.0; joints] };
    let bodies = || spatial.tree().bodies().iter();
    let joint = |(body, weight): (&Body, f32)| RigJoint {
        weight: f64::from(weight),
        ..RigJoint::from(body)
    };
    let rig =
        GeodesicRig::new(&bodies().zip(weights).map(joint).collect::<Vec<_>>()).map_err(value)?;
    let position = |rotations: &[DQuat]| -> Vec<JointPosition> {
        let poses = spatial.joint_poses(rotations);
        let turn = |(body, pose): (&Body, &sinew_core::Transform)| match body.joint {
            JointKind::Spherical => JointPosition::Turn(pose.rotation.as_dquat().normalize()),
            _ => JointPosition::Fixed,
        };
        bodies().zip(&poses).map(turn).collect()
    };
    let options = GeodesicOptions { steps: measure.steps.into(), ..GeodesicOptions::default() };
    let found = py.detach(|| solve(&rig, &position(&a), &position(&b), &options)).map_err(value)?;
    let places = depth_first(skeleton);
    let mut numbers = vec![0.0; found.poses.len() * joints * 4];
    for (pose, of_pose) in found.poses.iter().zip(numbers.chunks_mut(joints * 4)) {
        for (state, place) in pose.iter().zip(&places) {
            let rotation = match state {
                JointPosition::Turn(rotation) => *rotation,
                // The root's own rotation does not affect the distance.
                _ => a[*place],
            };
            of_pose[4 * place..][..4].copy_from_slice(&rotation.to_array());
        }
    }
    let rotations = array(py, [found.poses.len(), joints * 4], numbers)?;
    Ok((found.length_m, found.line_length_m, found.converged, rotations))
}

/// Returns the joints in the order of a spatial rig's bodies: depth first, with children in the skeleton's order.
fn depth_first(skeleton: &Skeleton) -> Vec<usize> {
    let mut order = Vec::with_capacity(skeleton.joints.len());
    let mut open = vec![0];
    while let Some(joint) = open.pop() {
        order.push(joint);
        let joints = skeleton.joints.iter().enumerate().rev();
        open.extend(joints.filter(|(_, of)| of.parent == Some(joint)).map(|(child, _)| child));
    }
    order
}

/// Source of the joints of a character at rest.
#[derive(FromPyObject)]
pub(crate) enum CharacterSource<'py> {
    Rig(PyRef<'py, NativeRig>),
    Clip(PyRef<'py, NativeClip>),
    File(PathBuf),
}

/// Returns the names of a character's joints, and the weight of each joint.
#[pyfunction]
pub(crate) fn importance(
    source: CharacterSource<'_>,
    method: &str,
    base: Option<f64>,
    discount: f64,
) -> PyResult<(Vec<String>, Vec<f64>)> {
    let method = Method::ALL.into_iter().find(|of| of.name() == method).ok_or_else(|| {
        let names = Method::ALL.map(Method::name).join(", ");
        value(format!("method: expected one of {names}, found `{method}`"))
    })?;
    let character = match source {
        CharacterSource::File(path) => {
            let options = Options { units: UnitOverrides::default(), frame: None };
            character::read(&path, &options).map_err(value)?
        }
        CharacterSource::Clip(clip) => {
            let skeleton = &clip.clip().skeleton;
            let at = skeleton.rest_positions_m();
            let joints = skeleton.joints.iter().zip(at).map(|(joint, position_m)| Joint {
                name: joint.name.clone(),
                parent: joint.parent,
                position_m,
            });
            Character::new(clip.clip().name.clone(), joints.collect(), None).map_err(value)?
        }
        CharacterSource::Rig(rig) => {
            let mechanism = &rig.loaded.mechanism;
            let zero: Vec<f64> = rig.links().iter().flat_map(|link| link.joint.zero()).collect();
            let joints = rig.links().iter().zip(mechanism.poses(&zero)).map(|(link, pose)| Joint {
                name: link.joint_name.clone(),
                parent: link.parent,
                position_m: pose.position_m,
            });
            let name = rig.loaded.description.name.clone();
            Character::new(name, joints.collect(), None).map_err(value)?
        }
    };
    let settings = Settings { base, discount, ..Settings::default() };
    let weighing = weigh(&character, method, &settings).map_err(value)?;
    let names = character.joints().iter().map(|joint| joint.name.clone()).collect();
    Ok((names, weighing.weights))
}
