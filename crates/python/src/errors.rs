//! State errors between desired and measured poses of bodies in the world, by the methods of the core.

use std::str::FromStr;

use glam::{DQuat, DVec3};
use numpy::{PyArray3, PyReadonlyArray2};
use pyo3::prelude::*;
use sinew_core::projection::ProjectionWorkspace;
use sinew_core::state_error::{
    AimStatus, Aims, Compensation, RateTerm, References, StateError, accumulated,
    linear_compensation, local, world,
};
use sinew_core::tracker::{MethodName, Settings};
use sinew_core::{
    Body, BodyState, Inertia, JointKind, JointState, Transform, Tree, Twist, kinematics,
};
use sinew_rig::mechanism::BODY_COUNT_MAX;

use crate::arrays::{Rows, array};
use crate::error::value;
use crate::heading::Anchor;
use crate::rig::NativeRig;
use crate::work::in_pieces;

/// A method to compute state errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Method {
    Local,
    World,
    Egocentric,
    Heading,
    LinearCompensation,
    Projection,
}

impl FromStr for Method {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Ok(match name {
            "local" => Self::Local,
            "world" => Self::World,
            "egocentric" => Self::Egocentric,
            "heading" => Self::Heading,
            "linear_compensation" => Self::LinearCompensation,
            "projection" => Self::Projection,
            found => {
                return Err(format!(
                    "method: expected local, world, egocentric, heading, linear_compensation or projection, found \
                     `{found}`"
                ));
            }
        })
    }
}

/// Poses of bodies in the world, and perhaps their velocities, for each frame.
struct States {
    name: &'static str,
    bodies: usize,
    poses: Rows,
    velocities: Option<Rows>,
}

