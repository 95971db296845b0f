//! Limits of a rig's joints.

use sinew_rig::Mechanism;
use sinew_rig::mechanism::{JointModel, Link, LinkedRange, Ties};
use sinew_rig::review::Servos;

use super::report::{Excess, Kind, Report};

/// Time constant of the mean square of the effort, which measures heat, s: that of a small servo's motor.
const THERMAL_TIME_S: f64 = 60.0;

/// Limits of one dof; infinite without limit.
#[derive(Debug, Clone, PartialEq)]
pub struct DofLimits {
    /// Name of the dof, see [`Mechanism::dof_names`].
    pub name: String,
    /// Index of the body that the dof's joint moves.
    pub joint: usize,
    /// Whether the dof slides: units are m and N, otherwise rad and N m.
    pub slides: bool,
    /// Minimum and maximum position. Infinite for a ball joint, whose rotation is limited as a whole, see
    /// [`Limits::turns`].
    pub range: [f64; 2],
    /// Maximum speed, rad/s or m/s.
    pub speed: f64,
    /// Maximum acceleration, rad/s² or m/s².
    pub acceleration: f64,
    /// Maximum effort, N m or N.
    pub effort: f64,
    /// Continuous effort of the servos; `None` without servos.
    pub heat: Option<Heat>,
}

/// Continuous effort of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heat {
    /// Root mean square effort, N m or N.
    pub continuous: f64,
    /// Time constant of the mean, s.
    pub time_s: f64,
}

/// Limits of a rig.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// Limits of each dof, in the order of `qd`. Those of a driven base are infinite.
    pub dofs: Vec<DofLimits>,
    /// Maximum rotation of each ball joint from its zero pose: its body, and the angle, rad.
    pub turns: Vec<(usize, f64)>,
    /// Limits that join two joints, none of which follows another.
    pub linked: Vec<LinkedRange>,
    /// Joints that follow others. Their positions, speeds and accelerations have no limits of their own: those of the
    /// leaders include them.
    pub ties: Ties,
}

impl Limits {
    /// Collects the limits in the rig's description, and the continuous efforts of its servos.
    pub fn of(mechanism: &Mechanism, servos: &Servos) -> Self {
        let mut names = mechanism.dof_names().into_iter();
        let mut heat = servos.by_dof.iter();
        let (mut dofs, mut turns) = (Vec::new(), Vec::new());
        let ties = mechanism.ties();
        for (body, link) in mechanism.bodies.iter().enumerate() {
            if let (JointModel::Spherical, Some([_, most])) = (link.joint, link.ranges.first()) {
                turns.push((body, *most));
            }
            for axis in 0..link.joint.kind().dof_count() {
                let servo = heat.next().and_then(Option::as_ref);
                let none = f64::INFINITY;
                let driven = link.joint == JointModel::Free;
                let follows = ties.of(body).is_some();
                let or_none = |limit: f64| if driven { none } else { limit };
                let of_motion = |limit: f64| if driven || follows { none } else { limit };
                dofs.push(DofLimits {
                    name: names.next().unwrap_or_default(),
                    joint: body,
                    slides: matches!(link.joint, JointModel::Prismatic(_)) || (driven && axis >= 3),
                    range: if follows { [-none, none] } else { range(link, axis) },
                    speed: of_motion(link.speed),
                    acceleration: of_motion(link.acceleration),
                    effort: or_none(link.effort),
                    heat: servo
                        .map(|servo| Heat { continuous: servo.continuous, time_s: THERMAL_TIME_S }),
                });
            }
        }
        let linked = ties.limits().to_vec();
        Self { dofs, turns, linked, ties }
    }

    /// Multiplies every limit of speed, acceleration and effort by `share`: a margin for a spline.
    #[must_use]
    pub fn at(&self, share: f64) -> Self {
        let mut limits = self.clone();
        for dof in &mut limits.dofs {
            dof.speed *= share;
            dof.acceleration *= share;
            dof.effort *= share;
        }
        limits
    }
}

/// Factor by which an exceeded limit is multiplied before each new attempt.
const TIGHTER: f64 = 0.93;
/// Smallest such factor, for a following error: the error grows faster than speed and torque.
const TIGHTEST: f64 = 0.8;
/// Smallest limit of the torque because of a following error, as a multiple of the root mean square, which is about the
/// torque against gravity: a calmer motion does not reduce it.
const ABOVE_WEIGHT: f64 = 1.5;

impl Limits {
    /// Tightens the limits that a report lists as exceeded, for another attempt to make a spline of the motion.
    /// Each limit is tightened once, even if it is exceeded several times, because it applies to the whole motion.
    #[must_use]
    pub fn tightened(&self, report: &Report) -> Self {
        let mut limits = self.clone();
        let beyond = |excess: &Excess| (excess.value - excess.limit).abs();
        for of_limit in report.excesses.chunk_by(|a, b| (a.dof, a.kind) == (b.dof, b.kind)) {
            let excess = &of_limit[0];
            let dof = &mut limits.dofs[excess.dof];
            let joint = dof.joint;
            let beyond = 1.5 * of_limit.iter().map(beyond).fold(0.0, f64::max);
            match excess.kind {
                Kind::Speed => dof.speed *= TIGHTER,
                Kind::Acceleration => dof.acceleration *= TIGHTER,
                Kind::Effort => dof.effort *= TIGHTER,
                Kind::Heat => {
                    dof.heat =
                        dof.heat.map(|heat| Heat { continuous: TIGHTER * heat.continuous, ..heat });
                }
                Kind::Range => {
                    let turn = limits.turns.iter_mut().find(|(body, _)| *body == joint);
                    if let Some((_, most_rad)) = turn {
                        *most_rad -= beyond;
                    } else {
                        dof.range = narrower(dof.range, beyond);
                    }
                }
                Kind::Following => {
                    // The limits themselves may be far above the motion.
                    let peaks = &report.peaks[excess.dof];
                    let value = of_limit.iter().map(|excess| excess.value).fold(0.0, f64::max);
                    let share = (excess.limit / value).clamp(TIGHTEST, TIGHTER);
                    dof.speed = share * dof.speed.min(peaks.speed);
                    dof.acceleration = share * dof.acceleration.min(peaks.acceleration);
                    let effort = share * dof.effort.min(peaks.effort);
                    dof.effort = effort.max(dof.effort.min(ABOVE_WEIGHT * peaks.effort_rms));
                }
                Kind::LinkedRange => {
                    for linked in limits.linked.iter_mut().filter(|linked| linked.body == joint) {
                        linked.range = narrower(linked.range, beyond);
                    }
                }
            }
        }
        limits
    }
}

/// Moves both ends of a range towards its middle; equal ends are unchanged.
fn narrower([least, most]: [f64; 2], by: f64) -> [f64; 2] {
    let by = by.min(0.4 * (most - least));
    [least + by, most - by]
}

fn range(link: &Link, axis: usize) -> [f64; 2] {
    match link.joint {
        JointModel::Revolute(_) | JointModel::Prismatic(_) | JointModel::Universal(_) => {
            link.ranges.get(axis).copied().unwrap_or([f64::NEG_INFINITY, f64::INFINITY])
        }
        _ => [f64::NEG_INFINITY, f64::INFINITY],
    }
}
