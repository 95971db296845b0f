//! Measures how few dimensions motion needs under a measure: classical multidimensional scaling, and Isomap, of a
//! recording's frames.
//!
//! The paper's figure 4 embeds two people's walks. For many recordings the paper gives the share of the first
//! component, with a mode of 40 % under the angle metric and of 80 % under the geodesic line.

mod report;

use std::iter;

use rayon::prelude::*;
use sinew_core::pose_space::PoseSpaceError;
use sinew_mocap::Skeleton;
use sinew_pose_metrics::spatial::{Distances, Measure, Metric, RigMeasure, SpatialError, SpatialRig, Weighting, Workspace};

use super::isomap::along_neighbours;
use super::mds::{Embedding, classical, spectrum};
use crate::recordings::{CMU_KINDS, Class, DataSet, Pose, Recordings, Sequence};
pub use report::{json, tables};
/// Settings of the study.
#[derive(Debug, Clone, Copy)]
pub struct Plan<'a> {
    /// The skeleton of both walks.
    pub skeleton: &'a Skeleton,
    /// Walks of two people, embedded together.
    pub walks: [&'a Sequence; 2],
    /// Recordings whose first component's share is computed.
    pub broad: &'a [Recordings],
    /// Joints relative to which poses are compared: the first one that a skeleton has; if empty, the root.
    pub roots: &'a [String],
    /// Steps in which lines are sampled.
    pub steps: u16,
    /// Number of neighbours to which Isomap connects every frame.
    pub neighbours: usize,
}

/// Results of the study.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// Embedding of both walks under every measure; the frames of the first walk are first.
    pub walks: Vec<(Measure, Embedding)>,
    /// Number of the first walk's frames.
    pub first_frames: usize,
    /// Results of every recording.
    pub recordings: Vec<RecordingResult>,
}

/// Results of one recording.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingResult {
    /// Path of the file.
    pub file: String,
    /// Data set of the recording.
    pub data_set: DataSet,
    /// Kind of skeleton.
    pub kind: String,
    /// Class of the motion.
    pub class: Class,
    /// Number of the recording's frames.
    pub frames: usize,
    /// Components under every measure, in the order of [`Measure::all`].
    pub components: Vec<Components>,
}

/// Shares of the first components of one recording under one measure. NaN if all poses are equal.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Components {
    /// Share of the first component.
    pub mds: f64,
    /// Sum of the negative eigenvalues relative to that of the positive ones.
    pub mds_negative: f64,
    /// Share of the first component with distances along neighbours.
    pub isomap: f64,
    /// Sum of the negative eigenvalues with distances along neighbours, relative to that of the positive ones.
    pub isomap_negative: f64,
    /// Share of the frames that are connected by neighbours.
    pub together: f64,
}

/// Selects a number of the components.
pub type Figure = fn(&Components) -> f64;

/// Error of a recording that cannot be compared in space.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The skeleton is invalid.
    #[error("{file}: {source}")]
    Skeleton {
        /// Path of the file.
        file: String,
        /// Reason for the failure.
        source: SpatialError,
    },
    /// The recording has no poses: it is shorter than the part that is left out at its beginning.
    #[error("{file}: expected poses, found none at 12 Hz")]
    NoPoses {
        /// Path of the file.
        file: String,
    },
    /// A pose is invalid.
    #[error("{file}: {source}")]
    Pose {
        /// Path of the file.
        file: String,
        /// Reason for the failure.
        source: PoseSpaceError,
    },
}

impl Plan<'_> {
    /// Returns all measures, with this plan's steps.
    pub fn measures(&self) -> impl Iterator<Item = Measure> {
        let steps = self.steps;
        Measure::all().map(move |measure| Measure { steps, ..measure })
    }

    /// Returns the number of recordings times measures in [`run`].
    pub fn steps(&self) -> usize {
        self.measures().count() * (1 + self.sequences().count())
    }

    fn sequences(&self) -> impl Iterator<Item = (&Skeleton, &Sequence)> {
        self.broad.iter().flat_map(|of| iter::repeat(&of.skeleton).zip(&of.sequences))
    }

    fn rig(&self, skeleton: &Skeleton, file: &str) -> Result<SpatialRig, Error> {
        let found = self.roots.iter().find(|root| skeleton.find(root).is_some());
        let root = found.or(self.roots.first()).map(String::as_str);
        let failed = |source| Error::Skeleton { file: file.to_owned(), source };
        SpatialRig::new(skeleton, root).map_err(failed)
    }
}

