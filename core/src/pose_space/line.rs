//! The spatial length of the straight line between two poses, computed for four of its points at a time.
#![expect(
    clippy::inline_always,
    reason = "without inlining, vectors pass through memory: a third slower"
)]

use glam::{Quat, Vec3};

use super::{JointCoordinates, PoseCoordinates, PoseSpace, chart};
use crate::joint::JointKind;
use crate::kinematics::of_parent;
use crate::math::{self, Four};
use crate::transform::Transform;
use crate::tree::Body;

impl<const N: usize> PoseSpace<'_, N> {
    /// Returns the geodesic-line distance: the length of F along the straight line in coordinates from one pose to
    /// another, m, sampled in `steps` equal steps. O(n) for each step. With no steps the result is 0.
    ///
    /// This is eq. (4) of the paper, over the line of its section 2.2; every joint takes the shorter way round. Along
    /// the line, bones keep their lengths. In exact arithmetic the result is never below [`Self::position_distance`].
    /// The paper's formula for the points of the line exchanges the weights of the two ends; this function uses the
    /// correct weights.
    pub fn line_distance(
        &self,
        a: &PoseCoordinates<N>,
        b: &PoseCoordinates<N>,
        steps: u16,
        workspace: &mut LineWorkspace<N>,
    ) -> f32 {
        if steps == 0 {
            return 0.0;
        }
        let bodies = self.tree.bodies().iter().zip(workspace.bodies.iter_mut());
        for (index, ((body, of_line), (a, b))) in
            bodies.zip(a.joints.iter().zip(&b.joints)).enumerate()
        {
            // The rotation of a leaf moves no joint.
            let turns = !self.tree.is_leaf(index);
            if self.leaves_out(body) {
                *of_line = LineSample::WORLD;
            } else {
                let (start, step) = chart::way(body.joint, a, b);
                of_line.start(body, turns, &start, &step);
            }
        }
        let share = 1.0 / f32::from(steps);
        let mut length_m = 0.0;
        let mut first = 0;
        while first <= steps {
            // Points after the end repeat the last point and add no length.
            let t = Four::from_fn(|lane| f32::from(first.saturating_add(lane).min(steps)) * share);
            let squared = self.four_steps(t, first == 0, workspace);
            length_m += squared.sqrt_sum();
            let Some(next) = first.checked_add(4) else { break };
            first = next;
        }
        length_m
    }

    /// Returns the squared lengths of the steps to four points, each from the point before it. The first point of the
    /// line has no point before it.
    fn four_steps(&self, t: Four, is_first: bool, workspace: &mut LineWorkspace<N>) -> Four {
        let mut squared = Four::ZERO;
        for (index, (body, weight)) in self.weighted().enumerate() {
            let parent = *of_parent(body, &workspace.bodies, &LineSample::WORLD);
            let Some(of_line) = workspace.bodies.get_mut(index) else { break };
            of_line.place(body, &parent, t);
            let [x, y, z] = of_line.position_m;
            let before = if is_first { [x.first(), y.first(), z.first()] } else { of_line.last_m };
            let [dx, dy, dz] =
                [x - x.after(before[0]), y - y.after(before[1]), z - z.after(before[2])];
            squared = squared + (dx * dx + dy * dy + dz * dz) * Four::all(weight);
            of_line.last_m = [x.last(), y.last(), z.last()];
        }
        squared
    }
}

/// Scratch memory of [`PoseSpace::line_distance`], for rigs of capacity `N`.
#[derive(Debug, Clone, PartialEq)]
pub struct LineWorkspace<const N: usize> {
    bodies: [LineSample; N],
}

impl<const N: usize> LineWorkspace<N> {
    /// Creates a workspace.
    pub fn new() -> Self {
        Self { bodies: [LineSample::WORLD; N] }
    }
}

impl<const N: usize> Default for LineWorkspace<N> {
    fn default() -> Self {
        Self::new()
    }
}

