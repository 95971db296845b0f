//! Determines the size and the up axis of a file's content: given by the user, read from the file, or inferred
//! from the body and then reported. All commands that read a clip or a character use this module.

mod unit;
mod up;

use std::fmt::{self, Display, Formatter};

use glam::DVec3;
use sinew_mocap::{Recording, Up, axis_name};
use sinew_retarget::skeleton::{BODY_HEIGHT_M, SkeletonMatch};

use unit::short;

pub use unit::MappingSource;
pub use up::UpGuess;

/// The user's options about a file's unit and up axis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct UnitOverrides {
    /// Length of the file's unit, in metres.
    pub metres_per_unit: Option<f64>,
    /// Axis that points up.
    pub up: Option<Up>,
}

/// Unit, up axis and height of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Length of the file's unit, in metres; `None` if it cannot be determined.
    pub metres_per_unit: Option<f64>,
    /// Reason for this unit, or for the lack of one.
    pub unit_reason: String,
    /// Axis that points up.
    pub up: UpGuess,
    /// Height of the standing body, computed from the lengths of its bones, in the file's unit. If the skeleton is
    /// not a human body: the extent along up.
    pub height_units: f64,
    /// Whether the skeleton is that of a human body.
    pub is_body: bool,
}

/// Plausible sizes, from joint to joint, of a skeleton that is not a human body, m: from a hand to a horse with
/// its neck.
const OTHER_SIZE_M: std::ops::RangeInclusive<f64> = 0.05..=5.0;

impl Measured {
    /// Measures a recording. `matched` contains the landmarks of its skeleton; `by` is the mapping with which the
    /// recording is read.
    pub fn new(
        recording: &Recording,
        matched: &SkeletonMatch,
        by: Option<MappingSource<'_>>,
        units: UnitOverrides,
    ) -> Self {
        let of_mapping = by.and_then(|by| Some((by.mapping.up?, "as the mapping says")));
        Self::with_word(recording, matched, by, units, of_mapping)
    }

    /// Measures the rest pose of a file whose format prescribes metres with y up.
    pub fn of_format(rest: &Recording, matched: &SkeletonMatch) -> Self {
        Self::with_word(
            rest,
            matched,
            None,
            UnitOverrides::default(),
            Some((Up::Y, "as its format says")),
        )
    }

    fn with_word(
        recording: &Recording,
        matched: &SkeletonMatch,
        by: Option<MappingSource<'_>>,
        units: UnitOverrides,
        said: Option<(Up, &str)>,
    ) -> Self {
        let up = UpGuess::new(recording, matched, units.up, said);
        let body = matched.unit.as_ref().map(|unit| unit.height).filter(|height| *height > 0.0);
        let (metres_per_unit, unit_reason) =
            match unit::find(recording, matched, by, units.metres_per_unit) {
                Ok((metres, reason)) => (Some(metres), reason),
                Err(reason) => (None, reason),
            };
        let height_units = body.unwrap_or_else(|| up::extents(recording, up.axis)[0]);
        Self { metres_per_unit, unit_reason, up, height_units, is_body: body.is_some() }
    }

    /// Uses this unit, in metres, if the unit could not be determined.
    #[must_use]
    pub fn or_unit(mut self, metres_per_unit: Option<f64>) -> Self {
        if self.metres_per_unit.is_none() && metres_per_unit.is_some() {
            self.unit_reason = format!("assumed: {}; see --metres-per-unit", self.unit_reason);
            self.metres_per_unit = metres_per_unit;
        }
        self
    }

    /// Returns the height in metres, if the unit is known.
    pub fn height_m(&self) -> Option<f64> {
        self.metres_per_unit.map(|metres| metres * self.height_units)
    }

    /// Returns the length of the unit in metres.
    ///
    /// # Errors
    /// The reason why the unit is unknown and the remedy, as a sentence that continues after the file's name.
    pub fn unit(&self) -> Result<f64, String> {
        self.metres_per_unit.ok_or_else(|| {
            format!(
                "the unit of length is not known: {}; give it with --metres-per-unit",
                self.unit_reason
            )
        })
    }

    /// Returns the recording in metres, y up.
    ///
    /// # Errors
    /// Those of [`unit`](Self::unit).
    pub fn apply(&self, mut recording: Recording) -> Result<Recording, String> {
        // The measured unit overrides the file's own.
        recording.metres_per_unit = Some(self.unit()?);
        Ok(recording.in_metres(1.0).upright(self.up.axis, self.up.rest))
    }

    /// Returns warnings about implausible measurements.
    pub fn warnings(&self) -> Vec<String> {
        let range = if self.is_body { BODY_HEIGHT_M } else { OTHER_SIZE_M };
        let size = self.height_m().filter(|height_m| !range.contains(height_m)).map(|height_m| {
            format!(
                "warning: {} is {height_m:.3} m tall, and {} to {} m is believable: is the unit another? See \
                 --metres-per-unit",
                if self.is_body { "the body" } else { "it" },
                range.start(),
                range.end(),
            )
        });
        size.into_iter().chain(self.up.doubt.clone()).collect()
    }
}

/// Writes height, unit and up axis on one line.
impl Display for Measured {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let what = if self.is_body { "tall" } else { "high" };
        match (self.height_m(), self.metres_per_unit) {
            (Some(height_m), Some(unit)) => {
                write!(
                    f,
                    "{height_m:.2} m {what}; a unit is {} m ({})",
                    short(unit),
                    self.unit_reason
                )?;
            }
            _ => write!(f, "{:.2} units {what} ({})", self.height_units, self.unit_reason)?,
        }
        write!(f, "; {} is up ({})", axis_name(self.up.axis), self.up.reason)
    }
}

/// Returns the extents of a recording's joints and ends, in the file's unit: the extent along `up`, and the larger of
/// the two extents across it. They are measured in the first complete frame or, if there is none, in the rest pose.
pub fn extents(recording: &Recording, up: DVec3) -> [f64; 2] {
    up::extents(recording, up)
}

#[cfg(test)]
mod tests;
