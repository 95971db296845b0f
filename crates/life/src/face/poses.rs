//! Shapes of a rig as offsets of joints from home, and the limits of these joints.

use sinew_rig::Mechanism;
use sinew_rig::description::FaceShape;
use sinew_rig::mechanism::JointModel;

use super::names::is_same;

/// Distance that motions keep from the ends of a range: 0.3 deg in rad, which is more than a show's error; for slides,
/// m.
const MARGIN_RAD: f64 = 0.3 * std::f64::consts::PI / 180.0;
const MARGIN_M: f64 = 1e-4;

/// A joint that at least one shape moves.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MovedJoint {
    pub(super) name: String,
    pub(super) body: usize,
    /// Whether positions are in m.
    pub(super) slides: bool,
    pub(super) home: f64,
    /// Range of positions that the motion may use, with a margin.
    pub(super) range: [f64; 2],
    /// Largest offset from home in all shapes. Offsets are divided by it to compare joints.
    pub(super) scale: f64,
    pub(super) speed: f64,
    pub(super) acceleration: f64,
}

/// A limit on two moved joints: `factors[0] · q[joints[0]] + factors[1] · q[joints[1]]` must be within `range`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Linked {
    joints: [usize; 2],
    factors: [f64; 2],
    range: [f64; 2],
}

/// Shapes of a rig, and the joints that they move.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Poses {
    pub(super) joints: Vec<MovedJoint>,
    /// Name of each shape with a pose, and its offsets of all joints from home.
    pub(super) shapes: Vec<(String, Vec<f64>)>,
    linked: Vec<Linked>,
}

impl Poses {
    /// Collects all shapes with a pose, and the joints in these poses.
    pub(super) fn of(mechanism: &Mechanism, shapes: &[FaceShape]) -> Self {
        let starts = mechanism.coordinate_ranges();
        let home = mechanism.home();
        let mut joints: Vec<MovedJoint> = Vec::new();
        for (name, _) in shapes.iter().flat_map(|shape| &shape.pose) {
            let body = mechanism.bodies.iter().position(|link| link.joint_name == *name);
            let Some(body) = body.filter(|_| joints.iter().all(|joint| joint.name != *name)) else {
                continue;
            };
            let link = &mechanism.bodies[body];
            let slides = matches!(link.joint, JointModel::Prismatic(_));
            let margin = if slides { MARGIN_M } else { MARGIN_RAD };
            let [least, most] = link.ranges.first().copied().unwrap_or([-1e3, 1e3]);
            let margin = margin.min(0.1 * (most - least));
            joints.push(MovedJoint {
                name: name.clone(),
                body,
                slides,
                home: home[starts[body].start],
                range: [least + margin, most - margin],
                scale: 0.0,
                speed: link.speed,
                acceleration: link.acceleration,
            });
        }
        let mut poses: Vec<(String, Vec<f64>)> = Vec::new();
        for shape in shapes.iter().filter(|shape| !shape.pose.is_empty()) {
            let mut offsets = vec![0.0; joints.len()];
            for (name, position) in &shape.pose {
                let Some(at) = joints.iter().position(|joint| joint.name == *name) else {
                    continue;
                };
                offsets[at] = position - joints[at].home;
                joints[at].scale = f64::max(joints[at].scale, offsets[at].abs());
            }
            poses.push((shape.name.clone(), offsets));
        }
        let place = |body: usize| joints.iter().position(|joint| joint.body == body);
        let linked = mechanism.linked.iter().filter_map(|linked| {
            let joints_at = [place(linked.body)?, place(linked.other)?];
            let margin = if joints[joints_at[0]].slides { MARGIN_M } else { MARGIN_RAD };
            let [least, most] = linked.range;
            Some(Linked {
                joints: joints_at,
                factors: [linked.factor, linked.other_factor],
                range: [least + margin, most - margin],
            })
        });
        let linked = linked.collect();
        Self { joints, shapes: poses, linked }
    }

    /// Returns the index of the shape with a pose that a name in a file means.
    pub(super) fn find(&self, name: &str) -> Option<usize> {
        let exact = self.shapes.iter().position(|(own, _)| own == name);
        exact.or_else(|| self.shapes.iter().position(|(own, _)| is_same(own, name)))
    }

    /// Moves offsets into the ranges of the joints, and then into the limits on two joints. Returns whether an offset
    /// changed by more than twice the margin of a range.
    pub(super) fn hold(&self, offsets: &mut [f64]) -> bool {
        let given = offsets.to_vec();
        self.hold_ranges(offsets);
        for Linked { joints: [a, b], factors: [factor, other], range } in &self.linked {
            let sum = factor * (self.joints[*a].home + offsets[*a])
                + other * (self.joints[*b].home + offsets[*b]);
            let held = sum.max(range[0]).min(range[1]);
            let share = (held - sum) / (factor * factor + other * other);
            offsets[*a] += factor * share;
            offsets[*b] += other * share;
        }
        self.hold_ranges(offsets);
        let margin = |joint: &MovedJoint| if joint.slides { MARGIN_M } else { MARGIN_RAD };
        let mut moves = given.iter().zip(offsets).zip(&self.joints);
        moves.any(|((given, now), joint)| (*given - *now).abs() > 2.0 * margin(joint))
    }

    fn hold_ranges(&self, offsets: &mut [f64]) {
        for (joint, offset) in self.joints.iter().zip(offsets) {
            let [least, most] = joint.range;
            *offset = (joint.home + *offset).max(least).min(most) - joint.home;
        }
    }
}