/// Embeds both walks, and computes the components of all recordings, in parallel; `done` is called for every measure
/// of each. The result is the same for any number of threads.
///
/// # Errors
/// [`Error`] of the first recording that cannot be compared.
pub fn run(plan: &Plan<'_>, done: &(dyn Fn(usize) + Sync)) -> Result<Study, Error> {
    let mut all = plan.walks.into_iter().chain(plan.sequences().map(|(_, sequence)| sequence));
    if let Some(sequence) = all.find(|sequence| sequence.frames.is_empty()) {
        return Err(Error::NoPoses { file: sequence.file.clone() });
    }
    let [first, second] = plan.walks;
    let rig = plan.rig(plan.skeleton, &first.file)?;
    let both: Vec<&Pose> = first.frames.iter().chain(&second.frames).collect();
    let walks = plan.measures().map(|measure| {
        let embedding = classical(&distances(&rig, measure, &both, &first.file)?, 3);
        done(1);
        Ok((measure, embedding))
    });
    let walks = walks.collect::<Result<_, Error>>()?;
    let sequences: Vec<_> = plan.sequences().collect();
    let recordings = sequences.par_iter().map(|(skeleton, sequence)| {
        let rig = plan.rig(skeleton, &sequence.file)?;
        let components = plan.measures().map(|measure| {
            let poses: Vec<&Pose> = sequence.frames.iter().collect();
            let distances = distances(&rig, measure, &poses, &sequence.file)?;
            done(1);
            Ok(Components::of(&distances, plan.neighbours))
        });
        Ok(RecordingResult {
            file: sequence.file.clone(),
            data_set: sequence.data_set,
            kind: sequence.kind.clone(),
            class: sequence.class,
            frames: sequence.frames.len(),
            components: components.collect::<Result<_, Error>>()?,
        })
    });
    let recordings = recordings.collect::<Result<_, _>>()?;
    Ok(Study { walks, first_frames: first.frames.len(), recordings })
}

/// A group of recordings that were made in the same way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecordingGroup {
    /// CMU's recordings, on the skeletons of 31 joints on which they were recorded.
    Cmu31,
    /// CMU's recordings, transferred to other skeletons.
    CmuOthers,
    /// Bandai's recordings.
    Bandai,
    /// The built-in clips.
    BuiltIn,
}

impl RecordingGroup {
    /// All groups, in the order in which they are shown.
    pub const ALL: [Self; 4] = [Self::Cmu31, Self::CmuOthers, Self::Bandai, Self::BuiltIn];

    /// Returns the name in tables and pictures.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Cmu31 => "CMU, 31 joints",
            Self::CmuOthers => "CMU, other skeletons",
            Self::Bandai => "Bandai",
            Self::BuiltIn => "built-in",
        }
    }
}

impl RecordingResult {
    /// Returns the group of the recording.
    pub fn part(&self) -> RecordingGroup {
        match self.data_set {
            DataSet::Cmu if CMU_KINDS.contains(&self.kind.as_str()) => RecordingGroup::Cmu31,
            DataSet::Cmu => RecordingGroup::CmuOthers,
            DataSet::Bandai => RecordingGroup::Bandai,
            DataSet::BuiltIn => RecordingGroup::BuiltIn,
        }
    }

    fn under(&self, metric: Metric, weighting: Weighting) -> &Components {
        let mut measures = Measure::all();
        let at = measures.position(|m| m.metric == metric && m.weighting == weighting);
        &self.components[at.expect("all measures are there")]
    }
}

impl Study {
    /// Returns a number for each recording under one measure, without recordings whose poses are all equal.
    pub fn figures<'a>(
        recordings: impl IntoIterator<Item = &'a RecordingResult>,
        metric: Metric,
        weighting: Weighting,
        of: Figure,
    ) -> Vec<f64> {
        let figures = recordings.into_iter().map(|one| of(one.under(metric, weighting)));
        figures.filter(|figure| figure.is_finite()).collect()
    }
}

/// Returns the paper's mode of the first component's share.
pub const fn mode_of_paper(metric: Metric) -> Option<f64> {
    match metric {
        Metric::Angles => Some(0.4),
        Metric::Line => Some(0.8),
        Metric::Rotations | Metric::Positions | Metric::Geodesic => None,
    }
}

impl Components {
    fn of(distances: &Distances, neighbours: usize) -> Self {
        let straight = spectrum(distances);
        let (together, along) = along_neighbours(distances, neighbours);
        let bent = spectrum(&along);
        let first = |shares: &[f64]| shares.first().copied().unwrap_or(f64::NAN);
        Self {
            mds: first(&straight.shares),
            mds_negative: straight.negative_share,
            isomap: first(&bent.shares),
            isomap_negative: bent.negative_share,
            together: together.len() as f64 / distances.count() as f64,
        }
    }
}

fn distances(
    rig: &SpatialRig,
    measure: Measure,
    poses: &[&Pose],
    file: &str,
) -> Result<Distances, Error> {
    let measuring = RigMeasure::new(rig, measure);
    let failed = |source| Error::Pose { file: file.to_owned(), source };
    let measured = poses.iter().map(|pose| measuring.pose(pose));
    let measured: Vec<_> = measured.collect::<Result<_, _>>().map_err(failed)?;
    Ok(Distances::new(
        measured.len(),
        Workspace::new,
        |workspace, a, b| measuring.distance(&measured[a], &measured[b], workspace),
        |_| (),
    ))
}
