//! Recordings for the studies: those in a data folder's `index.csv`, at 12 Hz.
//!
//! Poses of different recordings can be compared only on one skeleton: [`Recordings::cmu`] and [`Recordings::bandai`]
//! put them on one. For comparisons within a recording its own skeleton is enough: [`broad`].

mod index;
#[cfg(test)]
mod tests;

use std::path::Path;

use glam::DQuat;
use sinew_mocap::{JointSample, Recording, Skeleton, SkeletonJoint, bvh};

pub use index::{Class, DataError, RATE_HZ};
use index::{Row, thinned};
use sinew_figure::builtin;

/// Time at the start of CMU's recordings and of built-in clips that is left out, s: fingers settle, feet jump.
const SETTLING_S: f64 = 0.1;

/// Local rotation of every joint, in the order of the skeleton; the root's in the world.
pub type Pose = Vec<DQuat>;

/// Origin of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum DataSet {
    /// CMU's motion capture database.
    Cmu,
    /// The Bandai-Namco Research motion data set.
    Bandai,
    /// The built-in clips.
    BuiltIn,
}

/// A recording at [`RATE_HZ`].
#[derive(Debug, Clone, PartialEq)]
pub struct Sequence {
    /// Path of the file in the data set's folder, or a built-in clip's name.
    pub file: String,
    /// Subject of the motion: CMU's number of the person. Bandai names no actors; there it is the data set's part.
    pub subject: String,
    /// Name of the subject's trial.
    pub trial: String,
    /// Description of the motion.
    pub description: String,
    /// Class of the motion.
    pub class: Class,
    /// Data set of the recording.
    pub data_set: DataSet,
    /// Kind of skeleton on which the motion was recorded, as in the index.
    pub kind: String,
    /// Poses, at [`RATE_HZ`].
    pub frames: Vec<Pose>,
}

/// Recordings on one skeleton.
#[derive(Debug, Clone, PartialEq)]
pub struct Recordings {
    /// The skeleton of all poses, in metres.
    pub skeleton: Skeleton,
    /// The recordings, sorted by file.
    pub sequences: Vec<Sequence>,
}

/// CMU's skeletons of 31 joints, by their names in the index.
pub const CMU_KINDS: [&str; 2] = ["cgspeed-mb", "asfamc"];
/// The file whose skeleton all of CMU's recordings use: the ASF form of subject 135 has the bones of thorax and palm,
/// which the other conversion lost.
const CMU_REFERENCE: &str = "broad-12hz/135_03.bvh";
/// The file whose skeleton all of Bandai's recordings use: between files, no joint's place on its parent differs by
/// more than 0.4 mm.
const BANDAI_REFERENCE: &str = "broad-12hz/dataset-1_walk_normal_002.bvh";
/// A joint on the floor that is the root of Bandai's skeletons. The line from it to the hips is not a bone.
const BANDAI_FLOOR: &str = "joint_Root";
/// Folder in which both data sets have recordings of all kinds.
const BROAD: &str = "broad-12hz/";

/// Names of the reference's joints in some of CMU's files (those of the ASF files), in the order of the reference.
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

impl Recordings {
    /// Reads all trials of CMU's 31-joint skeletons in a folder with its `index.csv`, each once, on one skeleton.
    ///
    /// # Errors
    /// [`DataError`] if a file is missing or does not match the index.
    pub fn cmu(folder: &Path) -> Result<Self, DataError> {
        let mut rows = index::read(folder)?;
        rows.retain(|row| CMU_KINDS.contains(&row.skeleton.as_str()));
        let rows = index::trials_once(rows);
        Self::on_one(folder, &rows, DataSet::Cmu, CMU_REFERENCE, &ASF_NAMES)
    }

    /// Reads Bandai's recordings of all kinds in a folder with its `index.csv`, on one skeleton.
    ///
    /// # Errors
    /// [`DataError`] if a file is missing or does not match the index.
    pub fn bandai(folder: &Path) -> Result<Self, DataError> {
        let mut rows = index::read(folder)?;
        rows.retain(|row| row.file.starts_with(BROAD));
        Self::on_one(folder, &rows, DataSet::Bandai, BANDAI_REFERENCE, &[])
    }

    /// Returns the built-in clips, each as its own subject. Frames with gaps are left out.
    pub fn built_in() -> Self {
        let clips = builtin::clips();
        let sequence = |clip: &Recording| {
            let class = if clip.name.starts_with("kick") { Class::Kick } else { Class::Punch };
            let frames = thinned(
                clip.frame_time_s.expect("a rate").recip(),
                SETTLING_S,
                0,
                clip.frames.len(),
            );
            Sequence {
                file: clip.name.clone(),
                subject: clip.name.clone(),
                trial: String::new(),
                description: clip.name.clone(),
                class,
                data_set: DataSet::BuiltIn,
                kind: "built-in".to_owned(),
                frames: frames.filter_map(|frame| gapless(&clip.frames[frame])).collect(),
            }
        };
        Self {
            skeleton: clips[0].skeleton.clone(),
            sequences: clips.iter().map(sequence).collect(),
        }
    }

