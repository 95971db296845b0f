//! Converts a description to the compact rig of a board.

use std::collections::HashMap;
use std::ops::Range;

use heapless::Vec;

use super::{BoardDof, BoardDrive, BoardRig, BoardRigError, BoardServo, LinkedLimit};
use crate::actuation::{Actuation, JointFriction};
use crate::description::{self, Description, DescriptionError};
use crate::drive::DRIVE_CAPACITY;
use crate::mechanism::{self, Link, Mechanism};
use crate::number::single;
use crate::servo::{Servo, ServoSettings};

/// The reason why a description cannot be converted for a board.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BakeError {
    /// The description is invalid.
    #[error(transparent)]
    Description(#[from] DescriptionError),
    /// The rig does not fit a board of this capacity.
    #[error(transparent)]
    Board(#[from] BoardRigError),
}

impl<const BODIES: usize, const DOFS: usize, const SERVOS: usize> BoardRig<BODIES, DOFS, SERVOS> {
    /// Converts a description, whose [`Mechanism`] the caller has made.
    ///
    /// # Errors
    /// [`BakeError`] if the description's servos or drives are invalid, or the rig exceeds the board's capacity.
    pub fn bake(rig: &Description, mechanism: &Mechanism) -> Result<Self, BakeError> {
        let (what, found) = ("bodies", mechanism.bodies.len());
        if found > BODIES {
            return Err(BoardRigError::Capacity { what, found, holds: BODIES }.into());
        }
        let actuation = rig.actuation()?;
        let places = places(mechanism);
        let dofs = mechanism.bodies.iter().flat_map(dofs).collect();
        let limits = rig.limits.iter().filter_map(|limit| limit_of(&places, limit)).collect();
        let baked = Self {
            tree: mechanism.tree().map_err(BoardRigError::Tree)?,
            dofs: filled("degrees of freedom", dofs)?,
            limits: filled("linked limits", limits)?,
            servos: filled("servos", servos(rig, &actuation))?,
            drives: filled("drives", drives(rig, &actuation, &places))?,
        };
        baked.check()?;
        Ok(baked)
    }
}

/// Collects all items, or fails if there are more than `N`.
fn filled<T, const N: usize>(
    what: &'static str,
    items: std::vec::Vec<T>,
) -> Result<Vec<T, N>, BoardRigError> {
    let full = BoardRigError::Capacity { what, found: items.len(), holds: N };
    let mut all = Vec::new();
    for item in items {
        all.push(item).map_err(|_| full)?;
    }
    Ok(all)
}

/// Range of dof indices of each joint, by the joint's name.
type Places<'m> = HashMap<&'m str, Range<u16>>;

fn places(mechanism: &Mechanism) -> Places<'_> {
    let mut next = 0_u16;
    let mut places = HashMap::new();
    for link in &mechanism.bodies {
        // No board has 2^16 dofs; `filled` refuses such a rig.
        let count = u16::try_from(link.joint.kind().dof_count()).unwrap_or(u16::MAX);
        let end = next.saturating_add(count);
        places.insert(link.joint_name.as_str(), next..end);
        next = end;
    }
    places
}

fn dofs(link: &Link) -> std::vec::Vec<BoardDof> {
    let is_ball = link.joint == mechanism::JointModel::Spherical;
    let home: std::vec::Vec<f32> = match (link.joint, &link.home[..]) {
        (mechanism::JointModel::Spherical, rotation) => rotation_vector(rotation).to_vec(),
        (mechanism::JointModel::Free, coordinates) => {
            let (rotation, position) = coordinates.split_at_checked(4).unwrap_or_default();
            rotation_vector(rotation)
                .into_iter()
                .chain(position.iter().copied().map(single))
                .collect()
        }
        (_, coordinates) => coordinates.iter().copied().map(single).collect(),
    };
    home.into_iter()
        .enumerate()
        .map(|(axis, home)| {
            let unlimited =
                [if is_ball && axis == 0 { 0.0 } else { f64::NEG_INFINITY }, f64::INFINITY];
            let range = link.ranges.get(axis).copied().unwrap_or(unlimited).map(single);
            BoardDof {
                range,
                // Rounding to f32 may move a home at an end of its range beyond that end.
                home: if is_ball { home } else { home.max(range[0]).min(range[1]) },
                speed: single(link.speed),
                acceleration: single(link.acceleration),
                effort: single(link.effort),
            }
        })
        .collect()
}

