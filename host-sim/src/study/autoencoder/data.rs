//! Poses to train on and to be judged by.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};
use serde::Deserialize;

use crate::mocap::{JointSample, Skeleton, builtin, bvh, clip};

/// Rate that recordings are thinned out to: CMU's `broad-12hz` has it, and neighbours at 120 Hz tell little new.
const RATE_HZ: f64 = 12.0;
/// What recordings begin with and is left out: fingers that settle, feet that jump.
const SETTLING_S: f64 = 0.1;
/// CMU's subjects that are only tested on: their walks, runs, jumps, punches, swordplay, dances and cartwheels have
/// counterparts among the others', which climb and play basketball beside.
const TEST_SUBJECTS: [&str; 3] = ["02", "16", "49"];
/// The file whose skeleton all poses are put on: the ASF form of subject 135 keeps the bones of thorax and palm, that
/// the other conversion lost.
const REFERENCE: &str = "broad-12hz/135_03.bvh";
/// The skeletons of 31 joints, by their names in the index.
const SKELETONS: [&str; 2] = ["cgspeed-mb", "asfamc"];

/// What some files call the reference's joints, in its order: their names in the ASF files.
const ASF_NAMES: [&str; 31] = [
    "hip",
    "lhipjoint",
    "lfemur",
    "ltibia",
    "lfoot",
    "ltoes",
    "rhipjoint",
    "rfemur",
    "rtibia",
    "rfoot",
    "rtoes",
    "lowerback",
    "upperback",
    "thorax",
    "lowerneck",
    "upperneck",
    "head",
    "lclavicle",
    "lhumerus",
    "lradius",
    "lwrist",
    "lhand",
    "lfingers",
    "lthumb",
    "rclavicle",
    "rhumerus",
    "rradius",
    "rwrist",
    "rhand",
    "rfingers",
    "rthumb",
];

/// Local rotation of every joint, in the order of the skeleton; the root's without its heading.
pub type Pose = Vec<DQuat>;

/// Poses of one skeleton, split by subject.
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

/// The data cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum DataError {
    /// The index cannot be read.
    #[error("{}: {source}", file.display())]
    Index {
        /// The file.
        file: PathBuf,
        /// What is wrong with it.
        source: csv::Error,
    },
    /// A number of the index cannot be.
    #[error("{}: {recording}: {key} {value}: expected a number above 0", file.display())]
    Number {
        /// The file.
        file: PathBuf,
        /// The recording's row.
        recording: String,
        /// The column.
        key: &'static str,
        /// What it holds.
        value: f64,
    },
    /// A recording cannot be read.
    #[error(transparent)]
    Bvh(#[from] bvh::Error),
    /// A recording has another skeleton than the index says.
    #[error("{}: joint {joint} is missing: expected the joints of {REFERENCE}", file.display())]
    Joint {
        /// The file.
        file: PathBuf,
        /// The joint.
        joint: String,
    },
    /// The index does not hold what the study needs.
    #[error("{}: {what}", file.display())]
    Missing {
        /// The file.
        file: PathBuf,
        /// What is missing.
        what: String,
    },
}

/// A row of the index, of what is needed of it.
#[derive(Debug, Clone, Deserialize)]
struct Row {
    file: String,
    subject: String,
    trial: String,
    fps: f64,
    skeleton: String,
    tpose_first_frame: u8,
    metres_per_unit: f64,
}

impl Poses {
    /// All trials of CMU's 31-joint skeleton in a folder with its `index.csv`, each once, at 12 Hz.
    ///
    /// # Errors
    /// [`DataError`] if a file is missing or is not what the index says.
    pub fn cmu(folder: &Path) -> Result<Self, DataError> {
        let index = folder.join("index.csv");
        let rows = rows(&index)?;
        let reference = rows.iter().find(|row| row.file == REFERENCE).ok_or_else(|| {
            DataError::Missing { file: index.clone(), what: format!("{REFERENCE} is not listed") }
        })?;
        let mut skeleton = bvh::read(&folder.join(REFERENCE))?.skeleton;
        for joint in &mut skeleton.joints {
            joint.offset_m *= reference.metres_per_unit;
            for end in &mut joint.end_sites_m {
                *end *= reference.metres_per_unit;
            }
        }
        let mut poses = Self::none(skeleton);
        for row in &rows {
            let test = TEST_SUBJECTS.contains(&row.subject.as_str());
            let frames = frames(&folder.join(&row.file), row, &poses.skeleton)?;
            poses.add(&row.subject, test, frames);
        }
        for (of, subjects) in [("train", &poses.train_subjects), ("test", &poses.test_subjects)] {
            if subjects.is_empty() {
                let what = format!("no subject to {of} on");
                return Err(DataError::Missing { file: index, what });
            }
        }
        Ok(poses)
    }

