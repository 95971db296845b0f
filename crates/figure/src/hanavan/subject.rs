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

/// A measured subject whose inputs are consistent.
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

/// Maximum difference between the sum of the masses and the given total, as a fraction of the total.
const SUM_TOLERANCE: f64 = 0.1;

impl Subject {
    /// Returns the subject of `subjects/reference.toml`: 1.80 m, 75 kg.
    pub fn built_in() -> &'static Self {
        static SUBJECT: LazyLock<Subject> = LazyLock::new(|| {
            let text = include_str!("../../subjects/reference.toml");
            let inputs = toml::from_str(text).expect("the tests read it");
            Subject::new(inputs).expect("the tests make it")
        });
        &SUBJECT
    }

    /// Reads the subject file at `path`. `subjects/reference.toml` describes the format.
    ///
    /// # Errors
    /// [`SubjectError`] with the file's name, and the line or the keys and values.
    pub fn read(path: &Path) -> Result<Self, SubjectError> {
        let file = || path.to_path_buf();
        let text = read::text_of(path, "a measured subject in TOML", &[Kind::Toml])
            .map_err(|source| SubjectError::Io { file: file(), source })?;
        let inputs = toml::from_str(&text)
            .map_err(|source| SubjectError::Toml { file: file(), source: Box::new(source) })?;
        Self::new(inputs).map_err(|source| SubjectError::Inputs { file: file(), source })
    }

    /// Creates a subject from these inputs.
    ///
    /// # Errors
    /// [`InputError`] if a girth is too small for its breadth, a mass is not above 0, a density is impossible for
    /// a human body, or the sum of the masses differs from the total mass by more than 10 %.
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

    /// Returns the measurements.
    pub fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    /// Returns the segment that corresponds to a body of the figure.
    ///
    /// # Panics
    /// If `body` is not below [`BODY_COUNT`].
    pub fn segment(&self, body: usize) -> &Segment {
        &self.segments[BodyPart::new(body) as usize]
    }

    /// Returns the mass of all bodies in kg.
    pub fn mass_kg(&self) -> f64 {
        (0..BODY_COUNT).map(|body| self.segment(body).mass_kg).sum()
    }

    /// Returns the sum of the regressions' masses in kg. It equals the mass of all bodies if they are not
    /// normalised.
    pub fn regression_sum_kg(&self) -> f64 {
        self.regression_sum_kg
    }
}
