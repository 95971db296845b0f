//! From a recorded skeleton to the 18-body figure.
//!
//! A mapping file says for each body of the figure which joint of the recording it hangs on, which
//! joint's frame it takes, and where its segment ends. The offsets of the figure are those of the
//! recorded skeleton at rest, so that they are constant over a clip; the rotation of a body relative
//! to its parent holds the rotations of all joints between the two.

mod file;

use std::sync::LazyLock;

use glam::{DQuat, DVec3};
use sinew_mocap::skeleton_map::NoEnd;
use sinew_mocap::{Clip, JointSample, Recording, Skeleton, forward_kinematics};

use super::BODIES;
use super::motion::FigureMotion;

pub use file::{Error, Mapping};

/// The mapping of every skeleton that is known, in the order in which they are tried.
pub fn known() -> &'static [Mapping] {
    static KNOWN: LazyLock<Vec<Mapping>> = LazyLock::new(|| {
        macro_rules! mappings {
            ($($name:literal),*) => {
                [$(include_str!(concat!("../../../mappings/", $name, ".toml"))),*]
            };
        }
        let files = mappings!(
            "sinew",
            "cgspeed_mb",
            "cgspeed_mb_asf",
            "asfamc",
            "cmu_asf",
            "cgspeed_daz",
            "m21",
            "bandai",
            "geno",
            "deepmimic"
        );
        files.iter().map(|text| Mapping::parse(text).expect("the tests read every file")).collect()
    });
    &KNOWN
}

/// The one known mapping whose signature `skeleton` bears.
///
/// # Errors
/// [`Error::NoneMatches`] with the joints found and the mappings tried, or
/// [`Error::SeveralMatch`] with their names.
pub fn choose(skeleton: &Skeleton) -> Result<&'static Mapping, Error> {
    let matching: Vec<&Mapping> =
        known().iter().filter(|mapping| mapping.signature.matches(skeleton)).collect();
    let names = |mappings: &mut dyn Iterator<Item = &Mapping>| {
        mappings.map(|mapping| mapping.name.clone()).collect::<Vec<_>>().join(", ")
    };
    match matching[..] {
        [mapping] => Ok(mapping),
        [] => Err(Error::NoneMatches {
            found: joint_names(skeleton),
            tried: names(&mut known().iter()),
            nearest: nearest(skeleton).map_or_else(String::new, |(mapping, lacking)| {
                let why = if lacking.is_empty() {
                    "all of its joints are there, but other offsets are zero".to_owned()
                } else {
                    format!("the clip lacks its {}", lacking.join(", "))
                };
                format!(" The nearest is `{}`: {why}.", mapping.name)
            }),
        }),
        _ => Err(Error::SeveralMatch { names: names(&mut matching.into_iter()) }),
    }
}

/// The joints of a skeleton for a message, not all of a long list.
fn joint_names(skeleton: &Skeleton) -> String {
    const SHOWN_MAX: usize = 40;
    let names: Vec<_> =
        skeleton.joints.iter().take(SHOWN_MAX).map(|joint| joint.name.as_str()).collect();
    let rest = skeleton.joints.len() - names.len();
    let names = names.join(", ");
    if rest > 0 { format!("{names} and {rest} more") } else { names }
}

/// The known mapping of whose signature's joints `skeleton` has the largest share, and those it lacks.
fn nearest(skeleton: &Skeleton) -> Option<(&'static Mapping, Vec<&'static str>)> {
    known()
        .iter()
        .map(|mapping| {
            let names = mapping.signature.joints.iter().map(String::as_str);
            let lacking: Vec<_> = names.filter(|name| skeleton.find(name).is_none()).collect();
            (mapping, lacking)
        })
        .filter(|(mapping, lacking)| lacking.len() < mapping.signature.joints.len())
        .min_by_key(|(mapping, lacking)| lacking.len() * 1000 / mapping.signature.joints.len())
}

/// Neither the file nor its mapping tells the frame rate.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "the file does not tell its frame rate, and neither does mapping `{mapping}`: expected \
     `rate_hz = 120` or the like in the mapping"
)]
pub struct NoRate {
    /// Name of the mapping.
    pub mapping: String,
}

/// The two sides of a skeleton are not of one body.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "{part}: expected sides of about one length, found {left_m:.3} m on the left and {right_m:.3} m on the right: an \
     offset in the file is damaged, or the mapping wrong"
)]
pub struct UnlikeSides {
    /// The limb.
    pub part: String,
    /// On the left.
    pub left_m: f64,
    /// On the right.
    pub right_m: f64,
}

impl Mapping {
    /// Time between the frames of a recording, in seconds: its own, or else the mapping's.
    ///
    /// # Errors
    /// [`NoRate`] if nobody tells the rate.
    pub fn frame_time_s(&self, recording: &Recording) -> Result<f64, NoRate> {
        let told_s = recording.frame_time_s.or(self.rate_hz.map(f64::recip));
        told_s.ok_or_else(|| NoRate { mapping: self.name.clone() })
    }
}

