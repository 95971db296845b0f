//! Retargets a clip to a rig.

use std::ops::Range;

use glam::DVec3;
use sinew_retarget::feasibility::RigMotion;
use sinew_retarget::mapping::{Mapping, MappingError};
use sinew_retarget::performer::{Performer, PerformerError, PerformerJoints};
use sinew_retarget::rig::{RigMatch, RigMatchError};
use sinew_retarget::solve::{self, Baked, BakedLimb, Hand, Settings, best_tilt};
use sinew_rig::Mechanism;
use sinew_rig::mechanism::{Link, Pose};
use thiserror::Error;

use super::clip::PreparedClip;

/// A clip that was retargeted to a rig, with its difference from the performer.
#[derive(Debug, Clone)]
pub struct RetargetedClip {
    /// The rig's coordinates, frame by frame.
    pub motion: RigMotion,
    /// Mean angle between the performer's limbs and the rig's, over all limbs and frames, deg.
    pub limbs_mean_deg: f64,
    /// Largest angle between a performer's limb and the rig's, deg.
    pub limbs_max_deg: f64,
    /// Number of limbs that are compared.
    pub limbs: usize,
    /// Number of joints that follow by a curve.
    pub curves: usize,
    /// Share of frames in which a joint is at an end of its range.
    pub at_range: f64,
    /// The dof that is most often at an end of its range, and its share of the frames; `None` if no dof ever is, and
    /// for a motion of the rig's own joints.
    pub most_held: Option<(String, f64)>,
    /// Limbs of the rig; `None` if it has none, and for a motion of the rig's own joints.
    pub rig: Option<RigMatch>,
    /// Mean and largest distance of a hand from the performer's, as shares of the arm; `None` if none is followed.
    pub hand_error: Option<[f64; 2]>,
    /// Hands whose paths are followed: a rig that is only an arm.
    pub hands: Vec<Hand>,
    /// For each frame of the clip, the performer's place of each hand relative to its shoulder, scaled to the rig, m.
    pub hand_targets_m: Vec<Vec<Option<[f32; 3]>>>,
    /// For each frame of the clip: the performer's limbs in the rig's world, by the landmark at their ends.
    pub limb_targets: Vec<Vec<BakedLimb>>,
}

/// The reason why a clip cannot be retargeted to a rig.
#[derive(Debug, Error)]
pub enum RetargetError {
    /// No arm, leg or head was found in the rig.
    #[error("{0}; curves from single joints, in a mapping, can drive it: see docs/shows.md")]
    Rig(#[from] RigMatchError),
    /// The mapping does not fit the rig or the clip.
    #[error(transparent)]
    Mapping(#[from] MappingError),
    /// No joint would move.
    #[error(
        "the mapping has neither a [[landmark]] nor a [[curve]]: no joint would follow anything"
    )]
    Nothing,
    /// No performer was found in the clip.
    #[error("{clip}: {source}")]
    Performer {
        /// Name of the clip.
        clip: String,
        /// Reason for the error.
        source: PerformerError,
    },
}

/// The joints of rig and clip that correspond.
struct Roles {
    rig: Option<RigMatch>,
    joints: PerformerJoints,
    settings: Settings,
}

impl Roles {
    /// Finds the correspondence by names and geometry, or reads it from a mapping.
    fn of(
        mechanism: &Mechanism,
        clip: &PreparedClip,
        mapping: Option<&Mapping>,
    ) -> Result<Self, RetargetError> {
        let Some(mapping) = mapping else {
            let rig = Some(RigMatch::of(mechanism)?);
            let settings = rig.as_ref().map_or_else(Settings::default, Settings::of);
            return Ok(Self { rig, joints: clip.joints(), settings });
        };
        if mapping.landmarks.is_empty() && mapping.curves.is_empty() {
            return Err(RetargetError::Nothing);
        }
        mapping.check(mechanism, &clip.clip.skeleton)?;
        let joints = mapping.performer_joints(&clip.clip.skeleton)?;
        // A rig without landmarks, such as a face, follows by curves only.
        let rig =
            (!mapping.landmarks.is_empty()).then(|| mapping.rig_match(mechanism)).transpose()?;
        Ok(Self { rig, joints, settings: mapping.settings() })
    }
}

