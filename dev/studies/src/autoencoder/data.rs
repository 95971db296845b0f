//! Poses to train on and to be judged by.

use std::collections::BTreeSet;
use std::path::Path;

use glam::{DQuat, DVec3};
use sinew_mocap::{JointSample, Skeleton};

use crate::recordings::{DataError, Pose, Recordings, Sequence};

/// CMU's subjects that are only tested on: their walks, runs, jumps, punches, swordplay, dances and cartwheels have
/// counterparts among the others', which climb and play basketball beside.
const TEST_SUBJECTS: [&str; 3] = ["02", "16", "49"];

/// Poses of one skeleton, the root's rotation without its heading, split by subject.
#[derive(Debug, Clone, PartialEq)]
pub struct Poses {
    /// The one skeleton of all poses, in metres.
    pub skeleton: Skeleton,
    /// Poses to train on.
    pub train: Vec<Pose>,
    /// Poses to be judged by.
    pub test: Vec<Pose>,
    /// Whose poses are trained on.
    pub train_subjects: BTreeSet<String>,
    /// Whose poses are tested; none is trained on.
    pub test_subjects: BTreeSet<String>,
    /// Recordings that the poses are from.
    pub recordings: usize,
}

impl Poses {
    /// All trials of CMU's 31-joint skeleton in a folder with its `index.csv`, each once, at 12 Hz.
    ///
    /// # Errors
    /// [`DataError`] if a file is missing or is not what the index says.
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

    /// The built-in clips at 12 Hz, in place of subjects: every sixth is tested on. Frames with gaps are left out.
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

/// A rotation without its turn about the vertical y: the twist of its swing-twist decomposition taken out on the
/// left. Upside down it has none, and keeps what it has.
fn without_heading(rotation: DQuat) -> DQuat {
    let twist = DQuat::from_xyzw(0.0, rotation.y, 0.0, rotation.w);
    if twist.length() < 1e-9 { rotation } else { twist.normalize().inverse() * rotation }
}

/// Positions of the joints with the root at the origin, in metres, and their global rotations.
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
        // Which way is down stays as it was.
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
        // As the study's document has them: what is published is of these.
        assert_eq!((poses.recordings, poses.train.len(), poses.test.len()), (178, 15_128, 3_995));
    }
}
