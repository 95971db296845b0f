//! Poses of the bodies for given joint coordinates.

use super::{Link, Mechanism, Pose};

impl Mechanism {
    /// Returns the number of joint coordinates, which is the length of `q`.
    pub fn coordinate_count(&self) -> usize {
        self.bodies.iter().map(|link| link.joint.kind().coordinate_count()).sum()
    }

    /// Returns the range of each joint's coordinates in `q`.
    pub fn coordinate_ranges(&self) -> Vec<std::ops::Range<usize>> {
        let mut end = 0;
        let of_link = |link: &Link| {
            let start = end;
            end += link.joint.kind().coordinate_count();
            start..end
        };
        self.bodies.iter().map(of_link).collect()
    }

    /// Returns the pose of each body in its parent's frame; the pose of the base is in the world. `q` is ordered as
    /// [`Mechanism::home`]; missing numbers count as zero. O(n).
    pub fn joint_poses<'a>(&'a self, q: &'a [f64]) -> impl Iterator<Item = Pose> + 'a {
        self.bodies.iter().zip(self.coordinate_ranges()).map(|(link, range)| {
            let moved = link.joint.motion(q.get(range).unwrap_or_default());
            let joint = Pose { rotation: link.rotation, position_m: link.position_m };
            Pose {
                rotation: joint.rotation * moved.rotation,
                position_m: joint.point(moved.position_m),
            }
        })
    }

    /// Returns the world poses of the bodies. `q` is ordered as [`Mechanism::home`]; missing numbers count as zero.
    /// O(n).
    pub fn poses(&self, q: &[f64]) -> Vec<Pose> {
        let mut poses: Vec<Pose> = Vec::with_capacity(self.bodies.len());
        for (link, pose) in self.bodies.iter().zip(self.joint_poses(q)) {
            let pose = match link.parent.and_then(|parent| poses.get(parent)) {
                Some(parent) => parent.child(pose.position_m, pose.rotation),
                None => pose,
            };
            poses.push(pose);
        }
        poses
    }

    /// Returns whether joint `joint` moves body `body`: the support κ of the body contains the joint. O(depth).
    pub fn supports(&self, joint: usize, body: usize) -> bool {
        let up = |body: &usize| self.bodies.get(*body).and_then(|link| link.parent);
        std::iter::successors(Some(body), up).any(|body| body == joint)
    }
}
