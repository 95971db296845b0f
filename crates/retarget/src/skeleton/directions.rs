//! Finds up, forward and left, and whether a body stands like a human.

use glam::DVec3;

use super::body::{Body, Pose};
use super::pair::Pair;
use super::trunk::toe;

/// Directions of a standing performer, in the world of the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Directions {
    /// From the feet to the head, unit vector.
    pub up: DVec3,
    /// Direction of chest and toes, unit vector, perpendicular to `up`.
    pub forward: DVec3,
    /// Towards the left side, unit vector: `up` x `forward`.
    pub left: DVec3,
    /// Index of the most upright frame, in which these directions are measured; `None` for the rest pose (all
    /// rotations zero).
    pub frame: Option<usize>,
    /// Cosine of the angle between trunk and legs in that frame; 1 is straight.
    pub upright: f64,
}

/// The axis of the file that points up.
#[derive(Debug, Clone, PartialEq)]
pub struct UpAxis {
    /// The axis with its sign: `DVec3::Y`, `DVec3::Z`.
    pub axis: DVec3,
    /// Mean alignment of the body's own up with the axis; 1 is always along it.
    pub agreement: f64,
    /// Reason in plain words.
    pub reason: String,
}

/// Results from the poses.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Stance {
    pub directions: Option<Directions>,
    pub up: Option<UpAxis>,
    /// Whether toes and knees point forward if left and right are as assigned: positive if they do, negative if not;
    /// `None` if unknown.
    pub faces: Option<f64>,
    /// Whether the trunk is level, with arms along the legs.
    pub on_all_fours: bool,
}

/// The body's own axes in one pose.
struct Axes {
    /// From the hips to the shoulders; without shoulders, to the head; without hips, from the shoulders to the head.
    trunk: Option<DVec3>,
    /// From the ankles to the hips.
    legs: Option<DVec3>,
    /// From the wrists to the shoulders.
    arms: Option<DVec3>,
    /// From right to left.
    left: DVec3,
    /// Whether both legs have similar directions.
    legs_together: bool,
}

impl Axes {
    fn of(pose: &Pose, legs: Option<&Pair>, arms: Option<&Pair>, head: Option<usize>) -> Self {
        let middles = |pair: Option<&Pair>, place: usize| match pair.map(|pair| &pair.limbs) {
            Some([Some(left), Some(right)]) => {
                Some(pose.between(left.joints[place], right.joints[place]))
            }
            _ => None,
        };
        let aside = |pair: Option<&Pair>| match pair.map(|pair| &pair.limbs) {
            Some([Some(left), Some(right)]) => pose.at(left.joints[0]) - pose.at(right.joints[0]),
            _ => DVec3::ZERO,
        };
        let towards =
            |from: Option<DVec3>, to: Option<DVec3>| Some((to? - from?).normalize_or_zero());
        let (hips, shoulders) = (middles(legs, 0), middles(arms, 0));
        let trunk_end = shoulders.or_else(|| head.map(|head| pose.at(head)));
        let trunk = match (hips, shoulders) {
            (None, Some(_)) => towards(shoulders, head.map(|head| pose.at(head))),
            _ => towards(hips, trunk_end),
        };
        let legs_axis = towards(middles(legs, 2), hips);
        let legs_together = legs.is_some_and(|pair| {
            pair.both().all(|leg| {
                let own = (pose.at(leg.joints[0]) - pose.at(leg.joints[2])).normalize_or_zero();
                own.dot(legs_axis.unwrap_or_default()) > 0.7
            })
        });
        Self {
            trunk: trunk.filter(|axis| *axis != DVec3::ZERO),
            legs: legs_axis.filter(|axis| *axis != DVec3::ZERO),
            arms: towards(middles(arms, 2), shoulders),
            left: aside(legs) + aside(arms),
            legs_together,
        }
    }

    /// Returns the cosine of the angle between trunk and legs. Returns -1 if the legs point in different directions, or
    /// if both trunk and legs are missing. Returns 0.6 if only one of them is missing, since nothing contradicts an
    /// upright pose.
    fn upright(&self) -> f64 {
        match (self.trunk, self.legs) {
            (Some(trunk), Some(legs)) if self.legs_together => trunk.dot(legs),
            (Some(_), Some(_)) | (None, None) => -1.0,
            _ => 0.6,
        }
    }

    fn up(&self) -> DVec3 {
        (self.trunk.unwrap_or_default() + self.legs.unwrap_or_default()).normalize_or_zero()
    }

    /// Returns up, forward and left, if the pose defines them.
    fn frame(&self) -> Option<[DVec3; 3]> {
        let up = self.up();
        let left = (self.left - self.left.dot(up) * up).try_normalize()?;
        (up != DVec3::ZERO).then(|| [up, left.cross(up), left])
    }
}

