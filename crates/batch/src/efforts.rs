//! Efforts of a tree at several instants.

use std::ops::Range;

use glam::Vec3;
use sinew_core::{Body, GRAVITY_M_S2, JointKind, math};

use crate::joint::{Coordinates, Motion, Numbers, in_joint, of_lane, slides};
use crate::sweep::Moving;
use crate::widest::{Work, widest};

/// Number of instants, or of distances, that are computed at once: the widest vector registers hold this number of f32.
pub const LANES: usize = 16;

/// Largest number that the core accepts.
const LARGEST: f32 = 1e6;

/// Farthest squared length of a quaternion from 1 that the core accepts.
pub(crate) const FARTHEST_FROM_UNIT: f32 = 2e-3;

/// A calculator of efforts of a tree at [`LANES`] instants at once, with its buffers.
///
/// Each slice of coordinates contains the values of the first coordinate at all instants, then those of the next
/// coordinate, in the order of `sinew_core::coordinates`.
#[derive(Debug)]
pub struct Batch {
    bodies: Vec<Body>,
    /// Ranges of each body in `q` and in `qd`.
    ranges: Vec<[Range<usize>; 2]>,
    joints: Vec<Motion<LANES>>,
    /// Motions of the world and of the bodies.
    moving: Vec<Moving<LANES>>,
    efforts: Vec<Numbers>,
}

impl Batch {
    /// Creates a calculator for the bodies of a valid tree. O(bodies).
    pub fn new(bodies: &[Body]) -> Self {
        let mut ends = [0, 0];
        let range = |body: &Body| {
            let [q, qd] = ends;
            ends = [q + body.joint.coordinate_count(), qd + body.joint.dof_count()];
            [q..ends[0], qd..ends[1]]
        };
        Self {
            ranges: bodies.iter().map(range).collect(),
            joints: bodies.iter().map(Motion::at_rest).collect(),
            moving: vec![Moving::falling(GRAVITY_M_S2); bodies.len() + 1],
            efforts: vec![[0.0; LANES]; ends[1]],
            bodies: bodies.to_vec(),
        }
    }

    /// Returns whether the core accepts these positions, speeds and accelerations at all instants. O(n).
    pub fn takes(&self, motion: [&[Numbers]; 3]) -> bool {
        let [nq, nv] = self.ranges.last().map_or([0; 2], |ends| ends.each_ref().map(|end| end.end));
        motion.map(<[_]>::len) == [nq, nv, nv] && widest(Takes { batch: self, motion })
    }

    /// Returns the efforts along the dofs, N m or N, including rotors and without friction, for positions, speeds and
    /// accelerations that [`Self::takes`] accepts; for others, any numbers. O(n).
    ///
    /// # Panics
    /// If the slices do not fit the tree.
    pub fn efforts(&mut self, motion: [&[Numbers]; 3]) -> &[Numbers] {
        widest(Efforts { batch: self, motion });
        &self.efforts
    }

    /// Returns the efforts, computed with these instructions.
    #[cfg(test)]
    pub(crate) fn efforts_with(
        &mut self,
        instructions: crate::widest::Instructions,
        motion: [&[Numbers]; 3],
    ) -> &[Numbers] {
        instructions.run(Efforts { batch: self, motion });
        &self.efforts
    }
}

struct Takes<'a> {
    batch: &'a Batch,
    motion: [&'a [Numbers]; 3],
}

impl Work for Takes<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let Self { batch, motion } = self;
        let mut takes = true;
        for numbers in motion.into_iter().flatten() {
            for number in numbers {
                // The comparison also excludes NaN.
                takes &= number.abs() <= LARGEST;
            }
        }
        for [of_q, _] in &batch.ranges {
            let [x, y, z, w, ..] = &motion[0][of_q.clone()] else { continue };
            for lane in 0..LANES {
                let [x, y, z, w] = [x[lane], y[lane], z[lane], w[lane]];
                let squared = x * x + y * y + z * z + w * w;
                takes &= (squared - 1.0).abs() <= FARTHEST_FROM_UNIT;
            }
        }
        takes
    }
}

struct Efforts<'a> {
    batch: &'a mut Batch,
    motion: [&'a [Numbers]; 3],
}

impl Work for Efforts<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { batch: Batch { bodies, ranges, joints, moving, efforts }, motion } = self;
        let of_body = |[of_q, of_qd]: &[Range<usize>; 2]| -> Coordinates<'_> {
            let [q, qd, qdd] = motion;
            [&q[of_q.clone()], &qd[of_qd.clone()], &qdd[of_qd.clone()]]
        };
        for (index, (body, joint)) in bodies.iter().zip(joints.iter_mut()).enumerate() {
            joint.set(body, of_body(&ranges[index]));
            let (above, below) = moving.split_at_mut(index + 1);
            let parent = &above[body.parent.map_or(0, |parent| parent + 1)];
            below[0].follow(parent, joint, slides(body.joint), &body.inertia);
        }
        for (index, (body, joint)) in bodies.iter().zip(joints.iter()).enumerate().rev() {
            let (above, below) = moving.split_at_mut(index + 1);
            let moving = &mut below[0];
            if let Some(parent) = body.parent {
                above[parent + 1].carry(moving, joint);
            }
            if body.rotor_inertia > 0.0 {
                moving.add_rotor(joint, slides(body.joint), body.rotor_inertia);
            }
            let out = &mut efforts[ranges[index][1].clone()];
            match (body.joint, out) {
                (JointKind::Fixed, _) => {}
                (JointKind::Revolute { axis }, [out]) => {
                    for lane in 0..LANES {
                        out[lane] = 0.0 + axis.dot(moving.moment.at(lane));
                    }
                }
                (JointKind::Spherical, [x, y, z]) => {
                    for lane in 0..LANES {
                        // The core adds to zero, which converts -0 to 0.
                        let along = Vec3::ZERO + moving.moment.at(lane);
                        (x[lane], y[lane], z[lane]) = (along.x, along.y, along.z);
                    }
                }
                (_, out) => along_columns(body, of_body(&ranges[index])[0], moving, out),
            }
        }
    }
}

/// Projects a moment and a force onto the axes of a joint of any kind, one instant after the other.
#[inline(never)]
fn along_columns(body: &Body, q: &[Numbers], moving: &Moving<LANES>, out: &mut [Numbers]) {
    for lane in 0..LANES {
        let (moment, force) = (moving.moment.at(lane), moving.force.at(lane));
        let (q, still) = (of_lane(q, lane), [0.0; 6]);
        let (q, still) = (&q[..body.joint.coordinate_count()], &still[..out.len()]);
        let state = body.joint.state(body.placement, q, still).unwrap_or_default();
        let columns = body.joint.motion_subspace(in_joint(body, math::unit(state.pose.rotation)));
        for (out, column) in out.iter_mut().zip(&columns) {
            out[lane] = column.angular.dot(moment) + column.linear.dot(force);
        }
    }
}
