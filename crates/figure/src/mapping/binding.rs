//! A mapping bound to one skeleton: names are resolved to joints, and lengths are in metres.

use glam::{DQuat, DVec3};
use sinew_mocap::skeleton_map::{BodyJoints, MissingEnd};
use sinew_mocap::{Clip, JointSample, Skeleton, forward_kinematics};

use super::file::{Error, Mapping, Mistake};
use super::known::joint_names;
use crate::body::{BODIES, Body};
use crate::motion::FigureMotion;

/// The error of a skeleton whose left and right limbs have very different lengths.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "{part}: expected sides of about one length, found {left_m:.3} m on the left and {right_m:.3} m on the right: an \
     offset in the file is damaged, or the mapping wrong"
)]
pub struct UnlikeSides {
    /// Name of the limb.
    pub part: String,
    /// Length on the left, m.
    pub left_m: f64,
    /// Length on the right, m.
    pub right_m: f64,
}

/// A mapping bound to one skeleton: names are resolved to joints, and lengths are in metres.
#[derive(Debug, Clone)]
pub struct Binding {
    /// Index of the joint at the origin of each body.
    origin: Vec<usize>,
    /// Index of the joint whose frame each body has.
    rotation: Vec<usize>,
    /// Position of each body's origin in its parent's frame, in metres; zero for the pelvis.
    pub(super) offset_m: Vec<DVec3>,
    /// End of each body's segment in its own frame, in metres.
    pub(super) segment_end_m: Vec<DVec3>,
}

/// A body placed on the skeleton.
#[derive(Debug, Clone, Copy)]
struct Placed {
    origin: usize,
    rotation: usize,
    end_m: DVec3,
}

impl Placed {
    /// Places body `i`, whose parent is already placed, and appends what does not fit to `mistakes`. Returns `None` if
    /// a mistake makes it impossible to place the body.
    fn new(
        i: usize,
        part: &BodyJoints,
        prefix: &str,
        parent: Option<Self>,
        (skeleton, rest_m): (&Skeleton, &[DVec3]),
        mistakes: &mut Vec<Mistake>,
    ) -> Option<Self> {
        let body = BODIES[i].name;
        let mut find = |joint: &str| {
            let found = skeleton.find(&format!("{prefix}{joint}"));
            if found.is_none() {
                mistakes.push(Mistake::NoSuchJoint { body, joint: joint.to_owned() });
            }
            found
        };
        let (origin, rotation) = (find(&part.origin), find(&part.rotation));
        let end_m = match part.end.behind(prefix, skeleton, rest_m) {
            Ok(end_m) => Some(end_m),
            Err(MissingEnd::Joint(joint)) => {
                mistakes.push(Mistake::NoSuchJoint { body, joint });
                None
            }
            Err(MissingEnd::Site(joint)) => {
                mistakes.push(Mistake::NoEndSite { body, joint });
                None
            }
        };
        let (origin, rotation) = (origin?, rotation?);
        if let (Some(parent), Some(of)) = (parent, BODIES[i].parent) {
            for (key, joint) in [("origin", origin), ("rotation", rotation)] {
                let at_parent = key == "origin" && joint == parent.origin;
                if !at_parent && !skeleton.moves_with(parent.rotation, joint) {
                    let name = |joint: usize| skeleton.joints[joint].name.clone();
                    mistakes.push(Mistake::BrokenTree {
                        body,
                        key,
                        joint: name(joint),
                        parent: BODIES[of].name,
                        parent_joint: name(parent.rotation),
                    });
                }
            }
        }
        // Even without its end, a body can carry other bodies.
        Some(Self { origin, rotation, end_m: end_m.unwrap_or_default() })
    }
}

impl Binding {
    /// Binds `mapping` to `skeleton`.
    ///
    /// # Errors
    /// [`Error::Wrong`] with everything that does not fit: joints and end sites that the skeleton lacks, and
    /// bodies that do not move with their parents.
    pub fn new(mapping: &Mapping, skeleton: &Skeleton) -> Result<Self, Error> {
        let rest_m = skeleton.rest_positions_m();
        let prefix = mapping.signature.prefix(skeleton).unwrap_or_default();
        let mut mistakes = Vec::new();
        let mut placed: Vec<Option<Placed>> = Vec::with_capacity(BODIES.len());
        for (i, part) in mapping.parts.iter().enumerate() {
            let parent = BODIES[i].parent.and_then(|parent| placed[parent]);
            placed.push(Placed::new(i, part, prefix, parent, (skeleton, &rest_m), &mut mistakes));
        }
        if !mistakes.is_empty() {
            mistakes.dedup();
            let (mapping, found) = (mapping.name.clone(), joint_names(skeleton));
            return Err(Error::Wrong { mapping, mistakes, found });
        }
        let placed: Vec<Placed> = placed.into_iter().flatten().collect();
        let origin_m = |body: usize| rest_m[placed[body].origin];
        let offset_m = |(i, body): (usize, &Body)| {
            body.parent.map_or(DVec3::ZERO, |parent| origin_m(i) - origin_m(parent))
        };
        Ok(Self {
            origin: placed.iter().map(|body| body.origin).collect(),
            rotation: placed.iter().map(|body| body.rotation).collect(),
            offset_m: BODIES.iter().enumerate().map(offset_m).collect(),
            segment_end_m: placed.iter().map(|body| body.end_m - rest_m[body.origin]).collect(),
        })
    }

