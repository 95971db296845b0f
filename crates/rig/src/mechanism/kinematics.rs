//! Where the bodies are, for given joint coordinates.

use super::{Link, Mechanism, Pose};

impl Mechanism {
    /// Number of joint coordinates: `q` has as many.
    pub fn coordinate_count(&self) -> usize {
        self.bodies.iter().map(|link| link.joint.kind().coordinate_count()).sum()
    }

    /// Where in `q` the coordinates of each joint are.
    pub fn coordinate_ranges(&self) -> Vec<std::ops::Range<usize>> {
        let mut end = 0;
        let of_link = |link: &Link| {
            let start = end;
            end += link.joint.kind().coordinate_count();
            start..end
        };
        self.bodies.iter().map(of_link).collect()
    }

    /// Poses of the bodies, each in its parent's frame, that of the base in the world. `q`: as [`Mechanism::home`];
    /// numbers that are not there count as zero. O(n).
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

    /// World poses of the bodies. `q`: as [`Mechanism::home`]; numbers that are not there count as zero. O(n).
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

    /// Whether joint `joint` moves body `body`: κ of the body has the joint. O(depth).
    pub fn supports(&self, joint: usize, body: usize) -> bool {
        let up = |body: &usize| self.bodies.get(*body).and_then(|link| link.parent);
        std::iter::successors(Some(body), up).any(|body| body == joint)
    }
}