/// Converts a unit quaternion x y z w to a rotation vector, rad.
fn rotation_vector(rotation: &[f64]) -> [f32; 3] {
    match rotation {
        [x, y, z, w] => {
            let q = glam::Quat::from_array([*x, *y, *z, *w].map(single));
            sinew_core::math::log(q).to_array()
        }
        _ => [0.0; 3],
    }
}

/// Converts a linked limit; `None` if one of its joints is fixed, which `Description::check` refuses.
fn limit_of(places: &Places<'_>, limit: &description::LinkedLimit) -> Option<LinkedLimit> {
    let dof = |joint: &str| places.get(joint).map(|place| place.start);
    let least = limit.least_rad.or(limit.least_m).unwrap_or(f64::NEG_INFINITY);
    let most = limit.most_rad.or(limit.most_m).unwrap_or(f64::INFINITY);
    Some(LinkedLimit {
        dof: dof(&limit.joint)?,
        other: dof(&limit.other)?,
        factor: single(limit.factor),
        other_factor: single(limit.other_factor),
        range: [least, most].map(single),
    })
}

fn drives(
    rig: &Description,
    actuation: &Actuation,
    places: &Places<'_>,
) -> std::vec::Vec<BoardDrive> {
    let index = |index: &usize| u16::try_from(*index).unwrap_or(u16::MAX);
    actuation
        .drives
        .iter()
        .map(|of| {
            let joints = of.joints.iter().filter_map(|joint| rig.joints.get(*joint));
            let dofs =
                joints.filter_map(|joint| places.get(joint.name.as_str())).flat_map(Range::clone);
            BoardDrive {
                drive: of.drive.clone(),
                // More items than this fit no drive, and the check of the count refuses them.
                dofs: dofs.take(DRIVE_CAPACITY).collect(),
                servos: of.servos.iter().map(index).take(DRIVE_CAPACITY).collect(),
            }
        })
        .collect()
}

/// Converts the servos. Buses are numbered in the order of their first use. A board feeds friction forward by
/// servo, therefore each servo includes its share of the joint's friction.
fn servos(rig: &Description, actuation: &Actuation) -> std::vec::Vec<BoardServo> {
    let mut buses: std::vec::Vec<&str> = std::vec::Vec::new();
    for servo in &rig.servos {
        if !buses.contains(&servo.bus.as_str()) {
            buses.push(&servo.bus);
        }
    }
    let number_of = |bus: &str| buses.iter().position(|other| *other == bus).unwrap_or_default();
    rig.servos
        .iter()
        .zip(&actuation.servos)
        .zip(actuation.joint_friction(rig))
        .map(|((described, servo), joint)| BoardServo {
            bus: u16::try_from(number_of(&described.bus)).unwrap_or(u16::MAX),
            address: described.address,
            servo: with_friction(servo, joint),
        })
        .collect()
}

/// Adds the joint's friction to that of a servo. If the sum is invalid for a servo, the joint's friction is not fed
/// forward.
fn with_friction(servo: &Servo, joint: JointFriction) -> Servo {
    let own = *servo.settings();
    let more = ServoSettings {
        friction_nm: own.friction_nm + joint.coulomb_nm,
        damping_nm_s: own.damping_nm_s + joint.viscous_nm_s,
        ..own
    };
    Servo::new(more).unwrap_or(*servo)
}
