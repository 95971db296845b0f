//! Sequences of two kinds of motion on one skeleton, to be distinguished.

use std::collections::BTreeSet;

use sinew_pose_metrics::spatial::{MeasuredPose, RigMeasure};

use crate::recordings::{Class, DataSet, Pose, Recordings, Sequence};
use sinew_core::pose_space::PoseSpaceError;
use sinew_mocap::Skeleton;

/// Sequences of two classes.
#[derive(Debug, Clone, PartialEq)]
pub struct TwoClasses {
    /// The skeleton of all poses.
    pub skeleton: Skeleton,
    /// Data set of the sequences.
    pub data_set: DataSet,
    /// The two classes.
    pub classes: [Class; 2],
    /// The sequences, those of the first class first.
    pub sequences: Vec<Labelled>,
}

/// A sequence with a known class.
#[derive(Debug, Clone, PartialEq)]
pub struct Labelled {
    /// Path of the recording.
    pub name: String,
    /// Index of the sequence's class.
    pub class: usize,
    /// Group of the sequence: the number of a person, or the style of the motion if people are not named.
    pub group: String,
    /// Poses of the sequence, at least one.
    pub frames: Vec<Pose>,
}

/// Error of a study of two classes.
#[derive(Debug, thiserror::Error)]
pub enum ClassesError {
    /// A class has too few sequences.
    #[error("{found} sequences of class {class}: expected at least {needed}")]
    Few {
        /// Name of the class.
        class: &'static str,
        /// Number of sequences that the class has.
        found: usize,
        /// Number that is drawn.
        needed: usize,
    },
    /// A sequence is empty.
    #[error("{sequence}: no poses are left of it: expected one at least")]
    NoPoses {
        /// Name of the sequence.
        sequence: String,
    },
    /// A pose cannot be compared.
    #[error("{sequence}, pose {pose}: {source}")]
    Pose {
        /// Name of the sequence.
        sequence: String,
        /// Index of the pose, from 0.
        pose: usize,
        /// Reason for the failure.
        source: PoseSpaceError,
    },
}

impl TwoClasses {
    /// Selects two classes of recordings: walks and runs; in the built-in clips, which have neither, punches and
    /// kicks.
    ///
    /// Only kinds of skeleton with sequences of both classes are used: otherwise the conversion of a file would
    /// reveal its class.
    ///
    /// # Errors
    /// [`ClassesError::NoPoses`] if a sequence has no poses.
    pub fn of(recordings: &Recordings) -> Result<Self, ClassesError> {
        let Recordings { skeleton, sequences } = recordings;
        let data_set = sequences.first().map_or(DataSet::BuiltIn, |first| first.data_set);
        let classes = match data_set {
            DataSet::BuiltIn => [Class::Punch, Class::Kick],
            DataSet::Cmu | DataSet::Bandai => [Class::Walk, Class::Run],
        };
        let of_class = |class: Class| sequences.iter().filter(move |s| s.class == class);
        let [kinds, others] =
            classes.map(|class| of_class(class).map(|s| s.kind.as_str()).collect::<BTreeSet<_>>());
        let mut labelled = Vec::new();
        for (index, class) in classes.into_iter().enumerate() {
            for sequence in of_class(class) {
                if sequence.frames.is_empty() {
                    return Err(ClassesError::NoPoses { sequence: sequence.file.clone() });
                }
                let kind = sequence.kind.as_str();
                if kinds.contains(kind) && others.contains(kind) {
                    labelled.push(Labelled {
                        name: sequence.file.clone(),
                        class: index,
                        group: group(sequence).to_owned(),
                        frames: sequence.frames.clone(),
                    });
                }
            }
        }
        Ok(Self { skeleton: skeleton.clone(), data_set, classes, sequences: labelled })
    }

    /// Returns the indices of a class's sequences.
    pub fn members(&self, class: usize) -> Vec<usize> {
        (0..self.sequences.len()).filter(|index| self.sequences[*index].class == class).collect()
    }

    /// Returns the groups of a class's sequences, in order.
    pub fn groups(&self, class: usize) -> BTreeSet<&str> {
        let of_class = self.sequences.iter().filter(|sequence| sequence.class == class);
        of_class.map(|sequence| sequence.group.as_str()).collect()
    }

    /// Returns the word for a group.
    pub const fn group_word(&self) -> &'static str {
        match self.data_set {
            DataSet::Cmu => "subject",
            DataSet::Bandai => "style",
            DataSet::BuiltIn => "clip",
        }
    }

    /// Checks that each class has at least `needed` sequences.
    ///
    /// # Errors
    /// [`ClassesError::Few`] if not.
    pub(super) fn expect(&self, needed: usize) -> Result<(), ClassesError> {
        for class in [0, 1] {
            let found = self.members(class).len();
            if found < needed {
                return Err(ClassesError::Few { class: self.classes[class].name(), found, needed });
            }
        }
        Ok(())
    }

    /// Prepares the poses of all sequences for comparison.
    pub(super) fn measured(
        &self,
        measuring: &RigMeasure<'_>,
    ) -> Result<Vec<Vec<MeasuredPose>>, ClassesError> {
        let of_sequence = |sequence: &Labelled| {
            let ready = |(pose, frame): (usize, &Pose)| {
                let sequence = || sequence.name.clone();
                measuring.pose(frame).map_err(|source| ClassesError::Pose {
                    sequence: sequence(),
                    pose,
                    source,
                })
            };
            sequence.frames.iter().enumerate().map(ready).collect()
        };
        self.sequences.iter().map(of_sequence).collect()
    }
}

/// Returns the group of a sequence. Bandai's trials are named by motion, style and number.
fn group(sequence: &Sequence) -> &str {
    match sequence.data_set {
        DataSet::Bandai => sequence.trial.split('_').nth(1).unwrap_or(&sequence.trial),
        DataSet::Cmu | DataSet::BuiltIn => &sequence.subject,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_only_one_class_was_converted_by_is_left_out() {
        let mut recordings = Recordings::built_in();
        let all = TwoClasses::of(&recordings).unwrap();
        assert_eq!(all.sequences.len(), recordings.sequences.len());
        assert!(all.sequences.is_sorted_by_key(|sequence| sequence.class));
        let kicks = recordings.sequences.iter_mut().filter(|s| s.class == Class::Kick);
        kicks.take(1).for_each(|kick| kick.kind = "another".to_owned());
        let some = TwoClasses::of(&recordings).unwrap();
        assert_eq!(some.sequences.len(), recordings.sequences.len() - 1);
        assert!(some.expect(some.members(1).len()).is_ok());
        let error = some.expect(some.members(1).len() + 1).unwrap_err();
        assert_eq!(error.to_string(), "3 sequences of class kick: expected at least 4");
    }

    #[test]
    fn sequences_without_poses_are_refused_by_name() {
        let mut recordings = Recordings::built_in();
        recordings.sequences[2].frames.clear();
        let error = TwoClasses::of(&recordings).unwrap_err().to_string();
        assert!(error.starts_with(&recordings.sequences[2].file), "{error}");
    }
}
