//! Checks that a mechanism can be simulated: that its numbers are physically possible and that it is a tree.

use ::nalgebra as na;
use glam::{DMat3, DQuat, DVec3};
use thiserror::Error;

use super::{JointModel, Link, Mechanism, MovingPose};

/// Maximum deviation of quaternions and axes from unit length.
const UNIT_TOLERANCE: f64 = 1e-6;

/// Rounding error of an inertia, as a share of the largest moment. Some bodies were converted from f32.
const ROUNDING: f64 = 1e-5;

/// The error of a plant that could not be built.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum PlantError {
    /// A step with zero substeps.
    #[error("substeps: expected 1 or more, found 0")]
    NoSubsteps,
    /// A time step that is not a positive, finite time.
    #[error("time step: expected a finite number of seconds above 0, found {found}")]
    TimeStep {
        /// Requested step, in s.
        found: f64,
    },
    /// A mechanism without bodies.
    #[error("a mechanism without bodies; expected one or more")]
    NoBodies,
    /// A number of states that differs from the number of bodies.
    #[error("{states} states for {bodies} bodies; expected one for each")]
    StateCount {
        /// Number of bodies.
        bodies: usize,
        /// Number of states.
        states: usize,
    },
    /// A wrong parent. Body 0 is the root, and parents must precede their children.
    #[error(
        "body {body}: parent {parent:?}; body 0, and only that, has none, and parents come before \
         children"
    )]
    Parent {
        /// Index of the body.
        body: usize,
        /// Index of the body's parent, as given.
        parent: Option<usize>,
    },
    /// A number of a body, or of its initial state, that is physically impossible.
    #[error("body {body}, {item}: expected {expected}, found {found}")]
    Body {
        /// Index of the body.
        body: usize,
        /// Name of the field.
        item: &'static str,
        /// Description of the accepted values.
        expected: &'static str,
        /// Value that was found: the first invalid number of several.
        found: f64,
    },
    /// A joint without inertia to accelerate: it would become infinitely fast.
    #[error(
        "body {body}: nothing resists its joint; expected mass or inertia that it moves, or a rotor_inertia above 0"
    )]
    Weightless {
        /// Index of the body.
        body: usize,
    },
    /// A feature that the engine does not simulate.
    #[error(
        "body {body}: {what}, which the engine does not simulate; the plant `articulated` does"
    )]
    Engine {
        /// Index of the body.
        body: usize,
        /// Name of the feature.
        what: &'static str,
    },
    /// An inertia that the engine's principal axes do not reproduce.
    #[error("body {body}: the engine's inertia differs from the given one by {relative:e} of it")]
    Inertia {
        /// Index of the body.
        body: usize,
        /// Largest difference divided by the largest element.
        relative: f64,
    },
}

/// Checks that this is a tree of possible bodies with a possible state for each, and that the step and the number of
/// substeps are positive.
pub(super) fn check(
    mechanism: &Mechanism,
    start: &[MovingPose],
    dt_s: f64,
    substeps: usize,
) -> Result<(), PlantError> {
    if substeps == 0 {
        return Err(PlantError::NoSubsteps);
    }
    if !(dt_s > 0.0 && dt_s.is_finite()) {
        return Err(PlantError::TimeStep { found: dt_s });
    }
    let bodies = &mechanism.bodies;
    if bodies.is_empty() {
        return Err(PlantError::NoBodies);
    }
    if start.len() != bodies.len() {
        return Err(PlantError::StateCount { bodies: bodies.len(), states: start.len() });
    }
    for (body, (of_body, of_start)) in bodies.iter().zip(start).enumerate() {
        let parent = of_body.parent;
        if !parent.map_or(body == 0, |parent| parent < body) {
            return Err(PlantError::Parent { body, parent });
        }
        check_link(body, of_body)?;
        if let Some((item, expected, found)) = state_fault(of_start) {
            return Err(PlantError::Body { body, item, expected, found });
        }
    }
    Ok(())
}

/// Checks that a body and its joint are physically possible.
///
/// # Errors
/// [`PlantError::Body`] for the first number of the body or its joint that is impossible.
pub fn check_link(body: usize, link: &Link) -> Result<(), PlantError> {
    match body_fault(link).or_else(|| joint_fault(link)) {
        Some((item, expected, found)) => Err(PlantError::Body { body, item, expected, found }),
        None => Ok(()),
    }
}

