//! The pose that the board commands: the measured pose and its offsets.

use crate::TelemetryLog;

/// Returns the commanded pose of a rig with this number of dofs, or `None` while torque is off, or if the board does not
/// send its targets. `blocks`: first coordinate and number of coordinates of each joint.
pub fn commanded_pose(
    blocks: &[(usize, usize)],
    dofs: usize,
    log: &TelemetryLog,
) -> Option<Vec<f32>> {
    log.summary?.errors?;
    let coordinates = blocks.last().map_or(0, |(first, count)| first + count);
    let is_whole = log.q.len() == coordinates && log.targets.len() == dofs;
    is_whole.then(|| add(blocks, &log.q, &log.targets))
}

/// Adds offsets by dof to a pose. A ball joint has four coordinates, and its offset is a rotation vector in its body's
/// axes.
fn add(blocks: &[(usize, usize)], pose: &[f32], offsets: &[f32]) -> Vec<f32> {
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

/// Returns a unit quaternion (x y z w) times the exponential of a rotation vector.
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
    fn offsets_are_added_by_joint() {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let pose = [0.5, half, 0.0, 0.0, half, -0.1];
        let quarter = std::f32::consts::FRAC_PI_2;
        let q = add(&[(0, 0), (0, 1), (1, 4), (5, 1)], &pose, &[0.25, quarter, 0.0, 0.0, 0.1]);
        let expected = [0.75, 1.0, 0.0, 0.0, 0.0, 0.0];
        assert!(q.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{q:?}");
    }
}
