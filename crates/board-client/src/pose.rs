//! Poses of a rig as coordinates and as positions of dofs. The board's commanded pose is computed from the measured
//! pose and the offsets in the telemetry.

use crate::TelemetryLog;

/// Returns the commanded pose of a rig with `dofs` dofs. Returns `None` while torque is off, or if the telemetry lacks
/// offsets of some dofs. `blocks`: first coordinate and number of coordinates of each joint.
pub fn commanded(blocks: &[(usize, usize)], dofs: usize, log: &TelemetryLog) -> Option<Vec<f32>> {
    log.summary?.errors?;
    let coordinates = blocks.last().map_or(0, |(first, count)| first + count);
    let is_whole = log.q.len() == coordinates && log.targets.len() == dofs;
    is_whole.then(|| with_offsets(blocks, &log.q, &log.targets))
}

/// Returns a pose plus one offset for each dof. A ball joint has four coordinates; its three offsets are a rotation
/// vector in its body's axes.
pub fn with_offsets(blocks: &[(usize, usize)], pose: &[f32], offsets: &[f32]) -> Vec<f32> {
    let mut q = pose.to_vec();
    let mut offsets = offsets.iter().copied();
    for (first, count) in blocks {
        let own = &mut q[*first..*first + *count];
        if let [x, y, z, w] = own {
            let turn = [0; 3].map(|_| offsets.next().unwrap_or_default());
            [*x, *y, *z, *w] = turned([*x, *y, *z, *w], turn);
        } else {
            own.iter_mut().zip(&mut offsets).for_each(|(q, offset)| *q += offset);
        }
    }
    q
}

/// Returns the positions of a pose's dofs. The positions of a ball joint are its rotation vector.
pub fn of_dofs(blocks: &[(usize, usize)], pose: &[f32]) -> Vec<f32> {
    let mut dofs = Vec::new();
    for (first, count) in blocks {
        let own = &pose[*first..*first + *count];
        if let [x, y, z, w] = *own {
            // Both signs of a quaternion are the same rotation: the shorter way counts.
            let sign = if w < 0.0 { -1.0 } else { 1.0 };
            let sine = (x * x + y * y + z * z).sqrt();
            let angle = 2.0 * sine.atan2(sign * w);
            let part = if sine > 1e-9 { sign * angle / sine } else { 2.0 * sign };
            dofs.extend([x, y, z].map(|axis| part * axis));
        } else {
            dofs.extend(own);
        }
    }
    dofs
}

/// Returns the product of a unit quaternion (x y z w) and the exponential of a rotation vector.
fn turned([ax, ay, az, aw]: [f32; 4], turn: [f32; 3]) -> [f32; 4] {
    let angle = turn.iter().map(|x| x * x).sum::<f32>().sqrt();
    let part = if angle > 1e-9 { (0.5 * angle).sin() / angle } else { 0.5 };
    let ([bx, by, bz], bw) = (turn.map(|x| part * x), (0.5 * angle).cos());
    [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dofs_of_a_pose_lead_to_the_pose() {
        let blocks = [(0, 0), (0, 1), (1, 4), (5, 1)];
        let rest = [0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let turns = [0.3, 0.5, -1.0, 2.0, -0.2];
        let pose = with_offsets(&blocks, &rest, &turns);
        let near = |a: &[f32]| a.iter().zip(turns).all(|(a, b)| (a - b).abs() < 1e-5);
        assert!(near(&of_dofs(&blocks, &pose)));
        let other: Vec<f32> = pose
            .iter()
            .enumerate()
            .map(|(k, x)| if (1..5).contains(&k) { -x } else { *x })
            .collect();
        assert!(near(&of_dofs(&blocks, &other)));
        assert!(of_dofs(&blocks, &rest).iter().all(|x| x.abs() < 1e-6));
    }

    #[test]
    fn offsets_are_added_by_joint() {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let pose = [0.5, half, 0.0, 0.0, half, -0.1];
        let quarter = std::f32::consts::FRAC_PI_2;
        let q =
            with_offsets(&[(0, 0), (0, 1), (1, 4), (5, 1)], &pose, &[0.25, quarter, 0.0, 0.0, 0.1]);
        let expected = [0.75, 1.0, 0.0, 0.0, 0.0, 0.0];
        assert!(q.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{q:?}");
    }
}
