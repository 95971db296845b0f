//! Matches a recording with its rig.

use serde::Serialize;
use sinew_performance::play::Recording;
use sinew_rig::mechanism::{JointModel, Mechanism};
use sinew_rig::{Description, description::DescriptionError};
use thiserror::Error;

use super::watch::Columns;
use crate::rig::{Body, bodies};

/// The error of a recording that does not belong to a rig.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RigError {
    /// The rig's drives are invalid.
    #[error(transparent)]
    Description(#[from] DescriptionError),
    /// The rig has a joint that was not recorded.
    #[error("the rig has a joint {0:?}, which was not recorded: it is another rig")]
    NotRecorded(String),
    /// The rig lacks a recorded joint.
    #[error("a joint {0:?} was recorded, which the rig does not have: it is another rig")]
    Unknown(String),
}

/// A joint of the page.
#[derive(Debug, Serialize)]
pub(super) struct Joint {
    body: usize,
    axis: usize,
    pub(super) name: String,
    pub(super) slides: bool,
    home: f64,
    /// Range in the drawing, finite.
    range: [f64; 2],
    #[serde(skip)]
    pub(super) columns: Columns,
}

#[derive(Debug, Serialize)]
pub(super) struct Rig<'a> {
    pub(super) bodies: Vec<Body<'a>>,
    pub(super) dofs: &'a [Joint],
}

impl<'a> Rig<'a> {
    pub(super) fn of(mechanism: &'a Mechanism, dofs: &'a [Joint]) -> Self {
        Self { bodies: bodies(mechanism), dofs }
    }
}

/// Returns the joints of a rig, in its order, with their columns in the recording.
pub(super) fn joints(
    recording: &Recording,
    description: &Description,
    mechanism: &Mechanism,
) -> Result<Vec<Joint>, RigError> {
    let names = mechanism.dof_names();
    if let Some(unknown) = recording.joints().iter().find(|name| !names.contains(name)) {
        return Err(RigError::Unknown(unknown.clone()));
    }
    let first_servos = first_servos(recording, description)?;
    let (mut names, mut joints) = (names.into_iter(), Vec::new());
    for (body, link) in mechanism.bodies.iter().enumerate() {
        let slides = matches!(link.joint, JointModel::Prismatic(_));
        let far = if slides { 0.1 } else { std::f64::consts::PI };
        let is_ball = link.joint == JointModel::Spherical;
        let servo = description.joints.iter().position(|joint| joint.name == link.joint_name);
        let servo = servo.and_then(|joint| first_servos[joint]);
        for axis in 0..link.joint.kind().dof_count() {
            let name = names.next().unwrap_or_default();
            let joint = recording.joints().iter().position(|recorded| *recorded == name);
            let joint = joint.ok_or_else(|| RigError::NotRecorded(name.clone()))?;
            let range = match link.ranges.get(if is_ball { 0 } else { axis }) {
                // A ball joint has one limit for all directions.
                Some([_, most]) if is_ball => [-most, *most],
                Some(range) => *range,
                None => [f64::NEG_INFINITY, f64::INFINITY],
            };
            joints.push(Joint {
                body,
                axis,
                name,
                slides,
                home: if is_ball { 0.0 } else { link.home[axis] },
                range: range.map(|end| end.clamp(-far, far)),
                columns: Columns { joint, servo },
            });
        }
    }
    Ok(joints)
}

/// Returns, for each joint of the description, the column of its first servo.
fn first_servos(
    recording: &Recording,
    description: &Description,
) -> Result<Vec<Option<usize>>, RigError> {
    let mut first = vec![None; description.joints.len()];
    for drive in description.actuation()?.drives {
        let name = drive.servos.first().map(|servo| description.servos[*servo].name.as_str());
        let column = name.and_then(|name| {
            // A servo with the name of a joint has its own columns.
            let own = format!("{name}.servo");
            let of = |wanted: &str| recording.servos().iter().position(|servo| servo == wanted);
            of(&own).or_else(|| of(name))
        });
        for joint in drive.joints {
            first[joint] = column;
        }
    }
    Ok(first)
}
