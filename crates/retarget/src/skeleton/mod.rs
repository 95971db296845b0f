//! Matches joints of a recorded skeleton with landmarks of a body.
//!
//! First, names are split into words, which give side and part of the body. The tree overrules names: an elbow is
//! between shoulder and wrist, and the pelvis carries both hips. If names are unknown, lengths and directions of the
//! bones decide. Each landmark has a confidence and a reason: its weakest evidence.

mod body;
mod confidence;
mod directions;
mod figure;
mod found;
mod limb;
mod name;
mod pair;
mod text;
mod trunk;
mod unit;
mod vocabulary;

use std::collections::BTreeMap;

use sinew_mocap::{Clip, JointSample, Recording, Skeleton};

use body::Body;
use confidence::Judge;
use directions::Stance;
use pair::{Pair, agree_on_sides, legs_and_arms};
use trunk::Trunk;

pub use directions::{Directions, UpAxis};
pub use figure::{FigureMapping, FigureMappingError, MapHead, Note, figure_mapping, head_end};
pub use found::Found;
pub use unit::{BODY_HEIGHT_M, Unit};

use crate::{Landmark, Side};

/// The joints of a skeleton that are landmarks of a human body.
#[derive(Debug, Clone, PartialEq)]
pub struct SkeletonMatch {
    found: BTreeMap<Landmark, Found>,
    missing: BTreeMap<Landmark, String>,
    /// Directions of up, forward and left; `None` if no pose defines them.
    pub directions: Option<Directions>,
    /// Axis of the file that points up; `None` if no pose defines it.
    pub up: Option<UpAxis>,
    /// Unit of length; `None` without arms and legs.
    pub unit: Option<Unit>,
    /// Findings about the skeleton as a whole: a quadruped, or sides that contradict the toes.
    pub findings: Vec<String>,
}

impl SkeletonMatch {
    /// Matches `skeleton`. `frames` contains poses of its joints (`frames[f][j]`), which help if names are unknown,
    /// because the rest pose of many files is not a real pose of a body. It may be empty.
    ///
    /// Lengths may be in any unit. The time grows with the number of joints, not of frames, of which at most 48 are
    /// evaluated.
    pub fn new(skeleton: &Skeleton, frames: &[Vec<JointSample>]) -> Self {
        if skeleton.joints.is_empty() {
            return Self::none("the skeleton has no joints");
        }
        let body = Body::new(skeleton, frames);
        let [mut legs, mut arms] = legs_and_arms(&body);
        if let (Ok(legs), Ok(arms)) = (&mut legs, &mut arms) {
            agree_on_sides(&body, legs, arms);
        }
        let mut trunk = Trunk::find(&body, legs.as_ref().ok(), arms.as_ref().ok());
        let mut stance = Stance::find(&body, legs.as_ref().ok(), arms.as_ref().ok(), trunk.head);
        if swap_by_geometry(&mut legs, &mut arms, stance.faces) {
            trunk = Trunk::find(&body, legs.as_ref().ok(), arms.as_ref().ok());
            stance = Stance::find(&body, legs.as_ref().ok(), arms.as_ref().ok(), trunk.head);
        }
        let unit = Unit::guess(&body, legs.as_ref().ok(), arms.as_ref().ok(), &trunk);
        let judge = Judge::new(&body, &legs, &arms, &trunk, &stance);
        let (found, missing) = judge.landmarks();
        let findings = judge.findings();
        Self { found, missing, directions: stance.directions, up: stance.up, unit, findings }
    }

    /// Matches the skeleton of `clip`, see [`new`](Self::new).
    pub fn of_clip(clip: &Clip) -> Self {
        Self::new(&clip.skeleton, &clip.frames)
    }

    /// Matches the skeleton of a recording from its frames without gaps, see [`new`](Self::new).
    pub fn of_recording(recording: &Recording) -> Self {
        let is_whole = |frame: &usize| recording.frames[*frame].iter().all(Option::is_some);
        let whole = (0..recording.frames.len()).filter(is_whole);
        // Copies only the evaluated frames, because a recording may be long.
        let looked_at: Vec<usize> = whole.clone().step_by(body::step(whole.count())).collect();
        let samples = |frame: &usize| recording.frames[*frame].iter().flatten().copied().collect();
        let frames: Vec<Vec<JointSample>> = looked_at.iter().map(samples).collect();
        let mut matched = Self::new(&recording.skeleton, &frames);
        if let Some(frame) = matched.directions.as_mut().and_then(|found| found.frame.as_mut()) {
            *frame = looked_at[*frame];
        }
        matched
    }

    fn none(reason: &str) -> Self {
        let missing =
            Landmark::ALL.into_iter().map(|landmark| (landmark, reason.to_owned())).collect();
        Self {
            found: BTreeMap::new(),
            missing,
            directions: None,
            up: None,
            unit: None,
            findings: Vec::new(),
        }
    }

    /// Returns the match of `landmark`; `None` if the skeleton does not have it.
    pub fn get(&self, landmark: Landmark) -> Option<&Found> {
        self.found.get(&landmark)
    }

    /// Returns the joint of `landmark`; `None` if the landmark was not found.
    pub fn joint(&self, landmark: Landmark) -> Option<usize> {
        self.get(landmark).map(|found| found.joint)
    }

    /// Returns the height of the body, in the skeleton's unit; 0 if unknown.
    fn height(&self) -> f64 {
        self.unit.as_ref().map_or(0.0, |unit| unit.height)
    }

    /// Returns all landmarks that were found, from the trunk outwards.
    pub fn found(&self) -> impl Iterator<Item = (Landmark, &Found)> {
        self.found.iter().map(|(landmark, found)| (*landmark, found))
    }

    /// Returns all landmarks that were not found, each with the reason.
    pub fn missing(&self) -> impl Iterator<Item = (Landmark, &str)> {
        self.missing.iter().map(|(landmark, reason)| (*landmark, reason.as_str()))
    }

    /// Returns the landmark with the lowest confidence; `None` if no landmark was found.
    pub fn lowest(&self) -> Option<(Landmark, &Found)> {
        self.found().min_by(|a, b| a.1.confidence.total_cmp(&b.1.confidence))
    }
}

/// Exchanges the sides if no name gives them and toes and knees point backwards. Returns whether the sides were
/// exchanged.
fn swap_by_geometry(
    legs: &mut Result<Pair, String>,
    arms: &mut Result<Pair, String>,
    faces: Option<f64>,
) -> bool {
    let pairs = || legs.iter().chain(arms.iter());
    if pairs().any(|pair| pair.sided) || faces.is_none_or(|faces| faces >= 0.0) {
        return false;
    }
    for pair in [legs, arms].into_iter().flatten() {
        pair.limbs.swap(Side::Left as usize, Side::Right as usize);
    }
    true
}