/// Retargets a clip to a rig, by names and geometry, or by a mapping. `mirror`: swaps left and right.
///
/// # Errors
/// [`RetargetError`] if no arm, leg or head is found in the rig or in the clip, or if the mapping does not fit them or
/// is empty.
pub fn retarget_clip(
    mechanism: &Mechanism,
    clip: &PreparedClip,
    mapping: Option<&Mapping>,
    mirror: bool,
) -> Result<RetargetedClip, RetargetError> {
    let Roles { rig, joints, mut settings } = Roles::of(mechanism, clip, mapping)?;
    settings.is_mirrored ^= mirror;
    let mut baked = match &rig {
        None => still(mechanism, clip),
        Some(rig) => {
            let performer = Performer::of(&clip.clip, &joints).map_err(|source| {
                RetargetError::Performer { clip: clip.clip.name.clone(), source }
            })?;
            if mapping.is_none() {
                settings.tilt_rad = best_tilt(mechanism, rig, &clip.clip, &performer, &settings);
            }
            solve::bake(mechanism, rig, &clip.clip, &performer, &settings)
        }
    };
    let mut rows = std::mem::take(&mut baked.q);
    let curves =
        mapping.map(|mapping| mapping.curves(mechanism, &clip.clip.skeleton)).transpose()?;
    if let Some(curves) = &curves {
        curves.put(&clip.clip, &mut rows);
    }
    let mut motion = RigMotion { dt_s: baked.frame_time_s, rows };
    motion.follow(&mechanism.ties());
    let mut clip = RetargetedClip {
        rig,
        curves: mapping.map_or(0, |mapping| mapping.curves.len()),
        ..taken(mechanism, motion, baked)
    };
    clip.hand_error = clip.hand_error_of(mechanism);
    Ok(clip)
}

/// Returns the rig at home, for the duration of the clip.
fn still(mechanism: &Mechanism, clip: &PreparedClip) -> Baked {
    let frames = clip.clip.frames.len();
    Baked {
        frame_time_s: clip.clip.frame_time_s,
        q: vec![mechanism.home(); frames],
        limbs: vec![Vec::new(); frames],
        hands: Vec::new(),
        hand_targets_m: vec![Vec::new(); frames],
        held: vec![Vec::new(); frames],
    }
}

fn taken(mechanism: &Mechanism, motion: RigMotion, baked: Baked) -> RetargetedClip {
    let errors = || baked.limbs.iter().flatten().map(|limb| f64::from(limb.error_rad));
    let count = errors().count();
    let frames = motion.rows.len().max(1);
    let names = mechanism.dof_names();
    let (mut at_range, mut of_dof) = (0_usize, vec![0_usize; names.len()]);
    for held in &baked.held {
        let mut ends = held.iter().filter(|held| held.bound == solve::Bound::Range).peekable();
        at_range += usize::from(ends.peek().is_some());
        ends.for_each(|held| of_dof[held.dof] += 1);
    }
    let most_held = names.into_iter().zip(of_dof).max_by_key(|(_, count)| *count);
    RetargetedClip {
        motion,
        limbs_mean_deg: (errors().sum::<f64>() / count.max(1) as f64).to_degrees(),
        limbs_max_deg: errors().fold(0.0, f64::max).to_degrees(),
        limbs: count / frames,
        curves: 0,
        at_range: at_range as f64 / frames as f64,
        most_held: most_held
            .filter(|(_, count)| *count > 0)
            .map(|(joint, count)| (joint, count as f64 / frames as f64)),
        rig: None,
        hand_error: None,
        hands: baked.hands,
        hand_targets_m: baked.hand_targets_m,
        limb_targets: baked.limbs,
    }
}

impl RetargetedClip {
    /// Wraps a motion of the rig's own joints, which needs no retargeting.
    pub fn own(motion: RigMotion) -> Self {
        let frames = motion.rows.len();
        Self {
            motion,
            limbs_mean_deg: 0.0,
            limbs_max_deg: 0.0,
            limbs: 0,
            curves: 0,
            at_range: 0.0,
            most_held: None,
            rig: None,
            hand_error: None,
            hands: Vec::new(),
            hand_targets_m: vec![Vec::new(); frames],
            limb_targets: vec![Vec::new(); frames],
        }
    }