/// A mapping bound to one skeleton: names are joints now, and lengths metres.
#[derive(Debug, Clone)]
pub struct Binding {
    /// The joint at the origin of each body.
    origin: Vec<usize>,
    /// The joint whose frame each body has.
    rotation: Vec<usize>,
    /// Position of each body's origin in its parent's frame, in metres; zero for the pelvis.
    offset_m: Vec<DVec3>,
    /// End of each body's segment in its own frame, in metres.
    segment_end_m: Vec<DVec3>,
}

impl Binding {
    /// Binds `mapping` to `skeleton`.
    ///
    /// # Errors
    /// [`Error::NoSuchJoint`] or [`Error::NoEndSite`] if the skeleton lacks what the mapping names.
    pub fn new(mapping: &Mapping, skeleton: &Skeleton) -> Result<Self, Error> {
        let rest_m = skeleton.rest_positions_m();
        let mut binding = Self {
            origin: vec![0; BODIES.len()],
            rotation: vec![0; BODIES.len()],
            offset_m: vec![DVec3::ZERO; BODIES.len()],
            segment_end_m: vec![DVec3::ZERO; BODIES.len()],
        };
        for (i, body) in BODIES.iter().enumerate() {
            let part = &mapping.parts[i];
            let no_such_joint = |joint: &str| Error::NoSuchJoint {
                mapping: mapping.name.clone(),
                body: body.name,
                joint: joint.to_owned(),
                found: joint_names(skeleton),
            };
            let find = |joint: &str| skeleton.find(joint).ok_or_else(|| no_such_joint(joint));
            let origin = find(&part.origin)?;
            binding.origin[i] = origin;
            binding.rotation[i] = find(&part.rotation)?;
            if let Some(parent) = body.parent {
                let frame_of_parent = binding.rotation[parent];
                for (key, joint) in [("origin", origin), ("rotation", binding.rotation[i])] {
                    let at_parent = key == "origin" && joint == binding.origin[parent];
                    if !at_parent && !skeleton.moves_with(frame_of_parent, joint) {
                        return Err(Error::BrokenTree {
                            mapping: mapping.name.clone(),
                            body: body.name,
                            key,
                            joint: skeleton.joints[joint].name.clone(),
                            parent: BODIES[parent].name,
                            parent_joint: skeleton.joints[frame_of_parent].name.clone(),
                        });
                    }
                }
                binding.offset_m[i] = rest_m[origin] - rest_m[binding.origin[parent]];
            }
            let end_m = part.end.rest_position_m(skeleton, &rest_m);
            let end_m = end_m.map_err(|lack| match lack {
                NoEnd::Joint(joint) => no_such_joint(&joint),
                NoEnd::Site(joint) => {
                    Error::NoEndSite { mapping: mapping.name.clone(), body: body.name, joint }
                }
            })?;
            binding.segment_end_m[i] = end_m - rest_m[origin];
        }
        Ok(binding)
    }

    /// The figure's motion in `clip`, which must be of the skeleton this was bound to.
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

    /// The joint at the origin of a body.
    pub fn joint_of(&self, body: &str) -> Option<usize> {
        self.origin.get(BODIES.iter().position(|place| place.name == body)?).copied()
    }

    /// Which joints of `skeleton` turn a body of the figure.
    pub(crate) fn turning_joints(&self, skeleton: &Skeleton) -> Vec<bool> {
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

    /// How tall the figure stands upright, from the ankle to the crown, in metres.
    pub(crate) fn height_m(&self) -> f64 {
        let of = |name: &str, vectors: &[DVec3]| {
            let body = BODIES.iter().position(|body| body.name == name);
            body.map_or(0.0, |body| vectors[body].length())
        };
        let leg_m = of("shank_l", &self.offset_m) + of("foot_l", &self.offset_m);
        let trunk_m: f64 =
            ["abdomen", "thorax", "head"].map(|name| of(name, &self.offset_m)).iter().sum();
        leg_m + trunk_m + of("head", &self.segment_end_m)
    }

    /// Refuses limbs of which one side is longer by half than the other: both hang on one body.
    pub(crate) fn check_sides(&self) -> Result<(), UnlikeSides> {
        for (left, body) in BODIES.iter().enumerate() {
            let Some(part) = body.name.strip_suffix("_l") else { continue };
            let other = |other: &super::Body| other.name.strip_suffix("_r") == Some(part);
            let Some(right) = BODIES.iter().position(other) else { continue };
            for lengths_m in [&self.offset_m, &self.segment_end_m] {
                let [left_m, right_m] = [left, right].map(|side| lengths_m[side].length());
                // Small ones differ by how a maker rounds them.
                if (left_m - right_m).abs() > 0.1 && left_m.max(right_m) > 1.5 * left_m.min(right_m)
                {
                    return Err(UnlikeSides { part: part.to_owned(), left_m, right_m });
                }
            }
        }
        Ok(())
    }

    /// World position of each body's origin joint in one frame of the recording, in metres.
    pub(crate) fn joint_positions_m(
        &self,
        skeleton: &Skeleton,
        frame: &[JointSample],
    ) -> Vec<DVec3> {
        let world = forward_kinematics(skeleton, frame);
        self.origin.iter().map(|joint| world[*joint].position_m).collect()
    }

    /// The largest distance over `clip` between each body's origin in `motion` and the joint of the
    /// recording that it stands for, in metres: what the figure's stiff trunk and neck cost.
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

#[cfg(test)]
mod tests;
