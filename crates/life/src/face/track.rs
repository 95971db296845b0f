//! Content of a face file: mouth cues, or weights of shapes.

use super::DURATION_MAX_S;
use super::error::FaceError;

/// A mouth shape that begins at a time and lasts until the next cue.
#[derive(Debug, Clone, PartialEq)]
pub struct Cue {
    /// Start, s.
    pub start_s: f64,
    /// Name of the mouth shape.
    pub mouth: String,
    /// Place in the file, such as `line 3`.
    pub place: String,
}

/// Weights of shapes over time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Weights {
    /// Names of the shapes.
    pub names: Vec<String>,
    /// Times of the rows, s, in increasing order.
    pub times_s: Vec<f64>,
    /// Rows with a weight, from 0 to 1, for each shape.
    pub rows: Vec<Vec<f64>>,
}

/// Content of a face file.
#[derive(Debug, Clone, PartialEq)]
pub enum FaceTrack {
    /// Mouth cues in the order of time, and the end of the last cue, s.
    Cues(Vec<Cue>, f64),
    /// Weights of shapes.
    Weights(Weights),
}

impl FaceTrack {
    /// Returns mouth cues. Fails if their times decrease or are too late.
    pub(super) fn of_cues(cues: Vec<Cue>, end_s: f64) -> Result<Self, FaceError> {
        for pair in cues.windows(2) {
            if pair[1].start_s < pair[0].start_s {
                return Err(FaceError::Value {
                    place: pair[1].place.clone(),
                    item: "the beginning".to_owned(),
                    expected: format!(
                        "a time from {} s on, that of the cue before",
                        pair[0].start_s
                    ),
                    found: pair[1].start_s.to_string(),
                });
            }
        }
        let Some(last) = cues.last() else {
            return Err(FaceError::Few { expected: "one mouth cue", found: 0 });
        };
        let end_s = end_s.max(last.start_s + 0.05);
        if end_s > DURATION_MAX_S {
            return Err(FaceError::TooLong(end_s));
        }
        Ok(Self::Cues(cues, end_s))
    }
}

impl Weights {
    /// Checks a table of weights: it needs at least two rows, increasing times, and finite weights.
    ///
    /// # Errors
    /// [`FaceError`] describes the first invalid value.
    pub fn checked(self) -> Result<Self, FaceError> {
        let found = self.times_s.len().min(self.rows.len());
        if found < 2 {
            return Err(FaceError::Few { expected: "two rows of weights", found });
        }
        let value = |row: usize, item: &str, expected: &str, found: f64| FaceError::Value {
            place: format!("row {}", row + 1),
            item: item.to_owned(),
            expected: expected.to_owned(),
            found: found.to_string(),
        };
        for (row, (time_s, weights)) in self.times_s.iter().zip(&self.rows).enumerate() {
            let is_later = row == 0 || *time_s > self.times_s[row - 1];
            if !time_s.is_finite() || !is_later {
                return Err(value(row, "the time", "a time after the row before, s", *time_s));
            }
            let is_weight = |weight: &f64| weight.is_finite() && weight.abs() <= 1e3;
            if let Some(index) = weights.iter().position(|weight| !is_weight(weight)) {
                let name = self.names.get(index).map_or("a weight", String::as_str);
                return Err(value(row, name, "a weight from 0 to 1", weights[index]));
            }
            if weights.len() != self.names.len() {
                let expected = format!("{} weights", self.names.len());
                return Err(value(row, "the row", &expected, weights.len() as f64));
            }
        }
        let duration_s = self.times_s[found - 1] - self.times_s[0];
        if duration_s > DURATION_MAX_S {
            return Err(FaceError::TooLong(duration_s));
        }
        Ok(self)
    }

    /// Returns the weights at a time, interpolated linearly between rows. Outside of the rows, returns the first or the
    /// last row.
    pub(super) fn at(&self, time_s: f64) -> Vec<f64> {
        let next = self.times_s.partition_point(|time| *time <= time_s);
        let (Some(from), Some(to)) = (next.checked_sub(1), self.rows.get(next)) else {
            return self.rows[next.saturating_sub(1).min(self.rows.len() - 1)].clone();
        };
        let share = (time_s - self.times_s[from]) / (self.times_s[next] - self.times_s[from]);
        self.rows[from].iter().zip(to).map(|(from, to)| from + share * (to - from)).collect()
    }
}
