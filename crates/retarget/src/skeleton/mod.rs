//! Which joint of a recorded skeleton is which landmark of a body.
//!
//! Names speak first: cut into words, side and part of the body. Then the tree overrules: an elbow lies between
//! shoulder and wrist, the pelvis is what carries both hips. Lengths and directions of the bones decide where names say
//! nothing.
//! Each landmark comes with how sure it is and the weakest of its evidence.

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

/// Which joints of a skeleton are the landmarks of a human body.
#[derive(Debug, Clone, PartialEq)]
pub struct SkeletonMatch {
    found: BTreeMap<Landmark, Found>,
    missing: BTreeMap<Landmark, String>,
    /// Where up, forward and left are; `None` where no pose tells.
    pub directions: Option<Directions>,
    /// The axis of the file that points up; `None` where no pose tells.
    pub up: Option<UpAxis>,
    /// The unit of length; `None` without arms and legs.
    pub unit: Option<Unit>,
    /// What a person should know of the whole: a quadruped, sides that contradict the toes.
    pub findings: Vec<String>,
}

impl SkeletonMatch {
    /// Matches `skeleton`. `frames` are poses of its joints (`frames[f][j]`), which help where names say little: the
    /// rest pose of many files is no pose of a body. They may be none.
    ///
    /// Lengths may be in any unit. Time grows with the joints, not with the frames, of which at most 48 are looked at.
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

    /// Matches the skeleton of a recording by those of its frames that have no gap, see [`new`](Self::new).
    pub fn of_recording(recording: &Recording) -> Self {
        let is_whole = |frame: &usize| recording.frames[*frame].iter().all(Option::is_some);
        let whole = (0..recording.frames.len()).filter(is_whole);
        // Copies of what is looked at alone: a recording may be long.
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

    /// What is known of `landmark`; `None` if the skeleton has none.
    pub fn get(&self, landmark: Landmark) -> Option<&Found> {
        self.found.get(&landmark)
    }

    /// The joint of `landmark`.
    pub fn joint(&self, landmark: Landmark) -> Option<usize> {
        self.get(landmark).map(|found| found.joint)
    }

    /// Height of the body in the skeleton's unit; 0 where nothing tells it.
    fn height(&self) -> f64 {
        self.unit.as_ref().map_or(0.0, |unit| unit.height)
    }

    /// All that were found, from the trunk outwards.
    pub fn found(&self) -> impl Iterator<Item = (Landmark, &Found)> {
        self.found.iter().map(|(landmark, found)| (*landmark, found))
    }

    /// Those that were not, each with the reason.
    pub fn missing(&self) -> impl Iterator<Item = (Landmark, &str)> {
        self.missing.iter().map(|(landmark, reason)| (*landmark, reason.as_str()))
    }

    /// The one that is least sure.
    pub fn lowest(&self) -> Option<(Landmark, &Found)> {
        self.found().min_by(|a, b| a.1.confidence.total_cmp(&b.1.confidence))
    }
}

/// Sides that no name tells are those with which toes and knees point forward. Whether any was turned round.
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