impl States {
    fn of(
        name: &'static str,
        bodies: usize,
        poses: &PyReadonlyArray2<'_, f64>,
        velocities: Option<&PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<Self> {
        let poses = Rows::of(name, poses, 7 * bodies)?;
        let rates = format!("{name}_velocity");
        let velocities = velocities.map(|rows| Rows::of(&rates, rows, 6 * bodies)).transpose()?;
        if let Some(velocities) = &velocities {
            velocities.expect(&rates, poses.count)?;
        }
        Ok(Self { name, bodies, poses, velocities })
    }

    /// Returns the pose of a body in a frame: rotation and position.
    fn pose(&self, frame: usize, body: usize) -> PyResult<(DQuat, DVec3)> {
        let numbers = &self.poses.row(frame)[7 * body..][..7];
        let place = || format!("{}[{frame}, {body}]", self.name);
        // NaN is in no range.
        if let Some(bad) = numbers.iter().find(|x| !(-1e6..=1e6).contains(*x)) {
            return Err(value(format!(
                "{}: expected numbers from -1e6 to 1e6, found {bad}",
                place()
            )));
        }
        let rotation = DQuat::from_slice(&numbers[3..]);
        let length = rotation.length();
        if (length - 1.0).abs() > 1e-3 {
            return Err(value(format!(
                "{}: expected x y z and a unit quaternion x y z w, found a quaternion of length {length:.4}",
                place()
            )));
        }
        Ok((rotation.normalize(), DVec3::from_slice(numbers)))
    }

    /// Returns the linear and angular velocity of a body in a frame; zero if there are no velocities.
    fn velocity(&self, frame: usize, body: usize) -> PyResult<[DVec3; 2]> {
        let Some(rows) = &self.velocities else { return Ok([DVec3::ZERO; 2]) };
        let numbers = &rows.row(frame)[6 * body..][..6];
        if let Some(bad) = numbers.iter().find(|x| !(-1e6..=1e6).contains(*x)) {
            let name = self.name;
            return Err(value(format!(
                "{name}_velocity[{frame}, {body}]: expected numbers from -1e6 to 1e6, found {bad}"
            )));
        }
        Ok([DVec3::from_slice(numbers), DVec3::from_slice(&numbers[3..])])
    }

    /// Returns the states of all bodies in a frame. `anchor`: rigid motion that is applied to them.
    fn frame(
        &self,
        frame: usize,
        anchor: Option<Anchor>,
        out: &mut Vec<BodyState>,
    ) -> PyResult<()> {
        out.clear();
        for body in 0..self.bodies {
            let (mut pose, mut velocity) = (self.pose(frame, body)?, self.velocity(frame, body)?);
            if let Some(anchor) = anchor {
                pose = anchor.pose(pose);
                velocity = velocity.map(|part| anchor.velocity(part));
            }
            let [linear, angular] = velocity.map(glam::DVec3::as_vec3);
            out.push(BodyState {
                pose: Transform::new(pose.0.as_quat().normalize(), pose.1.as_vec3()),
                velocity: Twist::new(angular, linear),
            });
        }
        Ok(())
    }
}

/// Returns a tree with these parents, in which all bodies have the same inertia.
fn tree_of(parents: &[Option<usize>]) -> PyResult<Tree<BODY_COUNT_MAX>> {
    let mut tree = Tree::new();
    for parent in parents {
        let body = Body {
            parent: *parent,
            joint: JointKind::Spherical,
            placement: Transform::IDENTITY,
            inertia: Inertia::default(),
            rotor_inertia: 0.0,
        };
        tree.push(body).map_err(|error| value(format!("parents: {error}")))?;
    }
    Ok(tree)
}

/// Returns the errors of each body in each frame: rotation vector, position, and their rates; twelve numbers.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the function of Python has names for them")]
pub(crate) fn errors<'py>(
    py: Python<'py>,
    method: &str,
    bodies: usize,
    desired: PyReadonlyArray2<'py, f64>,
    measured: PyReadonlyArray2<'py, f64>,
    desired_velocity: Option<PyReadonlyArray2<'py, f64>>,
    measured_velocity: Option<PyReadonlyArray2<'py, f64>>,
    parents: Option<Vec<Option<usize>>>,
    rig: Option<PyRef<'py, NativeRig>>,
    beta: f64,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let method: Method = method.parse().map_err(value)?;
    let desired = States::of("desired", bodies, &desired, desired_velocity.as_ref())?;
    let measured = States::of("measured", bodies, &measured, measured_velocity.as_ref())?;
    measured.poses.expect("measured", desired.poses.count)?;
    let tree: Box<Tree<BODY_COUNT_MAX>> = match (&rig, &parents) {
        (Some(rig), None) => Box::new(rig.loaded.mechanism.tree().map_err(value)?),
        (None, Some(parents)) => Box::new(tree_of(parents)?),
        (None, None) if matches!(method, Method::World | Method::Heading) => {
            Box::new(tree_of(&vec![None; usize::from(bodies > 0)])?)
        }
        (None, None) => {
            return Err(value("parents or rig: this method needs the tree of the bodies"));
        }
        (Some(_), Some(_)) => return Err(value("expected parents or rig, found both")),
    };
    if (rig.is_some() || parents.is_some()) && tree.len() != bodies {
        let found = tree.len();
        return Err(value(format!("the tree has {found} bodies, the poses are of {bodies}")));
    }
    if method == Method::Projection && rig.is_none() {
        return Err(value("rig: the method projection needs the rig onto whose poses it projects"));
    }
    if !(0.0..=2.0).contains(&beta) {
        return Err(value(format!("beta: expected a weight from 0 to 2, found {beta}")));
    }
    let compensation =
        Compensation { beta: crate::arrays::single(beta), rate_term: RateTerm::default() };
    let mut measure = Measure {
        method,
        references: References::egocentric(&tree),
        aims: Aims::heaviest_child(&tree),
        compensation,
        projection: Projector::of(method, &tree)?,
        tree,
        joints: [vec![JointState::default(); bodies], vec![JointState::default(); bodies]],
        status: vec![AimStatus::default(); bodies],
    };
    let frames = desired.poses.count;
    let mut out = Vec::with_capacity(12 * frames * bodies);
    let (mut wanted, mut found) = (Vec::new(), Vec::new());
    let mut errors = vec![StateError::ZERO; bodies];
    in_pieces(py, frames, |rows| {
        for frame in rows {
            let anchor = if method == Method::Heading && bodies > 0 {
                Some(Anchor::new(desired.pose(frame, 0)?, measured.pose(frame, 0)?))
            } else {
                None
            };
            desired.frame(frame, anchor, &mut wanted)?;
            measured.frame(frame, None, &mut found)?;
            measure.measure(&mut wanted, &found, &mut errors)?;
            for error in &errors {
                let StateError { angular_rad, linear_m, angular_rate_rad_s, linear_rate_m_s } =
                    error;
                for part in [angular_rad, linear_m, angular_rate_rad_s, linear_rate_m_s] {
                    out.extend(part.to_array().map(f64::from));
                }
            }
        }
        Ok(())
    })?;
    array(py, [frames, bodies, 12], out)
}

