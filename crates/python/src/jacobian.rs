//! Jacobians of points of a rig.

use glam::DVec3;
use sinew_rig::Mechanism;
use sinew_rig::mechanism::Pose;

/// Returns, for each dof at unit speed, the linear and angular velocity of a point of a body, in world axes.
pub(crate) fn columns(
    mechanism: &Mechanism,
    q: &[f64],
    body: usize,
    point_m: DVec3,
) -> Vec<[DVec3; 2]> {
    let poses = mechanism.poses(q);
    let point_m = poses[body].point(point_m);
    let ranges = mechanism.coordinate_ranges();
    let mut columns = Vec::new();
    for (joint, (link, range)) in mechanism.bodies.iter().zip(ranges).enumerate() {
        let Pose { rotation, position_m } = poses[joint];
        let (turns, slides) = link.joint.axes(&q[range]);
        let moves = mechanism.supports(joint, body);
        let column = |linear: DVec3, angular: DVec3| {
            if moves { [linear, angular] } else { [DVec3::ZERO; 2] }
        };
        columns.extend(turns.into_iter().map(|axis| {
            let axis = rotation * axis;
            column(axis.cross(point_m - position_m), axis)
        }));
        columns.extend(slides.into_iter().map(|axis| column(rotation * axis, DVec3::ZERO)));
    }
    columns
}
