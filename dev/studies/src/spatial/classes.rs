//! Sequences of two kinds of motion on one skeleton: what is told apart.

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
    /// Where they are from.
    pub data_set: DataSet,
    /// Both classes.
    pub classes: [Class; 2],
    /// The sequences, those of the first class first.
    pub sequences: Vec<Labelled>,
}

/// A sequence of known class.
#[derive(Debug, Clone, PartialEq)]
pub struct Labelled {
    /// The recording's file.
    pub name: String,
    /// Which of both classes it is of.
    pub class: usize,
    /// Whose it is: a person's number; where persons are not named, the style of the motion.
    pub group: String,
    /// Its poses, at least one.
    pub frames: Vec<Pose>,
}

/// A study of two classes cannot be done.
#[derive(Debug, thiserror::Error)]
pub enum ClassesError {
    /// There is too little of a class.
    #[error("{found} sequences of class {class}: expected at least {needed}")]
    Few {
        /// The class.
        class: &'static str,
        /// How many there are.
        found: usize,
        /// How many are drawn.
        needed: usize,
    },
    /// A sequence is empty.
    #[error("{sequence}: no poses are left of it: expected one at least")]
    NoPoses {
        /// Its name.
        sequence: String,
    },
    /// A pose cannot be compared.
    #[error("{sequence}, pose {pose}: {source}")]
    Pose {
        /// The sequence's name.
        sequence: String,
        /// Which of its poses, from 0.
        pose: usize,
        /// What is wrong with it.
        source: PoseSpaceError,
    },
}

impl TwoClasses {
    /// Of recordings: walks and runs; of the built-in clips, that have none, punches and kicks.
    ///
    /// Only from kinds of skeleton that there are sequences of either class of: how a file was converted must not
    /// tell what is done in it.
    ///
    /// # Errors
    /// [`ClassesError::NoPoses`] of a sequence that has none.
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

    /// The sequences of a class, by their indices.
    pub fn members(&self, class: usize) -> Vec<usize> {
        (0..self.sequences.len()).filter(|index| self.sequences[*index].class == class).collect()
    }

    /// The groups that sequences of a class are of, in order.
    pub fn groups(&self, class: usize) -> BTreeSet<&str> {
        let of_class = self.sequences.iter().filter(|sequence| sequence.class == class);
        of_class.map(|sequence| sequence.group.as_str()).collect()
    }

    /// What a group is.
    pub const fn group_word(&self) -> &'static str {
        match self.data_set {
            DataSet::Cmu => "subject",
            DataSet::Bandai => "style",
            DataSet::BuiltIn => "clip",
        }
    }

    /// That there are so many sequences of either class.
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

    /// The poses of all sequences, made ready to be compared.
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

/// Whose motion a sequence is. Bandai's trials are named by motion, style and number.
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
