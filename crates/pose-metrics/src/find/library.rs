//! The query and the searched clips, all on the query's skeleton.

use std::path::{Path, PathBuf};

use glam::DQuat;
use rayon::prelude::*;
use sinew_core::pose_space::PoseSpaceError;
use sinew_figure::Mapping;
use sinew_figure::pipeline::{self, LoadedClip, Notice, Settings, load_clip};
use sinew_mocap::files::{self, ClipFile};
use sinew_mocap::resample::resample;
use sinew_mocap::{Clip, JointSample, Skeleton, moving_root};

use super::joints::{Mismatch, same_joints};
use super::reference::{ClipPart, Reference, ReferenceError};
use crate::spatial::{MeasuredPose, RigMeasure, Rigid};

/// The pose or the clip to search for.
#[derive(Debug, Clone, PartialEq)]
pub struct Query {
    /// Path of the query's file.
    pub file: PathBuf,
    /// Name of the query's clip.
    pub name: String,
    /// Whether the query is a single pose.
    pub is_pose: bool,
    /// Skeleton on which poses are compared: the moving part of the file's skeleton.
    pub skeleton: Skeleton,
    /// Frames of the query, with a rotation for each joint of the skeleton; a clip is at the search rate.
    pub poses: Vec<Vec<DQuat>>,
    /// Time of the first pose, in seconds from frame 0 of the file.
    pub start_s: f64,
    /// Rate of the search, Hz.
    pub rate_hz: f64,
    /// Mapping of the query's skeleton to the figure; `None` if the skeleton is not human.
    pub mapping: Option<Mapping>,
    /// Changes that were made to the query when it was read.
    pub notices: Vec<Notice>,
}

/// The error of a query or a clip that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// A clip that cannot be read.
    #[error(transparent)]
    Clip(#[from] pipeline::Error),
    /// A part of the query that is not in its file.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// A clip with another skeleton.
    #[error("{}: {source}", file.display())]
    Mismatch {
        /// Path of the clip's file.
        file: PathBuf,
        /// Difference between the skeletons.
        source: Mismatch,
    },
    /// A pose that cannot be compared.
    #[error("{}: frame {frame}: {source}", file.display())]
    Pose {
        /// Path of the clip's file.
        file: PathBuf,
        /// Frame, at the search rate.
        frame: usize,
        /// Reason why the pose cannot be compared.
        source: PoseSpaceError,
    },
}

impl Query {
    /// Reads the query.
    ///
    /// # Errors
    /// [`ReadError::Clip`] and [`ReadError::Reference`].
    pub fn read(
        reference: &Reference,
        settings: &Settings,
        rate_hz: f64,
    ) -> Result<Self, ReadError> {
        let (recorded, notices) = load_clip(&ClipFile::new(&reference.file), settings)?;
        let (first, last) = reference.frames(&recorded)?;
        let LoadedClip { clip, skipped, mapping, .. } = recorded;
        let (skeleton, joints) = clip.skeleton.subtree(moving_root(&[&clip]));
        let is_pose = matches!(reference.part, ClipPart::Pose(_));
        let start_s = (skipped + first) as f64 * clip.frame_time_s;
        let part = Clip { frames: clip.frames[first..=last].to_vec(), ..clip };
        // A single frame is not resampled.
        let part = if is_pose { part } else { resample(&part, rate_hz) };
        let poses = rotations(&part, &joints);
        let (file, name) = (reference.file.clone(), part.name);
        Ok(Self { file, name, is_pose, skeleton, poses, start_s, rate_hz, mapping, notices })
    }
}

fn rotations(clip: &Clip, joints: &[usize]) -> Vec<Vec<DQuat>> {
    let pose =
        |frame: &Vec<JointSample>| joints.iter().map(|joint| frame[*joint].rotation).collect();
    clip.frames.iter().map(pose).collect()
}

/// A clip that is searched.
#[derive(Debug, Clone, PartialEq)]
pub struct LibraryClip {
    /// Path of the clip's file.
    pub file: PathBuf,
    /// Name of the clip.
    pub name: String,
    /// Poses at the search rate, with a rotation for each joint of the query.
    pub poses: Vec<Vec<DQuat>>,
    /// Time of the first pose, in seconds from frame 0 of the file.
    pub start_s: f64,
    /// Frames per second of the file.
    pub file_rate_hz: f64,
    /// Changes that were made to the clip when it was read.
    pub notices: Vec<Notice>,
}

