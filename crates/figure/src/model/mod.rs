//! Mass properties of the figure's bodies, from a body model on the dimensions of a clip.

use glam::DVec3;
use sinew_rig::mechanism::{JointModel, Link, Mechanism};

use super::body::{BODIES, Root};
use super::de_leva;
use super::error::BodyModelError;
use super::hanavan::{self, Subject};
use super::placement::{Placement, Skeleton};
use crate::FigureMotion;
use crate::plant::{MassProperties, link};

/// The figure as a mechanism: positions of its joints, and mass properties of its bodies.
///
/// It is built from de Leva's segment table or from the Hanavan-Kwon solids of a measured subject, on the joints
/// of a clip's skeleton. `placement.rs` describes how segments are placed on the skeleton.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyModel {
    /// Position of joint `i` in the frame of body `i`'s parent, in metres; zero for the root.
    pub offset_m: Vec<DVec3>,
    /// Mass properties by body.
    pub bodies: Vec<MassProperties>,
}

impl BodyModel {
    /// Builds the mean man of de Leva's table, 73 kg, with the dimensions of a clip.
    ///
    /// # Errors
    /// [`BodyModelError`] if a dimension is not finite, a limb has no length, or the hips coincide.
    pub fn from_motion(motion: &FigureMotion) -> Result<Self, BodyModelError> {
        let placement = Placement::new(Skeleton::of(motion))?;
        Ok(Self { offset_m: motion.offset_m.clone(), bodies: de_leva::bodies(&placement)? })
    }

    /// Builds a measured subject on the joints of a clip. Masses and cross-sections are the subject's; [`hanavan`]
    /// describes the lengths.
    ///
    /// # Errors
    /// [`BodyModelError`] if a dimension is not finite, a limb has no length, or the hips coincide.
    pub fn hanavan_kwon(motion: &FigureMotion, subject: &Subject) -> Result<Self, BodyModelError> {
        let placement = Placement::new(Skeleton::of(motion))?;
        Ok(Self {
            offset_m: motion.offset_m.clone(),
            bodies: hanavan::bodies(&placement, subject)?,
        })
    }

    /// Builds the figure of a subject itself, without a clip. The figure stands with its arms down. In all frames
    /// x points left, y up and z forward, and the origin is at the body's joint.
    ///
    /// # Errors
    /// [`BodyModelError`] if a segment is too short to have a direction.
    pub fn from_subject(subject: &Subject) -> Result<Self, BodyModelError> {
        let own = hanavan::OwnSkeleton::new(subject);
        let placement = Placement::new(own.skeleton())?;
        let bodies = hanavan::bodies(&placement, subject)?;
        Ok(Self { offset_m: own.offset_m, bodies })
    }

    /// Returns the figure with all dimensions multiplied by `factor`, at the same density.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        self.scaled_by(&[factor; BODIES.len()])
    }

    /// Returns the figure with each body's dimensions multiplied by its own factor, at the same density. A joint's
    /// position is scaled with its parent body.
    #[must_use]
    pub fn scaled_by(&self, factors: &[f64]) -> Self {
        let offset_m = |(body, offset_m): (usize, &DVec3)| {
            *offset_m * factors[BODIES[body].parent.unwrap_or(body)]
        };
        let scaled = |(body, factor): (&MassProperties, &f64)| body.scaled(*factor);
        Self {
            offset_m: self.offset_m.iter().enumerate().map(offset_m).collect(),
            bodies: self.bodies.iter().zip(factors).map(scaled).collect(),
        }
    }

    /// Returns the mass of the whole figure in kg.
    pub fn mass_kg(&self) -> f64 {
        self.bodies.iter().map(|body| body.mass_kg).sum()
    }

    /// Returns the figure as a mechanism with the given root. All other joints are spherical, without friction or
    /// ranges.
    pub fn mechanism(&self, root: Root) -> Mechanism {
        let bodies = BODIES.iter().zip(&self.offset_m).zip(&self.bodies);
        let bodies = bodies.map(|((place, offset_m), mass)| {
            let joint = match (place.parent, root) {
                (Some(_), _) => JointModel::Spherical,
                (None, Root::Driven) => JointModel::Free,
                (None, Root::Fixed) => JointModel::Fixed,
            };
            Link {
                name: place.name.to_owned(),
                joint_name: place.name.to_owned(),
                ..link(place.parent, joint, *offset_m, mass)
            }
        });
        Mechanism { bodies: bodies.collect(), linked: Vec::new() }
    }
}

#[cfg(test)]
mod tests;
