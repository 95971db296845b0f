//! Poses for training and for testing.

use std::collections::BTreeSet;
use std::path::Path;

use glam::{DQuat, DVec3};
use sinew_mocap::{JointSample, Skeleton};

use crate::recordings::{DataError, Pose, Recordings, Sequence};

/// CMU's subjects that are used only for testing. Their walks, runs, jumps, punches, swordplay, dances and cartwheels
/// have counterparts among those of the other subjects, who also climb and play basketball.
const TEST_SUBJECTS: [&str; 3] = ["02", "16", "49"];

/// Poses of one skeleton, split by subject. The heading is removed from the root's rotation.
#[derive(Debug, Clone, PartialEq)]
pub struct Poses {
    /// The common skeleton of all poses, in metres.
    pub skeleton: Skeleton,
    /// Poses for training.
    pub train: Vec<Pose>,
    /// Poses for testing.
    pub test: Vec<Pose>,
    /// Subjects of the training poses.
    pub train_subjects: BTreeSet<String>,
    /// Subjects of the test poses; none is used for training.
    pub test_subjects: BTreeSet<String>,
    /// Number of recordings with these poses.
    pub recordings: usize,
}

impl Poses {
    /// Reads all trials of CMU's 31-joint skeleton in a folder with its `index.csv`, each once, at 12 Hz.
    ///
    /// # Errors
    /// [`DataError`] if a file is missing or does not match the index.
    pub fn cmu(folder: &Path) -> Result<Self, DataError> {
        let Recordings { skeleton, sequences } = Recordings::cmu(folder)?;
        let mut poses = Self::none(skeleton);
        for Sequence { subject, frames, .. } in sequences {
            let test = TEST_SUBJECTS.contains(&subject.as_str());
            poses.add(subject, test, frames);
        }
        for (of, subjects) in [("train", &poses.train_subjects), ("test", &poses.test_subjects)] {
            if subjects.is_empty() {
                let what = format!("no subject to {of} on");
                return Err(DataError::Missing { file: folder.join("index.csv"), what });
            }
        }
        Ok(poses)
    }

    /// Returns the built-in clips at 12 Hz, used like subjects: every sixth is for testing. Frames with gaps are left
    /// out.
    pub fn built_in() -> Self {
        let Recordings { skeleton, sequences } = Recordings::built_in();
        let mut poses = Self::none(skeleton);
        for (number, Sequence { subject, frames, .. }) in sequences.into_iter().enumerate() {
            poses.add(subject, number % 6 == 5, frames);
        }
        poses
    }

    fn none(skeleton: Skeleton) -> Self {
        Self {
            skeleton,
            train: Vec::new(),
            test: Vec::new(),
            train_subjects: BTreeSet::new(),
            test_subjects: BTreeSet::new(),
            recordings: 0,
        }
    }

    fn add(&mut self, subject: String, test: bool, mut frames: Vec<Pose>) {
        for frame in &mut frames {
            frame[0] = without_heading(frame[0]);
        }
        let (poses, subjects) = if test {
            (&mut self.test, &mut self.test_subjects)
        } else {
            (&mut self.train, &mut self.train_subjects)
        };
        poses.append(&mut frames);
        subjects.insert(subject);
        self.recordings += 1;
    }
}

/// Removes the turn about the vertical y from a rotation: the twist of its swing-twist decomposition, on the left. An
/// upside-down rotation has no defined twist and is unchanged.
fn without_heading(rotation: DQuat) -> DQuat {
    let twist = DQuat::from_xyzw(0.0, rotation.y, 0.0, rotation.w);
    if twist.length() < 1e-9 { rotation } else { twist.normalize().inverse() * rotation }
}

/// Returns positions of the joints with the root at the origin, in metres, and their global rotations.
pub(super) fn forward_kinematics(skeleton: &Skeleton, pose: &[DQuat]) -> Vec<JointSample> {
    let local = skeleton.joints.iter().zip(pose).map(|(joint, rotation)| JointSample {
        rotation: *rotation,
        position_m: if joint.parent.is_some() { joint.offset_m } else { DVec3::ZERO },
    });
    sinew_mocap::forward_kinematics(skeleton, &local.collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    #[test]
    fn a_heading_is_taken_out_whatever_it_was() {
        let lean = DQuat::from_rotation_x(0.4) * DQuat::from_rotation_z(-0.2);
        let bare = without_heading(lean);
        for heading in [-3.0, -1.0, 0.5, 2.0] {
            let turned = without_heading(DQuat::from_rotation_y(heading) * lean);
            assert!(turned.dot(bare).abs() > 1.0 - 1e-12);
        }
        // The direction of down is unchanged.
        let down = |rotation: DQuat| rotation.inverse() * DVec3::NEG_Y;
        assert!((down(lean) - down(bare)).length() < 1e-12);
    }

    #[test]
    fn clips_are_trained_or_tested_on_never_both() {
        let poses = Poses::built_in();
        assert!(poses.train_subjects.is_disjoint(&poses.test_subjects));
        assert_eq!(poses.test_subjects.len(), 2);
        assert!(poses.train.len() > 500 && poses.test.len() > 100, "{}", poses.train.len());
    }

    #[test]
    #[ignore = "needs SINEW_DATA"]
    fn cmu_is_split_by_subject() {
        let data = PathBuf::from(std::env::var("SINEW_DATA").expect("the tests' runner sets it"));
        let poses = Poses::cmu(&data.join("cmu")).unwrap();
        assert!(poses.train_subjects.is_disjoint(&poses.test_subjects));
        assert_eq!(poses.test_subjects.len(), TEST_SUBJECTS.len());
        assert_eq!(poses.skeleton.joints.len(), 31);
        // The numbers in the study's document: the published results are those of these poses.
        assert_eq!((poses.recordings, poses.train.len(), poses.test.len()), (178, 15_128, 3_995));
    }
}