/// The clips that are searched.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Library {
    /// Clips in the given order.
    pub clips: Vec<LibraryClip>,
    /// A line for each file of a folder that cannot be searched: its name and the reason.
    pub left_out: Vec<String>,
}

impl Library {
    /// Reads the clips that `paths` name, in parallel; `done` is called for each. A clip that is damaged, or whose
    /// skeleton is not the query's, is skipped if it was found in a folder, unless `is_strict`.
    ///
    /// # Errors
    /// [`ReadError`] for the first faulty clip that is not skipped, or for the first faulty clip of all if no clip can
    /// be searched.
    pub fn read(
        paths: &[PathBuf],
        query: &Query,
        settings: &Settings,
        is_strict: bool,
        done: impl Fn(usize) + Sync,
    ) -> Result<Self, ReadError> {
        let expanded = files::expand_all(paths).map_err(pipeline::Error::from)?;
        let read: Vec<Result<LibraryClip, ReadError>> = expanded
            .clips
            .par_iter()
            .map(|file| {
                let shelved = LibraryClip::read(file, query, settings);
                done(1);
                shelved
            })
            .collect();
        let (clips, left_out) = expanded.take(read, is_strict)?;
        Ok(Self { clips, left_out })
    }

    /// Finds the joints that move in the query or in a clip, see [`Rigid`]; `root` is kept.
    pub fn rigid(&self, query: &Query, root: Option<&str>) -> Rigid {
        let poses = query.poses.iter().chain(self.clips.iter().flat_map(|clip| &clip.poses));
        Rigid::new(&query.skeleton, poses, root)
    }

    /// Precomputes the clips' poses for comparison, in parallel. A pose takes 68 bytes for each of `N` bodies.
    ///
    /// # Errors
    /// [`ReadError::Pose`].
    pub fn measured<const N: usize>(
        &self,
        measuring: &RigMeasure<'_, N>,
        rigid: &Rigid,
    ) -> Result<Vec<Vec<MeasuredPose<N>>>, ReadError> {
        let of_clip = |clip: &LibraryClip| measured(measuring, rigid, &clip.poses, &clip.file);
        self.clips.par_iter().map(of_clip).collect()
    }
}

/// Precomputes poses for comparison.
///
/// # Errors
/// [`ReadError::Pose`] with the file of the poses.
pub(super) fn measured<const N: usize>(
    measuring: &RigMeasure<'_, N>,
    rigid: &Rigid,
    poses: &[Vec<DQuat>],
    file: &Path,
) -> Result<Vec<MeasuredPose<N>>, ReadError> {
    let pose = |(frame, rotations): (usize, &Vec<DQuat>)| {
        let file = || file.to_path_buf();
        let pose = measuring.pose(&rigid.pose(rotations));
        pose.map_err(|source| ReadError::Pose { file: file(), frame, source })
    };
    poses.iter().enumerate().map(pose).collect()
}

impl Query {
    /// Precomputes the query's poses for comparison.
    ///
    /// # Errors
    /// [`ReadError::Pose`].
    pub fn measured<const N: usize>(
        &self,
        measuring: &RigMeasure<'_, N>,
        rigid: &Rigid,
    ) -> Result<Vec<MeasuredPose<N>>, ReadError> {
        measured(measuring, rigid, &self.poses, &self.file)
    }
}

impl LibraryClip {
    fn read(file: &ClipFile, query: &Query, settings: &Settings) -> Result<Self, ReadError> {
        let (LoadedClip { clip, skipped, .. }, notices) = load_clip(file, settings)?;
        let joints = same_joints(&query.skeleton, &clip.skeleton);
        let joints =
            joints.map_err(|source| ReadError::Mismatch { file: file.path.clone(), source })?;
        let resampled = resample(&clip, query.rate_hz);
        Ok(Self {
            file: file.path.clone(),
            name: file.name.clone(),
            poses: rotations(&resampled, &joints),
            start_s: skipped as f64 * clip.frame_time_s,
            file_rate_hz: clip.rate_hz(),
            notices,
        })
    }

    /// Returns the time of a pose, in seconds from frame 0 of the file.
    pub fn seconds(&self, pose: usize, rate_hz: f64) -> f64 {
        self.start_s + pose as f64 / rate_hz
    }

    /// Returns the file's frame that is nearest to a time.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a frame of the file"
    )]
    pub fn frame(&self, seconds: f64) -> usize {
        libm::round(seconds * self.file_rate_hz) as usize
    }
}
