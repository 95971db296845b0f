//! A motion of a rig in its own coordinates.

use std::hash::{DefaultHasher, Hasher as _};

use sinew_rig::Mechanism;
use sinew_rig::mechanism::{JointModel, Ties};
use thiserror::Error;

/// Tolerance of a quaternion's squared length against 1.
const UNIT_TOLERANCE: f64 = 1e-3;

/// A motion of a rig: rows of its joint coordinates, evenly spaced in time.
#[derive(Debug, Clone, PartialEq)]
pub struct RigMotion {
    /// Time from row to row, s.
    pub dt_s: f64,
    /// Coordinates in the order of [`Mechanism::home`]: rad, m, quaternions x y z w.
    pub rows: Vec<Vec<f64>>,
}

/// A change of an angle by more than half a turn from a row to the next.
#[derive(Debug, Clone, PartialEq)]
pub struct Jump {
    /// Name of the joint.
    pub joint: String,
    /// Index of the row after the jump.
    pub row: usize,
    /// Change of the angle, rad.
    pub change_rad: f64,
}

/// The reason why a motion is invalid for the rig.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MotionError {
    /// The time step is invalid, s.
    #[error("time from row to row: expected a number of seconds from 1e-5 to 1, found {0}")]
    TimeStep(f64),
    /// There are too few rows.
    #[error("expected at least 2 rows, found {0}")]
    Rows(usize),
    /// A row does not have one number for each coordinate.
    #[error("row {row}: expected {expected} coordinates of the rig, found {found}")]
    Count {
        /// Index of the row, from 0.
        row: usize,
        /// Number of the rig's coordinates.
        expected: usize,
        /// Number of values in the row.
        found: usize,
    },
    /// A number is NaN, infinite or too large.
    #[error("row {row}, joint `{joint}`: expected a number from -1e6 to 1e6, found {found}")]
    Number {
        /// Index of the row, from 0.
        row: usize,
        /// Name of the joint.
        joint: String,
        /// Number that was found.
        found: f64,
    },
    /// A quaternion does not have unit length.
    #[error(
        "row {row}, joint `{joint}`: expected a unit quaternion, found one of squared length {squared}"
    )]
    NotUnit {
        /// Index of the row, from 0.
        row: usize,
        /// Name of the joint.
        joint: String,
        /// Squared length that was found.
        squared: f64,
    },
}

impl RigMotion {
    /// Returns a hash of the bits of all numbers, to recognize a motion that is no longer stored.
    #[must_use]
    pub fn fingerprint(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        hasher.write_u64(self.dt_s.to_bits());
        self.rows.iter().flatten().for_each(|number| hasher.write_u64(number.to_bits()));
        hasher.finish()
    }

    /// Returns the time of the last row, s; the first row is at 0.
    pub fn duration_s(&self) -> f64 {
        self.rows.len().saturating_sub(1) as f64 * self.dt_s
    }

    /// Moves the followers in all rows to the positions that their leaders require. Returns, for each follower that
    /// changed, its body and its largest change, rad or m.
    pub fn follow(&mut self, ties: &Ties) -> Vec<(usize, f64)> {
        /// Largest change that counts as the rounding of a table with six digits.
        const ROUNDING: f64 = 1e-5;
        let mut changes: Vec<(usize, f64)> = ties.each().map(|tie| (tie.body, 0.0)).collect();
        for row in &mut self.rows {
            let before: Vec<f64> = ties.each().map(|tie| row[tie.places()[0]]).collect();
            ties.follow(row);
            for ((tie, before), (_, most)) in ties.each().zip(before).zip(&mut changes) {
                *most = f64::max(*most, (row[tie.places()[0]] - before).abs());
            }
        }
        changes.retain(|(_, most)| *most > ROUNDING);
        changes
    }

    /// Returns the changes of angles by more than half a turn, in order of time. They occur in files that wrap angles
    /// into one turn.
    pub fn jumps(&self, mechanism: &Mechanism) -> Vec<Jump> {
        let turns = |joint: &JointModel| {
            matches!(joint, JointModel::Revolute(_) | JointModel::Universal(_))
        };
        let ranges = mechanism.coordinate_ranges();
        let links = mechanism.bodies.iter().zip(&ranges).filter(|(link, _)| turns(&link.joint));
        let turning: Vec<(&str, usize)> = links
            .flat_map(|(link, range)| range.clone().map(|k| (link.joint_name.as_str(), k)))
            .collect();
        let mut jumps = Vec::new();
        for (before, rows) in self.rows.windows(2).enumerate() {
            for (joint, k) in &turning {
                let change_rad = rows[1][*k] - rows[0][*k];
                if change_rad.abs() > std::f64::consts::PI {
                    jumps.push(Jump { joint: (*joint).to_owned(), row: before + 1, change_rad });
                }
            }
        }
        jumps
    }

    /// Checks that the motion is valid for a rig.
    ///
    /// # Errors
    /// [`MotionError`] names row, joint and value.
    pub fn check(&self, mechanism: &Mechanism) -> Result<(), MotionError> {
        // The comparison also refuses NaN.
        if !(1e-5..=1.0).contains(&self.dt_s) {
            return Err(MotionError::TimeStep(self.dt_s));
        }
        if self.rows.len() < 2 {
            return Err(MotionError::Rows(self.rows.len()));
        }
        let expected = mechanism.coordinate_count();
        let ranges = mechanism.coordinate_ranges();
        for (row, q) in self.rows.iter().enumerate() {
            if q.len() != expected {
                return Err(MotionError::Count { row, expected, found: q.len() });
            }
            for (link, range) in mechanism.bodies.iter().zip(&ranges) {
                let of_joint = &q[range.clone()];
                let joint = || link.joint_name.clone();
                if let Some(found) = of_joint.iter().find(|x| !(-1e6..=1e6).contains(*x)) {
                    return Err(MotionError::Number { row, joint: joint(), found: *found });
                }
                if let Some(quaternion) = of_joint.first_chunk::<4>() {
                    let squared: f64 = quaternion.iter().map(|x| x * x).sum();
                    if (squared - 1.0).abs() > UNIT_TOLERANCE {
                        return Err(MotionError::NotUnit { row, joint: joint(), squared });
                    }
                }
            }
        }
        Ok(())
    }
}
