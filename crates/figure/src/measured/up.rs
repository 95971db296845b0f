//! Finds the axis of a file that points up.

use glam::DVec3;
use sinew_mocap::{JointSample, Recording, Skeleton, Up, axis_name, forward_kinematics};
use sinew_retarget::skeleton::SkeletonMatch;
use sinew_retarget::{Landmark, Side};

/// The axis that points up, and the reason for the choice.
#[derive(Debug, Clone, PartialEq)]
pub struct UpGuess {
    /// Up axis in the file's world, a unit vector.
    pub axis: DVec3,
    /// Up axis in the rest pose, in which no joint is turned, a unit vector.
    pub rest: DVec3,
    /// Reason for the choice, in plain words.
    pub reason: String,
    /// Warning that contradicts the choice: the body lies on its side or is head down.
    pub doubt: Option<String>,
}

/// Number of frames of a clip that are examined, evenly spread.
const FRAMES: usize = 48;
/// Minimum agreement between the body's own up and an axis, in the mean over a clip, for the clip to count as
/// evidence. It corresponds to about half of a right angle.
const AGREEMENT: f64 = 0.7;
/// Maximum distance of a standing body's lowest point from the file's zero, as a fraction of its height. Soles are
/// below the toes' joints, and capture floors are a few centimetres off.
const FLOOR: f64 = 0.1;
/// Number of frames out of ten in which the body must be on the floor.
const FLOOR_FRAMES: usize = 9;

impl UpGuess {
    /// Chooses the user's axis, or else that of the mapping or the format (`said`, with its source), or else the
    /// axis that the body indicates.
    ///
    /// An axis other than y that the body indicates is accepted only if the rest pose also stands along it, if the body
    /// stands on a floor perpendicular to it, or if there are no frames; otherwise y is chosen. For a body that lies,
    /// crawls or stands on its hands, neither of the first two is the case.
    pub(super) fn new(
        recording: &Recording,
        matched: &SkeletonMatch,
        units: Option<Up>,
        said: Option<(Up, &str)>,
    ) -> Self {
        let rest = rest_up(&recording.skeleton, matched);
        let found = |axis: DVec3, reason: &str, doubt| Self {
            axis,
            // A clip with y up is left unchanged, whatever its rest pose.
            rest: if axis == DVec3::Y { axis } else { rest.unwrap_or(axis) },
            reason: reason.to_owned(),
            doubt,
        };
        if let Some(up) = units {
            return found(up.axis(), "as you specified", lies(matched, up.axis()));
        }
        if let Some((up, who)) = said {
            return found(up.axis(), who, lies(matched, up.axis()));
        }
        let Some(up) = matched.up.as_ref().filter(|up| up.agreement > AGREEMENT) else {
            return found(DVec3::Y, "as in most files: the body stands along no axis", None);
        };
        if up.axis == DVec3::Y {
            return found(DVec3::Y, "the body stands along it", None);
        }
        if rest == Some(up.axis) || recording.frames.is_empty() {
            return found(up.axis, "the body stands along it, at rest too", None);
        }
        if stands_on_floor(recording, matched, up.axis) {
            return found(up.axis, "the body stands along it, on a floor across it", None);
        }
        found(DVec3::Y, "as in most files", lies(matched, DVec3::Y))
    }
}

/// Returns a warning if the body lies on its side or head down when `up` points up.
fn lies(matched: &SkeletonMatch, up: DVec3) -> Option<String> {
    let body = matched.up.as_ref().filter(|body| body.agreement > AGREEMENT)?;
    (body.axis != up).then(|| {
        format!(
            "warning: the body lies on its side or head down: from feet to head is along {} in the mean, and {} is up; \
             if another axis points up, say so with --up",
            axis_name(body.axis),
            axis_name(up)
        )
    })
}

/// Returns the axis along which the rest pose stands, if it is the pose of a standing body.
fn rest_up(skeleton: &Skeleton, matched: &SkeletonMatch) -> Option<DVec3> {
    let rest = skeleton.rest_positions_m();
    let middle = |landmark: fn(Side) -> Landmark| -> Option<DVec3> {
        let [left, right] = Side::ALL.map(|side| matched.joint(landmark(side)));
        Some((rest[left?] + rest[right?]) / 2.0)
    };
    let head = matched.joint(Landmark::Head).map(|head| rest[head]);
    let hips = middle(Landmark::Hip)?;
    let legs = (hips - middle(Landmark::Ankle)?).try_normalize()?;
    let trunk = (middle(Landmark::Shoulder).or(head)? - hips).try_normalize()?;
    let up = (legs + trunk).try_normalize()?;
    // The body must be straight, as if standing, and along an axis.
    let axis =
        DVec3::AXES.into_iter().max_by(|a, b| up.dot(*a).abs().total_cmp(&up.dot(*b).abs()))?;
    let axis = axis * up.dot(axis).signum();
    (legs.dot(trunk) > AGREEMENT && up.dot(axis) > AGREEMENT).then_some(axis)
}

/// Returns whether the lowest point of the body is near the zero of an axis, in nearly all frames.
fn stands_on_floor(recording: &Recording, matched: &SkeletonMatch, axis: DVec3) -> bool {
    let Some(height) = matched.unit.as_ref().map(|unit| unit.height) else { return false };
    let (mut near, mut count) = (0, 0);
    for places in whole_frames(recording) {
        let lowest = places.iter().map(|place| place.dot(axis)).fold(f64::INFINITY, f64::min);
        near += usize::from(lowest.abs() < FLOOR * height);
        count += 1;
    }
    count > 0 && 10 * near >= FLOOR_FRAMES * count
}

/// Returns the positions of all joints and ends in the frames without a gap.
fn whole_frames(recording: &Recording) -> impl Iterator<Item = Vec<DVec3>> + '_ {
    let step = recording.frames.len().div_ceil(FRAMES).max(1);
    let whole = recording.frames.iter().step_by(step).filter_map(|frame| {
        let samples: Option<Vec<JointSample>> = frame.iter().copied().collect();
        samples
    });
    whole.map(|samples| places(&recording.skeleton, &samples))
}

fn places(skeleton: &Skeleton, samples: &[JointSample]) -> Vec<DVec3> {
    let poses = forward_kinematics(skeleton, samples);
    let ends = poses.iter().zip(&skeleton.joints).flat_map(|(pose, joint)| {
        joint.end_sites_m.iter().map(|end| pose.position_m + pose.rotation * *end)
    });
    poses.iter().map(|pose| pose.position_m).chain(ends).collect()
}

/// Returns the extents along up and across; see [`super::extents`].
pub(super) fn extents(recording: &Recording, up: DVec3) -> [f64; 2] {
    let rest = || recording.skeleton.rest_positions_m();
    let places = whole_frames(recording).next().unwrap_or_else(rest);
    let along = |axis: DVec3| {
        let (low, high) = places
            .iter()
            .map(|place| place.dot(axis))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        (high - low).max(0.0)
    };
    let across = DVec3::AXES.into_iter().filter(|axis| axis.dot(up).abs() < 0.5);
    [along(up), across.map(along).fold(0.0, f64::max)]
}
