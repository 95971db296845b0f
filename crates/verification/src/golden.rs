//! The format of golden files: their envelope and the numbers in them.

use glam::{DQuat, DVec3, Quat, Vec3};
use serde::{Deserialize, de::DeserializeOwned};
use serde_json::Value;

use super::error::{CaseError, FileError};

/// A golden file: its schema, and its cases, not yet parsed.
#[derive(Deserialize)]
pub(super) struct Golden {
    /// Kind and version, such as `rnea/1`.
    pub(super) schema: String,
    #[serde(default)]
    cases: Vec<Value>,
}

impl Golden {
    /// Calls `check` with the name of each case and the case.
    pub(super) fn for_each_case<T: DeserializeOwned>(
        self,
        mut check: impl FnMut(&str, T) -> Result<(), CaseError>,
    ) -> Result<(), FileError> {
        if self.cases.is_empty() {
            return Err(FileError::NoCase);
        }
        for (index, value) in self.cases.into_iter().enumerate() {
            let name = value.get("name").and_then(Value::as_str).unwrap_or("without a name");
            let name = format!("{index} ({name})");
            serde_path_to_error::deserialize(value)
                .map_err(|error| CaseError::new(error.path().to_string(), error.inner()))
                .and_then(|case| check(&name, case))
                .map_err(|CaseError { field, problem }| FileError::Case {
                    case: name,
                    field,
                    problem,
                })?;
        }
        Ok(())
    }
}

/// A number within the range of the core's f32.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(try_from = "f64")]
pub(super) struct Scalar(pub(super) f64);

impl Scalar {
    /// Rounds the number to the core's precision.
    #[expect(clippy::cast_possible_truncation, reason = "the core's inputs are f32")]
    pub(super) fn rounded(self) -> f32 {
        self.0 as f32
    }
}

impl TryFrom<f64> for Scalar {
    type Error = String;

    fn try_from(number: f64) -> Result<Self, String> {
        if number.abs() <= f64::from(f32::MAX) {
            Ok(Self(number))
        } else {
            Err(format!("{number} does not fit in f32; the largest is {:e}", f32::MAX))
        }
    }
}

/// A vector. Its frame depends on the use.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(from = "[Scalar; 3]")]
pub(super) struct Vector(pub(super) DVec3);

impl Vector {
    /// Rounds the vector to the core's precision.
    pub(super) fn rounded(self) -> Vec3 {
        self.0.as_vec3()
    }
}

impl From<[Scalar; 3]> for Vector {
    fn from(components: [Scalar; 3]) -> Self {
        Self(DVec3::from_array(components.map(|component| component.0)))
    }
}

/// A rotation as a unit quaternion `[x, y, z, w]`.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(try_from = "[Scalar; 4]")]
pub(super) struct Rotation(pub(super) DQuat);

impl Rotation {
    /// Rounds the rotation to the core's precision and normalizes it, as the core's entry points do.
    pub(super) fn rounded(self) -> Quat {
        sinew_core::math::unit(self.0.as_quat())
    }
}

impl TryFrom<[Scalar; 4]> for Rotation {
    type Error = String;

    fn try_from(components: [Scalar; 4]) -> Result<Self, String> {
        let quat = DQuat::from_array(components.map(|component| component.0));
        // Unit quaternions are written to the file with all 17 digits.
        if (quat.length() - 1.0).abs() < 1e-9 {
            Ok(Self(quat))
        } else {
            Err(format!("a quaternion of length {}; it must be a unit quaternion", quat.length()))
        }
    }
}

/// Refuses a list that does not have `expected` entries, one for each body (or frame, ...).
pub(super) fn expect_count(field: &str, found: usize, expected: usize) -> Result<(), CaseError> {
    if found == expected {
        Ok(())
    } else {
        Err(CaseError::new(field, format!("{found} entries, expected {expected}")))
    }
}

/// Returns the largest absolute component of some vectors.
pub(super) fn largest<'a>(vectors: impl IntoIterator<Item = &'a Vector>) -> f64 {
    vectors.into_iter().fold(0.0, |largest, v| f64::max(largest, v.0.abs().max_element()))
}

/// Returns the angle between two orientations, rad. It is accurate for small angles too.
pub(super) fn angle_between(a: DQuat, b: DQuat) -> f64 {
    let between = a.normalize() * b.normalize().inverse();
    2.0 * DVec3::new(between.x, between.y, between.z).length().atan2(between.w.abs())
}
