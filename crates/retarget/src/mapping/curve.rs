//! Angles of a clip's joints that directly drive joints of the rig: jaws, brows and other parts of faces.

use std::f64::consts::TAU;

use glam::DVec3;
use sinew_mocap::{Clip, JointSample, Skeleton};
use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;

use super::resolve::{clip_joint, joint};
use super::{Mapping, MappingError, all};

/// Curves of a mapping, resolved on one rig and one clip.
#[derive(Debug, Clone, PartialEq)]
pub struct Curves(Vec<RigCurve>);

#[derive(Debug, Clone, PartialEq)]
struct RigCurve {
    /// Index of the clip's joint.
    joint: usize,
    axis: DVec3,
    points: Vec<[f64; 2]>,
    /// Index of the rig's coordinate in `q`.
    coordinate: usize,
    range: [f64; 2],
    speed: f64,
}

/// Applies curves to a performance frame by frame, with speed limits.
#[derive(Debug, Clone)]
pub struct Follower<'c> {
    curves: &'c Curves,
    last: Vec<Last>,
}

/// The last frame of a curve.
#[derive(Debug, Clone, Copy, Default)]
struct Last {
    /// Angle of the clip's joint with its turns, rad.
    angle: Option<f64>,
    /// Position of the rig's joint, rad or m.
    position: Option<f64>,
}

impl Mapping {
    /// Resolves the curves on a rig and a clip.
    ///
    /// # Errors
    /// [`MappingError`] with the curve, the name, and a description of a valid value.
    pub fn curves(
        &self,
        mechanism: &Mechanism,
        skeleton: &Skeleton,
    ) -> Result<Curves, MappingError> {
        let ranges = mechanism.coordinate_ranges();
        let ties = mechanism.ties();
        let on_rig = |(k, curve): (usize, &super::Curve)| {
            let body = joint(mechanism, &format!("curve[{k}].rig"), &curve.rig)?;
            let link = &mechanism.bodies[body];
            let fits = match link.joint {
                JointModel::Revolute(_) => !curve.slides,
                JointModel::Prismatic(_) => curve.slides,
                _ => false,
            };
            if !fits {
                let expected = if curve.slides {
                    "a joint that slides"
                } else {
                    "a joint that turns about one axis"
                };
                let found = format!("`{}`, which does not", curve.rig);
                return Err(MappingError::value(format!("curve[{k}].rig"), expected, found));
            }
            // A curve on a joint that follows another one drives its leader.
            let tie = ties.of(body);
            let leader = tie.map_or(body, |tie| tie.leader);
            let link = &mechanism.bodies[leader];
            let point = |&[angle, position]: &[f64; 2]| {
                [angle, tie.map_or(position, |tie| tie.leader_position(position))]
            };
            let own = link.speed;
            let default = if curve.slides { f64::INFINITY } else { self.performance.speed_rad_s };
            Ok(RigCurve {
                joint: clip_joint(skeleton, &format!("curve[{k}].clip"), &curve.clip)?,
                axis: DVec3::from_array(curve.axis).normalize(),
                points: curve.points.iter().map(point).collect(),
                coordinate: ranges[leader].start,
                range: link.ranges.first().copied().unwrap_or([f64::NEG_INFINITY, f64::INFINITY]),
                speed: if own.is_finite() { own } else { default },
            })
        };
        Ok(Curves(all(self.curves.iter().enumerate().map(on_rig))?))
    }
}

impl Curves {
    /// Creates a follower that starts at the first frame.
    pub fn follower(&self) -> Follower<'_> {
        Follower { curves: self, last: vec![Last::default(); self.0.len()] }
    }

    /// Writes the curves of a whole clip to the poses of a rig, frame by frame.
    pub fn put(&self, clip: &Clip, q: &mut [Vec<f64>]) {
        let mut follower = self.follower();
        for (local, q) in clip.frames.iter().zip(q) {
            follower.put(local, clip.frame_time_s, q);
        }
    }
}

impl Follower<'_> {
    /// Writes a frame's positions to `q`, within ranges and speeds. For a value that is not finite, the joint keeps
    /// its position.
    ///
    /// Angles count turns: from frame to frame they change by at most half a turn. The first angle is the one that is
    /// nearest to the middle of the curve's points.
    pub fn put(&mut self, local: &[JointSample], frame_s: f64, q: &mut [f64]) {
        for (curve, last) in self.curves.0.iter().zip(&mut self.last) {
            let angle = local.get(curve.joint).map(|sample| turn_about(curve.axis, sample));
            let angle = angle
                .filter(|angle| angle.is_finite())
                .map(|angle| nearest_turn(angle, last.angle.unwrap_or_else(|| curve.middle())));
            last.angle = angle.or(last.angle);
            let Some(q) = q.get_mut(curve.coordinate) else { continue };
            let wanted = angle.map(|angle| at(&curve.points, angle));
            let Some(wanted) = wanted.or(last.position) else { continue };
            let [least, most] = curve.range;
            let near = last.position.map_or(wanted, |last| {
                let step = curve.speed * frame_s;
                wanted.max(last - step).min(last + step)
            });
            *q = near.max(least).min(most);
            last.position = Some(*q);
        }
    }
}

impl RigCurve {
    /// Returns the middle of the clip's angles, rad.
    fn middle(&self) -> f64 {
        let ends = self.points.first().zip(self.points.last());
        ends.map_or(0.0, |(first, last)| 0.5 * (first[0] + last[0]))
    }
}

/// Returns the angle, rad, that differs from `angle` by full turns and is nearest to `near`.
fn nearest_turn(angle: f64, near: f64) -> f64 {
    angle + TAU * libm::rint((near - angle) / TAU)
}

/// Returns the angle of a joint's rotation about an axis, in [-π, π].
fn turn_about(axis: DVec3, sample: &JointSample) -> f64 {
    let q = if sample.rotation.w < 0.0 { -sample.rotation } else { sample.rotation };
    2.0 * libm::atan2(q.xyz().dot(axis), q.w)
}

/// Interpolates linearly between the points; beyond them, returns the value of the nearest point.
fn at(points: &[[f64; 2]], x: f64) -> f64 {
    let [Some(first), Some(last)] = [points.first(), points.last()] else { return f64::NAN };
    if x <= first[0] {
        return first[1];
    }
    let pair = points.windows(2).find(|pair| x <= pair[1][0]);
    pair.map_or(last[1], |pair| {
        let t = (x - pair[0][0]) / (pair[1][0] - pair[0][0]);
        pair[0][1] + (pair[1][1] - pair[0][1]) * t
    })
}