/// A body on the line: start and step of its joint, and the body's poses at four points.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LineSample {
    /// Half the rotation vector, without the placement of the joint.
    half_rad: Vec3,
    half_step_rad: Vec3,
    offset_m: Vec3,
    offset_step_m: Vec3,
    placement: Quat,
    is_held: bool,
    turns: bool,
    /// Quaternion components x, y, z, w.
    rotation: [Four; 4],
    position_m: [Four; 3],
    /// Position at the point before the four.
    last_m: [f32; 3],
}

impl LineSample {
    const WORLD: Self = Self {
        half_rad: Vec3::ZERO,
        half_step_rad: Vec3::ZERO,
        offset_m: Vec3::ZERO,
        offset_step_m: Vec3::ZERO,
        placement: Quat::IDENTITY,
        is_held: true,
        turns: false,
        rotation: [Four::ZERO, Four::ZERO, Four::ZERO, Four::ONE],
        position_m: [Four::ZERO; 3],
        last_m: [0.0; 3],
    };

    fn start(
        &mut self,
        body: &Body,
        turns: bool,
        from: &JointCoordinates,
        step: &JointCoordinates,
    ) {
        let Transform { rotation: placement, translation_m } = body.placement;
        self.half_rad = from.angular_rad * 0.5;
        self.half_step_rad = step.angular_rad * 0.5;
        self.offset_m = translation_m + math::rotate(placement, from.linear_m);
        self.offset_step_m = math::rotate(placement, step.linear_m);
        self.placement = placement;
        self.is_held = false;
        self.turns = turns;
    }

    /// Places the body at four points of the line. The parent must already be placed.
    fn place(&mut self, body: &Body, parent: &Self, t: Four) {
        if self.is_held {
            return;
        }
        let on_line = |from: Vec3, step: Vec3| {
            [(from.x, step.x), (from.y, step.y), (from.z, step.z)]
                .map(|(from, step)| Four::all(from) + t * Four::all(step))
        };
        let offset = rotate(parent.rotation, on_line(self.offset_m, self.offset_step_m));
        let [x, y, z] = parent.position_m;
        self.position_m = [x + offset[0], y + offset[1], z + offset[2]];
        if !self.turns {
            return;
        }
        let half_rad = on_line(self.half_rad, self.half_step_rad);
        let turn = if let JointKind::Universal { first, second } = body.joint {
            let about = |axis: Vec3| {
                let axis = axis.to_array().map(Four::all);
                let angle = dot(axis, half_rad);
                exp_of_half(axis.map(|x| x * angle))
            };
            times(about(first), about(second))
        } else {
            exp_of_half(half_rad)
        };
        let turn = if self.placement == Quat::IDENTITY {
            turn
        } else {
            times(self.placement.to_array().map(Four::all), turn)
        };
        self.rotation = times(parent.rotation, turn);
    }
}

/// Returns the exponential map of four rotation vectors, given as halves of at most π.
#[inline(always)]
fn exp_of_half(half_rad: [Four; 3]) -> [Four; 4] {
    let (scale, w) = math::sine_over_angle_and_cosine(dot(half_rad, half_rad));
    let [x, y, z] = half_rad;
    [x * scale, y * scale, z * scale, w]
}

#[inline]
fn dot(a: [Four; 3], b: [Four; 3]) -> Four {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
fn cross(a: [Four; 3], b: [Four; 3]) -> [Four; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns products of quaternions.
#[inline(always)]
fn times(a: [Four; 4], b: [Four; 4]) -> [Four; 4] {
    let [ax, ay, az, aw] = a;
    let [bx, by, bz, bw] = b;
    [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}

/// Returns vectors rotated by unit quaternions, like [`math::rotate`].
#[inline(always)]
fn rotate(q: [Four; 4], v: [Four; 3]) -> [Four; 3] {
    let [x, y, z, w] = q;
    let [tx, ty, tz] = cross([x, y, z], v.map(|v| v + v));
    let [cx, cy, cz] = cross([x, y, z], [tx, ty, tz]);
    let [vx, vy, vz] = v;
    [vx + tx * w + cx, vy + ty * w + cy, vz + tz * w + cz]
}