/// A field's name, its accepted values, and its value.
type Fault = (&'static str, &'static str, f64);

fn body_fault(link: &Link) -> Option<Fault> {
    vector_fault("position_m", link.position_m)
        .or_else(|| rotation_fault("rotation", link.rotation))
        .or_else(|| {
            let good = link.mass_kg >= 0.0 && link.mass_kg.is_finite();
            (!good).then_some(("mass_kg", "a finite mass from 0 kg", link.mass_kg))
        })
        .or_else(|| vector_fault("center_of_mass_m", link.center_of_mass_m))
        .or_else(|| inertia_fault(&link.inertia_kg_m2))
}

fn joint_fault(link: &Link) -> Option<Fault> {
    let axes: &[DVec3] = match &link.joint {
        JointModel::Revolute(axis) | JointModel::Prismatic(axis) => std::slice::from_ref(axis),
        JointModel::Universal(axes) => axes,
        JointModel::Fixed | JointModel::Spherical | JointModel::Free => &[],
    };
    for axis in axes {
        // This condition and those below are written to refuse NaN.
        let unit = (axis.length() - 1.0).abs() <= UNIT_TOLERANCE;
        if !unit {
            return Some(("axis", "a vector of length 1", axis.length()));
        }
    }
    if let &[first, second] = axes
        && first.dot(second).abs() > UNIT_TOLERANCE
    {
        return Some(("axes", "a right angle between them, cosine 0", first.dot(second)));
    }
    for (item, value) in [
        ("rotor_inertia", link.rotor_inertia),
        ("friction", link.friction),
        ("damping", link.damping),
    ] {
        let good = value >= 0.0 && value.is_finite();
        if !good {
            return Some((item, "a finite number from 0", value));
        }
    }
    if let JointModel::Prismatic(_) | JointModel::Revolute(_) | JointModel::Universal(_) =
        link.joint
    {
        let disordered =
            link.ranges.iter().find(|[least, most]| least > most || (least + most).is_nan());
        if let Some([least, _]) = disordered {
            return Some(("ranges", "the least no more than the most", *least));
        }
    }
    let most_ranges = match link.joint {
        JointModel::Fixed | JointModel::Free => 0,
        JointModel::Spherical => 1,
        _ => axes.len(),
    };
    if link.ranges.len() > most_ranges {
        let found = link.ranges.len() as f64;
        return Some(("ranges", "one for each axis, or none", found));
    }
    None
}

fn inertia_fault(inertia: &DMat3) -> Option<Fault> {
    let item = "inertia_kg_m2";
    let elements = inertia.to_cols_array();
    if let Some(found) = elements.into_iter().find(|element| !element.is_finite()) {
        return Some((item, "finite numbers of kg m²", found));
    }
    let largest = elements.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let skew = (*inertia - inertia.transpose()).to_cols_array();
    if let Some(found) = skew.into_iter().find(|element| element.abs() > ROUNDING * largest) {
        return Some((item, "a symmetric matrix, differences of 0 across its diagonal", found));
    }
    let moments = na::Matrix3::from_column_slice(&elements).symmetric_eigenvalues();
    if moments.min() < -ROUNDING * largest {
        return Some((item, "principal moments from 0 kg m²", moments.min()));
    }
    let rest = moments.sum() - moments.max();
    if moments.max() > rest * (1.0 + ROUNDING) {
        let expected = "no principal moment above the sum of the other two, in kg m²";
        return Some((item, expected, moments.max()));
    }
    None
}

fn state_fault(state: &MovingPose) -> Option<Fault> {
    vector_fault("start position_m", state.pose.position_m)
        .or_else(|| rotation_fault("start rotation", state.pose.rotation))
        .or_else(|| vector_fault("start angular_rad_s", state.angular_rad_s))
        .or_else(|| vector_fault("start linear_m_s", state.linear_m_s))
}

fn rotation_fault(item: &'static str, rotation: DQuat) -> Option<Fault> {
    let length = rotation.length();
    // The condition is written to refuse NaN.
    let unit = (length - 1.0).abs() <= UNIT_TOLERANCE;
    (!unit).then_some((item, "a quaternion of length 1", length))
}

fn vector_fault(item: &'static str, v: DVec3) -> Option<Fault> {
    let found = v.to_array().into_iter().find(|x| !x.is_finite())?;
    Some((item, "finite numbers", found))
}