/// A method with its parameters and buffers.
struct Measure {
    method: Method,
    tree: Box<Tree<BODY_COUNT_MAX>>,
    references: References<BODY_COUNT_MAX>,
    aims: Aims<BODY_COUNT_MAX>,
    compensation: Compensation,
    projection: Option<Projector>,
    joints: [Vec<JointState>; 2],
    status: Vec<AimStatus>,
}

impl Measure {
    fn measure(
        &mut self,
        desired: &mut [BodyState],
        measured: &[BodyState],
        out: &mut [StateError],
    ) -> PyResult<()> {
        let bodies = self.tree.bodies();
        match self.method {
            Method::World | Method::Heading => world(desired, measured, out),
            Method::Local => {
                let [of_desired, of_measured] = &mut self.joints;
                kinematics::joint_states(bodies, desired, of_desired);
                kinematics::joint_states(bodies, measured, of_measured);
                local(of_desired, of_measured, out);
            }
            Method::Egocentric => {
                accumulated(self.references.as_slice(), desired, measured, out);
            }
            Method::LinearCompensation => linear_compensation(
                self.aims.as_slice(),
                self.compensation,
                desired,
                measured,
                out,
                &mut self.status,
            ),
            Method::Projection => {
                if let Some(projection) = &mut self.projection {
                    projection.project(&self.tree, desired, &mut self.joints[0])?;
                }
                world(desired, measured, out);
            }
        }
        Ok(())
    }
}

/// Projection of the recommended tracker, which starts from the solution of the previous frame.
struct Projector {
    projection: sinew_core::projection::ManifoldProjection<BODY_COUNT_MAX>,
    workspace: Box<ProjectionWorkspace<BODY_COUNT_MAX>>,
}

impl Projector {
    fn of(method: Method, tree: &Tree<BODY_COUNT_MAX>) -> PyResult<Option<Self>> {
        if method != Method::Projection {
            return Ok(None);
        }
        let settings: Settings =
            Settings { method: MethodName::ManifoldProjection, ..Settings::default() };
        let projection = settings.projection(tree).map_err(value)?;
        let workspace = Box::new(ProjectionWorkspace::new());
        Ok(projection.map(|projection| Self { projection, workspace }))
    }

    /// Replaces the desired poses by the nearest poses that the rig can have. The velocities do not change.
    fn project(
        &mut self,
        tree: &Tree<BODY_COUNT_MAX>,
        desired: &mut [BodyState],
        joints: &mut [JointState],
    ) -> PyResult<()> {
        kinematics::joint_states(tree.bodies(), desired, joints);
        let wanted: Vec<Transform> = joints.iter().map(|joint| joint.pose).collect();
        let mut near = wanted.clone();
        self.projection
            .project(tree, &wanted, &mut self.workspace, &mut near)
            .map_err(|error| value(format!("projection: {error}")))?;
        for (joint, pose) in joints.iter_mut().zip(near) {
            joint.pose = pose;
        }
        let mut projected = vec![BodyState::WORLD; desired.len()];
        kinematics::body_states(tree.bodies(), joints, &mut projected);
        for (state, projected) in desired.iter_mut().zip(projected) {
            state.pose = projected.pose;
        }
        Ok(())
    }
}