impl Stance {
    pub(super) fn find(
        body: &Body,
        legs: Option<&Pair>,
        arms: Option<&Pair>,
        head: Option<usize>,
    ) -> Self {
        if legs.is_none() && arms.is_none() {
            return Self::default();
        }
        let poses: Vec<(&Pose, Axes)> =
            body.poses.iter().map(|pose| (pose, Axes::of(pose, legs, arms, head))).collect();
        // The zero pose of many files is not a real pose of a body: it counts only if it is upright.
        let counts = |(pose, axes): &&(&Pose, Axes)| {
            axes.upright() > if pose.frame.is_some() { 0.3 } else { 0.7 }
        };
        let bodily: Vec<_> = poses.iter().filter(counts).collect();
        let best = bodily.iter().fold(None::<&&(&Pose, Axes)>, |best, other| match best {
            // The rest pose is first, and is kept if it is about as upright as any other, because it has no noise.
            Some(best) if other.1.upright() < best.1.upright() + 0.02 => Some(best),
            _ => Some(other),
        });
        let directions = best.and_then(|(pose, axes)| {
            let [up, forward, left] = axes.frame()?;
            Some(Directions { up, forward, left, frame: pose.frame, upright: axes.upright() })
        });
        let votes = bodily.iter().filter_map(|(pose, axes)| faces(body, pose, axes, legs?));
        let (sum, weight) =
            votes.fold((0.0, 0.0), |(sum, weight), (vote, of)| (sum + vote, weight + of));
        let in_motion =
            || poses.iter().filter(|(pose, _)| pose.frame.is_some() || poses.len() == 1);
        let fours = in_motion().filter(|(_, axes)| on_all_fours(axes)).count();
        Self {
            up: up_axis(&poses),
            directions,
            faces: (weight > 0.0).then(|| sum / weight),
            on_all_fours: fours > 0
                && 10 * fours >= 8 * in_motion().count()
                && poses[0].1.upright() < 0.8,
        }
    }
}

/// Returns how well toes and bent knees agree with forward for these sides, and the weight of this. `None` if neither
/// toes nor knees show a direction.
fn faces(body: &Body, pose: &Pose, axes: &Axes, legs: &Pair) -> Option<(f64, f64)> {
    let [up, forward, _] = axes.frame()?;
    let (mut sum, mut weight) = (0.0, 0.0);
    for leg in legs.both() {
        let [hip, knee, ankle] = leg.joints;
        let long = leg.lengths[0] + leg.lengths[1];
        let toe = toe(body, ankle).map(|toe| pose.at(toe) - pose.at(ankle)).or_else(|| {
            let site = *body.skeleton.joints[ankle].end_sites_m.first()?;
            Some(pose.joints[ankle].rotation * site)
        });
        if let Some(toe) =
            toe.map(|toe| toe - toe.dot(up) * up).filter(|toe| toe.length() > 0.05 * long)
        {
            sum += 2.0 * toe.normalize().dot(forward);
            weight += 2.0;
        }
        let straight = pose.at(ankle) - pose.at(hip);
        let out = pose.at(knee) - pose.at(hip);
        let out =
            out - out.dot(straight) / straight.length_squared().max(f64::MIN_POSITIVE) * straight;
        if out.length() > 0.05 * long {
            sum += out.normalize().dot(forward);
            weight += 1.0;
        }
    }
    (weight > 0.0).then_some((sum, weight))
}

/// Returns whether the trunk is level, and legs and arms are perpendicular to it and parallel to each other.
fn on_all_fours(axes: &Axes) -> bool {
    let (Some(trunk), Some(legs), Some(arms)) = (axes.trunk, axes.legs, axes.arms) else {
        return false;
    };
    axes.legs_together && trunk.dot(legs).abs() < 0.6 && arms.dot(legs) > 0.6
}

/// Returns the axis nearest to the body's up, averaged over the clip, or in the rest pose without frames.
fn up_axis(poses: &[(&Pose, Axes)]) -> Option<UpAxis> {
    let ups = |moving: bool| -> Vec<DVec3> {
        let of = poses
            .iter()
            .filter(|(pose, axes)| pose.frame.is_some() == moving && axes.upright() > -0.5);
        of.map(|(_, axes)| axes.legs.or(axes.trunk).unwrap_or_default() + axes.up())
            .map(DVec3::normalize_or_zero)
            .collect()
    };
    let (ups, place) = match ups(true) {
        ups if !ups.is_empty() => (ups, "on average over the clip"),
        _ => (ups(false), "in the rest pose"),
    };
    if ups.is_empty() {
        return None;
    }
    let mean = ups.iter().sum::<DVec3>() / f64::from(u32::try_from(ups.len()).ok()?);
    let [axis, name] = [(DVec3::X, 'x'), (DVec3::Y, 'y'), (DVec3::Z, 'z')]
        .map(|(axis, name)| (mean.dot(axis), axis, name))
        .into_iter()
        .max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
        .map(
            |(along, axis, name)| {
                if along < 0.0 { (-axis, format!("-{name}")) } else { (axis, name.to_string()) }
            },
        )
        .map(|(axis, name)| [(axis, String::new()), (axis, name)])?;
    let agreement = mean.dot(axis.0);
    let reason = format!("from feet to head is along {} {place} (cosine {agreement:.2})", name.1);
    Some(UpAxis { axis: axis.0, agreement, reason })
}