    /// Returns the figure's motion in `clip`, whose skeleton must be the bound one.
    pub fn map(&self, clip: &Clip) -> FigureMotion {
        let mut motion = FigureMotion {
            name: clip.name.clone(),
            dt_s: clip.frame_time_s,
            offset_m: self.offset_m.clone(),
            segment_end_m: self.segment_end_m.clone(),
            root_position_m: Vec::with_capacity(clip.frames.len()),
            rotation: Vec::with_capacity(clip.frames.len()),
        };
        for frame in 0..clip.frames.len() {
            let world = clip.world_poses(frame);
            motion.root_position_m.push(world[self.origin[0]].position_m);
            let turned = |body: usize| world[self.rotation[body]].rotation;
            let in_parent = BODIES.iter().enumerate().map(|(body, place)| {
                let parent = place.parent.map_or(DQuat::IDENTITY, turned);
                (parent.inverse() * turned(body)).normalize()
            });
            motion.rotation.push(in_parent.collect());
        }
        motion
    }

    /// Returns the index of the joint at the origin of a body.
    pub fn joint_of(&self, body: &str) -> Option<usize> {
        self.origin.get(BODIES.iter().position(|place| place.name == body)?).copied()
    }

    /// Returns, for each joint of `skeleton`, whether it moves a body of the figure.
    pub fn turning_joints(&self, skeleton: &Skeleton) -> Vec<bool> {
        let mut turns = vec![false; skeleton.joints.len()];
        for &joint in &self.rotation {
            let mut joint = Some(joint);
            while let Some(j) = joint {
                turns[j] = true;
                joint = skeleton.joints[j].parent;
            }
        }
        turns
    }

    /// Returns the figure's height when it stands upright, from the ankle to the crown, in metres.
    pub fn height_m(&self) -> f64 {
        let of = |name: &str, vectors: &[DVec3]| {
            let body = BODIES.iter().position(|body| body.name == name);
            body.map_or(0.0, |body| vectors[body].length())
        };
        let leg_m = of("shank_l", &self.offset_m) + of("foot_l", &self.offset_m);
        let trunk_m: f64 =
            ["abdomen", "thorax", "head"].map(|name| of(name, &self.offset_m)).iter().sum();
        leg_m + trunk_m + of("head", &self.segment_end_m)
    }

    /// Refuses a limb if one side is more than 1.5 times as long as the other, and the difference is more than 0.1 m.
    /// The aim is to find a damaged digit. Both thresholds are choices, since we do not know how much real sides can
    /// differ. A change of the first digit changes a length by half or more if the digit is small (1 to 2, 3 to 5), and
    /// an additional digit multiplies the length by ten. Smaller errors are accepted; they do proportionally less harm.
    ///
    /// # Errors
    /// [`UnlikeSides`] for the first limb whose sides differ by more than both thresholds.
    pub fn check_sides(&self) -> Result<(), UnlikeSides> {
        for (left, body) in BODIES.iter().enumerate() {
            let Some(part) = body.name.strip_suffix("_l") else { continue };
            let other = |other: &Body| other.name.strip_suffix("_r") == Some(part);
            let Some(right) = BODIES.iter().position(other) else { continue };
            for lengths_m in [&self.offset_m, &self.segment_end_m] {
                let [left_m, right_m] = [left, right].map(|side| lengths_m[side].length());
                // Shorter bones are those of hands, feet and clavicles. Their ends vary from one maker of
                // skeletons to another.
                if (left_m - right_m).abs() > 0.1 && left_m.max(right_m) > 1.5 * left_m.min(right_m)
                {
                    return Err(UnlikeSides { part: part.to_owned(), left_m, right_m });
                }
            }
        }
        Ok(())
    }

    /// Returns the world position of each body's origin joint in one frame of the recording, in metres.
    pub fn joint_positions_m(&self, skeleton: &Skeleton, frame: &[JointSample]) -> Vec<DVec3> {
        let world = forward_kinematics(skeleton, frame);
        self.origin.iter().map(|joint| world[*joint].position_m).collect()
    }

    /// Returns, for each body, the largest distance over `clip` between its origin in `motion` and its joint in the
    /// recording, in metres. The distance arises because the figure's trunk and neck have fewer joints.
    pub fn worst_distance_m(&self, clip: &Clip, motion: &FigureMotion) -> Vec<f64> {
        let mut worst_m = vec![0.0; BODIES.len()];
        for (f, frame) in clip.frames.iter().enumerate() {
            let recorded = self.joint_positions_m(&clip.skeleton, frame);
            let mapped = motion.world_positions_m(f);
            for i in 0..BODIES.len() {
                worst_m[i] = f64::max(worst_m[i], recorded[i].distance(mapped[i]));
            }
        }
        worst_m
    }
}