    /// The built-in clips at 12 Hz, in place of subjects: every sixth is tested on. Frames with gaps are left out.
    pub fn built_in() -> Self {
        let clips = builtin::clips();
        let mut poses = Self::none(clips[0].skeleton.clone());
        for (number, clip) in clips.iter().enumerate() {
            let frames = kept(clip.rate_hz(), 0, clip.frames.len()).filter_map(|frame| {
                clip.frames[frame].iter().map(|sample| sample.map(|s| s.rotation)).collect()
            });
            poses.add(&clip.name, number % 6 == 5, frames.collect());
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

    fn add(&mut self, subject: &str, test: bool, mut frames: Vec<Pose>) {
        for frame in &mut frames {
            frame[0] = without_heading(frame[0]);
        }
        let (poses, subjects) = if test {
            (&mut self.test, &mut self.test_subjects)
        } else {
            (&mut self.train, &mut self.train_subjects)
        };
        poses.append(&mut frames);
        subjects.insert(subject.to_owned());
        self.recordings += 1;
    }
}

/// A rotation without its turn about the vertical y: the twist of its swing-twist decomposition taken out on the
/// left. Upside down it has none, and keeps what it has.
fn without_heading(rotation: DQuat) -> DQuat {
    let twist = DQuat::from_xyzw(0.0, rotation.y, 0.0, rotation.w);
    if twist.length() < 1e-9 { rotation } else { twist.normalize().inverse() * rotation }
}

/// The rows of the 31-joint skeletons, every trial once, thinned recordings first; sorted by file.
fn rows(index: &Path) -> Result<Vec<Row>, DataError> {
    let failed = |source| DataError::Index { file: index.to_path_buf(), source };
    let mut rows = Vec::new();
    for row in csv::Reader::from_path(index).map_err(failed)?.deserialize() {
        let row: Row = row.map_err(failed)?;
        for (key, value) in [("fps", row.fps), ("metres_per_unit", row.metres_per_unit)] {
            if !(value > 0.0 && value.is_finite()) {
                let (file, recording) = (index.to_path_buf(), row.file);
                return Err(DataError::Number { file, recording, key, value });
            }
        }
        rows.push(row);
    }
    rows.retain(|row| SKELETONS.contains(&row.skeleton.as_str()));
    rows.sort_by(|a, b| (a.fps.total_cmp(&b.fps)).then_with(|| a.file.cmp(&b.file)));
    let mut seen = BTreeSet::new();
    rows.retain(|row| seen.insert((row.subject.clone(), row.trial.clone())));
    rows.sort_by(|a, b| a.file.cmp(&b.file));
    Ok(rows)
}

/// The rotations of a recording's frames, its joints in the order of `skeleton`.
fn frames(path: &Path, row: &Row, skeleton: &Skeleton) -> Result<Vec<Pose>, DataError> {
    let recording = bvh::read(path)?;
    let find = |(index, name): (usize, &String)| {
        let missing = || DataError::Joint { file: path.to_path_buf(), joint: name.clone() };
        let of_asf = || recording.skeleton.find(ASF_NAMES.get(index)?);
        recording.skeleton.find(name).or_else(of_asf).ok_or_else(missing)
    };
    let names = skeleton.joints.iter().map(|joint| &joint.name);
    let order: Vec<usize> = names.enumerate().map(find).collect::<Result<_, _>>()?;
    let first = usize::from(row.tpose_first_frame);
    let pose = |frame: usize| {
        // A BVH file has no gaps.
        let rotation = |joint: &usize| recording.frames[frame][*joint].map(|s| s.rotation);
        order.iter().map(rotation).collect::<Option<Pose>>()
    };
    Ok(kept(row.fps, first, recording.frames.len()).filter_map(pose).collect())
}

/// The frames that are kept of a recording that begins with frame `first`.
fn kept(rate_hz: f64, first: usize, count: usize) -> impl Iterator<Item = usize> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positive, and a rate of frames is far below 2^32"
    )]
    let whole = |x: f64| x as usize;
    let step = whole((rate_hz / RATE_HZ).round().max(1.0));
    // What is not later than the settling time, to a thousandth of a frame.
    let settling = whole((SETTLING_S * rate_hz - 1e-3).ceil());
    (first + settling..count).step_by(step)
}

/// Positions of the joints with the root at the origin, in metres, and their global rotations.
pub(super) fn forward_kinematics(skeleton: &Skeleton, pose: &[DQuat]) -> Vec<JointSample> {
    let local = skeleton.joints.iter().zip(pose).map(|(joint, rotation)| JointSample {
        rotation: *rotation,
        position_m: if joint.parent.is_some() { joint.offset_m } else { DVec3::ZERO },
    });
    clip::forward_kinematics(skeleton, &local.collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
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
    fn the_first_tenth_of_a_second_is_left_out() {
        assert_eq!(kept(12.0, 0, 5).collect::<Vec<_>>(), [2, 3, 4]);
        assert_eq!(kept(120.0, 1, 35).collect::<Vec<_>>(), [13, 23, 33]);
        assert_eq!(kept(120.0, 1, 3).count(), 0);
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
    fn cmu_is_split_by_subject_and_no_trial_counts_twice() {
        let data = PathBuf::from(std::env::var("SINEW_DATA").expect("the tests' runner sets it"));
        let rows = rows(&data.join("cmu/index.csv")).unwrap();
        let trials: BTreeSet<_> = rows.iter().map(|row| (&row.subject, &row.trial)).collect();
        assert_eq!(trials.len(), rows.len());
        assert!(rows.iter().any(|row| row.file == "fight/135_11_first1630.bvh"), "only there");
        let poses = Poses::cmu(&data.join("cmu")).unwrap();
        assert!(poses.train_subjects.is_disjoint(&poses.test_subjects));
        assert_eq!(poses.test_subjects.len(), TEST_SUBJECTS.len());
        assert_eq!(poses.skeleton.joints.len(), 31);
        assert_eq!(poses.recordings, rows.len());
        // As the study's document has them: what is published is of these.
        assert_eq!((poses.recordings, poses.train.len(), poses.test.len()), (178, 15_128, 3_995));
    }
}