    /// Returns the distance between each hand whose path is followed and the performer's, scaled to the rig, at a time
    /// of the clip, as shares of the arm.
    pub fn hand_errors<'a>(
        &'a self,
        clip_time_s: f64,
        poses: &'a [Pose],
    ) -> impl Iterator<Item = f64> + 'a {
        let ([before, after], part) = self.frames_at(clip_time_s);
        let targets_m = self.hand_targets_m[before].iter().zip(&self.hand_targets_m[after]);
        self.hands.iter().zip(targets_m).filter_map(move |(hand, (before_m, after_m))| {
            let [before_m, after_m] =
                [before_m.or(*after_m)?, after_m.or(*before_m)?].map(|m| m.map(f64::from));
            let target_m = DVec3::from_array(before_m).lerp(DVec3::from_array(after_m), part);
            let [shoulder_m, place_m] = [hand.shoulder, hand.point]
                .map(|point| poses.get(point.body).map(|pose| pose.point(point.position_m)));
            Some((place_m? - shoulder_m?).distance(target_m) / hand.arm_m)
        })
    }

    /// Returns the joint that exceeds its maximum speed most: its body, its largest speed, and its maximum speed, rad/s
    /// or m/s. Returns `None` if the motion follows no path of a hand, or no joint exceeds its maximum speed.
    pub fn too_fast(&self, mechanism: &Mechanism) -> Option<(usize, f64, f64)> {
        if self.hands.is_empty() {
            return None;
        }
        let ranges = mechanism.coordinate_ranges();
        let links = mechanism.bodies.iter().zip(&ranges).enumerate();
        let of_link = |(body, (link, range)): (usize, (&Link, &Range<usize>))| {
            let step = |rows: &[Vec<f64>]| (rows[1][range.start] - rows[0][range.start]).abs();
            let speed =
                self.motion.rows.windows(2).map(step).fold(0.0, f64::max) / self.motion.dt_s;
            (body, speed, link.speed)
        };
        links
            .filter(|(_, (link, range))| range.len() == 1 && link.speed.is_finite())
            .map(of_link)
            .filter(|(_, speed, most)| speed > most)
            .max_by(|a, b| (a.1 / a.2).total_cmp(&(b.1 / b.2)))
    }

    /// Returns mean and largest distance of the hands over all frames, as shares of the arm; `None` if no hand is
    /// followed.
    fn hand_error_of(&self, mechanism: &Mechanism) -> Option<[f64; 2]> {
        if self.hands.is_empty() {
            return None;
        }
        let of_row = |(row, q): (usize, &Vec<f64>)| -> Vec<f64> {
            let poses = mechanism.poses(q);
            self.hand_errors(row as f64 * self.motion.dt_s, &poses).collect()
        };
        let errors: Vec<f64> = self.motion.rows.iter().enumerate().flat_map(of_row).collect();
        let most = errors.iter().copied().fold(0.0, f64::max);
        (!errors.is_empty()).then(|| [errors.iter().sum::<f64>() / errors.len() as f64, most])
    }

    /// Returns the frames before and after a time of the clip, and the weight of the second frame.
    fn frames_at(&self, clip_time_s: f64) -> ([usize; 2], f64) {
        let last = self.hand_targets_m.len() - 1;
        let place = (clip_time_s / self.motion.dt_s).max(0.0).min(last as f64);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to last")]
        let before = place as usize;
        ([before, (before + 1).min(last)], place - before as f64)
    }

    /// Returns the frame at a time of the clip.
    fn frame_at(&self, clip_time_s: f64) -> usize {
        let last = self.limb_targets.len() - 1;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let frame = (clip_time_s / self.motion.dt_s).round().max(0.0) as usize;
        frame.min(last)
    }

    /// Returns the angle between each limb of the rig and the performer's limb at a time of the clip, deg. `poses`:
    /// poses of the rig's bodies in the world.
    pub fn limb_errors_deg<'a>(
        &'a self,
        clip_time_s: f64,
        poses: &'a [Pose],
    ) -> impl Iterator<Item = f64> + 'a {
        self.limb_targets[self.frame_at(clip_time_s)].iter().filter_map(|limb| {
            let target = DVec3::from_array(limb.target.map(f64::from));
            let limb = self.rig.as_ref()?.limb_direction(poses, limb.landmark)?;
            Some(libm::atan2(limb.cross(target).length(), limb.dot(target)).to_degrees())
        })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use sinew_mocap::files::ClipFile;

    use super::*;
    use crate::ClipSettings;

    /// Returns an arm of six joints with this maximum speed, rad/s, and a clip of punches retargeted to the arm.
    fn punches(speed_rad_s: f64) -> (Mechanism, RetargetedClip) {
        let mut arm = sinew_rig::new::arm(6).unwrap();
        arm.joints.iter_mut().for_each(|joint| joint.speed_rad_s = Some(speed_rad_s));
        let mechanism = arm.mechanism().unwrap();
        let file = ClipFile::new(Path::new("punches_01"));
        let mut clip = PreparedClip::read(&file, ClipSettings::default()).unwrap();
        clip.cut(4.0);
        let taken = retarget_clip(&mechanism, &clip, None, false).unwrap();
        (mechanism, taken)
    }

    #[test]
    fn the_hand_of_a_small_arm_goes_along_the_performers_path() {
        let (mechanism, taken) = punches(10.0);
        let [mean, most] = taken.hand_error.unwrap();
        println!("mean {:.1} % of the arm, largest {:.1} %", 100.0 * mean, 100.0 * most);
        // Limits against regressions, a little above the measured values (0.4 % and 11.2 %). The distance is largest
        // when the arm reverses at its maximum speed, past its own upright axis.
        assert!(mean < 0.01 && most < 0.15, "{mean} {most}");
        // A slow arm moves along the same path, and reports that it is too slow.
        let (of_slow, slow) = punches(1.0);
        assert_eq!((&slow.motion, slow.hand_error), (&taken.motion, taken.hand_error));
        let (_, asked, limit) = slow.too_fast(&of_slow).unwrap();
        assert!(asked > limit && (limit - 1.0).abs() < 1e-12, "{asked} {limit}");
        let (_, as_fast, _) = taken.too_fast(&mechanism).unwrap_or((0, 10.0, 10.0));
        assert!(as_fast <= 12.1, "{as_fast}");
    }
}
