//! The body model of Hanavan as modified by Kwon: segments of a measured subject as solids of uniform
//! density.
//!
//! E. P. Hanavan, "A Mathematical Model of the Human Body", AMRL-TR-64-102 (1964); Y.-H. Kwon,
//! dissertation (1993). Kwon's text was not available: geometry and masses are those of implementations of
//! the model, and what they leave open is decided here and said where it is.
//!
//! - Limbs are truncated cones, thighs and feet elliptical solids, head and hands ellipsoids; the trunk is
//!   an elliptical column above, an elliptical solid and a column below. The upper one is cut in thorax and
//!   two clavicle bodies (`cut.rs`). The head starts at its joint: the model has no neck.
//! - Masses come from regressions (`masses.rs`). Their sum differs from the total mass by some percent; the
//!   subject's `normalise` scales that away.
//! - On a clip's skeleton mass and cross-sections are the subject's. Limbs are as long as their bones, and
//!   all other segments have the subject's length times one factor, which is the ratio of the clip's legs
//!   to the subject's. The shoulder parts stay where they are in the upper trunk's column, so that the
//!   three together are the column in the zero pose, wherever the skeleton has its clavicle joints.

mod error;
mod inputs;
mod masses;
mod model;
mod segments;
mod shape;

use std::path::Path;
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};
use sinew_mocap::{Kind, read};

use super::BODY_COUNT;
use super::model::{BodyModel, BodyModelError};
use super::placement::{Part, Placement};

pub use error::{InputError, SubjectError, Values};
pub use inputs::{Inputs, Kilograms, Metres};
pub(super) use model::bodies;
pub use segments::Segment;
pub use shape::{Piece, Shape};

/// A measured subject whose inputs go together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Inputs", into = "Inputs")]
pub struct Subject {
    inputs: Inputs,
    segments: [Segment; Part::ALL.len()],
    regression_sum_kg: f64,
}

impl TryFrom<Inputs> for Subject {
    type Error = InputError;

    fn try_from(inputs: Inputs) -> Result<Self, InputError> {
        Self::new(inputs)
    }
}

impl From<Subject> for Inputs {
    fn from(subject: Subject) -> Self {
        subject.inputs
    }
}

/// How far the masses may sum from the given total, as a fraction of it.
const SUM_TOLERANCE: f64 = 0.1;

impl Subject {
    /// The subject of `subjects/reference.toml`: 1.80 m, 75 kg.
    pub fn built_in() -> &'static Self {
        static SUBJECT: LazyLock<Subject> = LazyLock::new(|| {
            let text = include_str!("../../subjects/reference.toml");
            let inputs = toml::from_str(text).expect("the tests read it");
            Subject::new(inputs).expect("the tests make it")
        });
        &SUBJECT
    }

    /// Reads the subject file at `path`; what it holds is said in `subjects/reference.toml`.
    ///
    /// # Errors
    /// [`SubjectError`] with the file's name, and line or keys and values.
    pub fn read(path: &Path) -> Result<Self, SubjectError> {
        let file = || path.to_path_buf();
        let text = read::text_of(path, "a measured subject in TOML", &[Kind::Toml])
            .map_err(|source| SubjectError::Io { file: file(), source })?;
        let inputs = toml::from_str(&text)
            .map_err(|source| SubjectError::Toml { file: file(), source: Box::new(source) })?;
        Self::new(inputs).map_err(|source| SubjectError::Inputs { file: file(), source })
    }

    /// A subject of these inputs.
    ///
    /// # Errors
    /// [`InputError`] if a girth does not go round its breadth, a mass is not above 0, a density is none of a
    /// human body, or the masses sum to something else than the total mass, more than 10 % off.
    pub fn new(inputs: Inputs) -> Result<Self, InputError> {
        let segments = segments::segments(&inputs)?;
        let mut subject = Self { inputs, segments, regression_sum_kg: 0.0 };
        let (sum_kg, mass_kg) = (subject.mass_kg(), subject.inputs.mass_kg.get());
        if (sum_kg - mass_kg).abs() > SUM_TOLERANCE * mass_kg {
            return Err(InputError::Sum { sum_kg, mass_kg });
        }
        subject.regression_sum_kg = sum_kg;
        if subject.inputs.normalise {
            for segment in &mut subject.segments {
                segment.mass_kg *= mass_kg / sum_kg;
            }
        }
        Ok(subject)
    }

    /// What was measured.
    pub fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    /// The segment that a body of the figure is.
    ///
    /// # Panics
    /// If `body` is not below [`BODY_COUNT`].
    pub fn segment(&self, body: usize) -> &Segment {
        &self.segments[Part::of(body) as usize]
    }

    /// Mass of all bodies in kg.
    pub fn mass_kg(&self) -> f64 {
        (0..BODY_COUNT).map(|body| self.segment(body).mass_kg).sum()
    }

    /// What the regressions' masses sum to in kg: the mass of all bodies if they are not normalised.
    pub fn regression_sum_kg(&self) -> f64 {
        self.regression_sum_kg
    }

    /// The subject's own figure: standing with its arms down, x left, y up, z forward in all frames, each
    /// with its origin in the body's joint.
    ///
    /// # Errors
    /// [`BodyModelError`] if a segment is too short to have a direction.
    pub fn figure(&self) -> Result<BodyModel, BodyModelError> {
        let own = model::OwnSkeleton::of(self);
        let placement = Placement::new(own.skeleton())?;
        let bodies = bodies(&placement, self)?;
        Ok(BodyModel { offset_m: own.offset_m, bodies })
    }
}

#[cfg(test)]
mod tests;
