//! A measured subject.

use std::path::Path;
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};
use sinew_mocap::{Kind, read};

use super::error::{InputError, SubjectError};
use super::inputs::Inputs;
use super::segments::{self, Segment};
use crate::body::BODY_COUNT;
use crate::placement::BodyPart;

/// A measured subject whose inputs go together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Inputs", into = "Inputs")]
pub struct Subject {
    inputs: Inputs,
    pub(super) segments: [Segment; BodyPart::ALL.len()],
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
        &self.segments[BodyPart::new(body) as usize]
    }

    /// Mass of all bodies in kg.
    pub fn mass_kg(&self) -> f64 {
        (0..BODY_COUNT).map(|body| self.segment(body).mass_kg).sum()
    }

    /// What the regressions' masses sum to in kg: the mass of all bodies if they are not normalised.
    pub fn regression_sum_kg(&self) -> f64 {
        self.regression_sum_kg
    }
}