    /// Reads the recordings of `rows` on the skeleton of the file `reference`.
    fn on_one(
        folder: &Path,
        rows: &[Row],
        data_set: DataSet,
        reference: &str,
        other_names: &[&str],
    ) -> Result<Self, DataError> {
        let listed = rows.iter().find(|row| row.file == reference);
        let row = listed.ok_or_else(|| DataError::Missing {
            file: index::of(folder),
            what: format!("{reference} is not listed"),
        })?;
        let (skeleton, _) = read(folder, row, data_set)?;
        let mut sequences = Vec::with_capacity(rows.len());
        for row in rows {
            let (own, mut sequence) = read(folder, row, data_set)?;
            let find = |(index, joint): (usize, &SkeletonJoint)| {
                let by_other = || own.find(other_names.get(index)?);
                own.find(&joint.name).or_else(by_other).ok_or_else(|| DataError::Joint {
                    file: folder.join(&row.file),
                    joint: joint.name.clone(),
                    reference: reference.to_owned(),
                })
            };
            let joints = skeleton.joints.iter().enumerate();
            let order: Vec<usize> = joints.map(find).collect::<Result<_, _>>()?;
            for frame in &mut sequence.frames {
                *frame = order.iter().map(|joint| frame[*joint]).collect();
            }
            sequences.push(sequence);
        }
        Ok(Self { skeleton, sequences })
    }
}

/// Reads the recordings of all kinds in a data folder, CMU's in `cmu` and Bandai's in `bandai`, each on its own
/// skeleton.
///
/// # Errors
/// [`DataError`] if a file is missing or does not match the index.
pub fn broad(data: &Path) -> Result<Vec<Recordings>, DataError> {
    let mut all = Vec::new();
    for (name, data_set) in [("cmu", DataSet::Cmu), ("bandai", DataSet::Bandai)] {
        let folder = data.join(name);
        let rows = index::read(&folder)?;
        for row in rows.iter().filter(|row| row.file.starts_with(BROAD)) {
            let (skeleton, sequence) = read(&folder, row, data_set)?;
            all.push(Recordings { skeleton, sequences: vec![sequence] });
        }
    }
    Ok(all)
}

/// Reads a recording, with its skeleton in metres.
fn read(folder: &Path, row: &Row, data_set: DataSet) -> Result<(Skeleton, Sequence), DataError> {
    let recording = bvh::read(&folder.join(&row.file))?;
    let settling_s = if data_set == DataSet::Cmu { SETTLING_S } else { 0.0 };
    let first = usize::from(row.tpose_first_frame);
    let kept = thinned(row.fps, settling_s, first, recording.frames.len());
    // A BVH file has no gaps.
    let mut frames: Vec<Pose> =
        kept.filter_map(|frame| gapless(&recording.frames[frame])).collect();
    let Recording { mut skeleton, .. } = recording;
    if skeleton.joints.len() > 1 && skeleton.joints[0].name == BANDAI_FLOOR {
        leave_out_floor(&mut skeleton, &mut frames, &folder.join(&row.file))?;
    }
    for joint in &mut skeleton.joints {
        joint.offset_m *= row.metres_per_unit;
        for end in &mut joint.end_sites_m {
            *end *= row.metres_per_unit;
        }
    }
    let sequence = Sequence {
        file: row.file.clone(),
        subject: row.subject.clone(),
        trial: row.trial.clone(),
        description: row.description.clone(),
        class: row.class,
        data_set,
        kind: row.skeleton.clone(),
        frames,
    };
    Ok((skeleton, sequence))
}

fn gapless(frame: &[Option<JointSample>]) -> Option<Pose> {
    frame.iter().map(|sample| sample.map(|s| s.rotation)).collect()
}

/// Makes the second joint the root.
fn leave_out_floor(
    skeleton: &mut Skeleton,
    frames: &mut [Pose],
    file: &Path,
) -> Result<(), DataError> {
    if let Some(joint) = skeleton.joints[2..].iter().find(|joint| joint.parent == Some(0)) {
        let what = format!("{} hangs on {BANDAI_FLOOR}: expected the hips alone", joint.name);
        return Err(DataError::Missing { file: file.to_path_buf(), what });
    }
    skeleton.joints.remove(0);
    for joint in &mut skeleton.joints {
        joint.parent = joint.parent.and_then(|parent| parent.checked_sub(1));
    }
    for frame in frames {
        let floor = frame.remove(0);
        frame[0] = floor * frame[0];
    }
    Ok(())
}
