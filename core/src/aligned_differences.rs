//! Aligned targets of a performance that arrives frame by frame. Each step between two frames is computed once.

use crate::joint_targets::JointTargets;
use crate::pose_step::{rate, step};
use crate::state::{StateInputError, check_pose};
use crate::trajectory::put_difference;
use crate::transform::{Transform, Twist};

/// Computes the result of [`aligned_targets`](crate::trajectory::aligned_targets) for three frames, equal to the last
/// bit.
///
/// `steps` has one item for each joint. On entry it is the step from the first frame to the middle frame. On return it
/// is the step from the middle frame to the last frame, which the next call needs for the window one frame later.
pub(crate) fn advance<'s, const N: usize>(
    [_, now, next]: [&[Transform]; 3],
    dt_s: f32,
    steps: impl Iterator<Item = &'s mut Twist>,
    out: &mut JointTargets<N>,
) -> Result<(), StateInputError> {
    let rate_hz = rate(dt_s)?;
    for (joint, ((now, next), known)) in now.iter().zip(next).zip(steps).enumerate() {
        check_pose(next)?;
        let (first, second) = (*known, step(now, next, rate_hz));
        put_difference(out, joint, now, first, (second - first) * rate_hz)?;
        *known = second;
    }
    Ok(())
}

/// Computes the steps from the first frame to the middle frame, for a window that is not the previous window moved
/// on by one frame.
// Never inlined, because it is needed only at the start and after jumps.
#[inline(never)]
pub(crate) fn begin<'s>(
    [before, now, _]: [&[Transform]; 3],
    dt_s: f32,
    steps: impl Iterator<Item = &'s mut Twist>,
) -> Result<(), StateInputError> {
    let rate_hz = rate(dt_s)?;
    for ((before, now), slot) in before.iter().zip(now).zip(steps) {
        check_pose(before)?;
        check_pose(now)?;
        *slot = step(before, now, rate_hz);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::math;
    use crate::trajectory::aligned_targets;
    use crate::{Body, Inertia, JointKind, Tree};

    #[test]
    fn each_step_is_taken_once_and_nothing_else_changes() {
        let body = |parent| Body {
            parent,
            joint: if parent.is_none() { JointKind::Free } else { JointKind::Spherical },
            placement: Transform::IDENTITY,
            inertia: Inertia::default(),
            rotor_inertia: 0.0,
        };
        let tree = Tree::<2>::from_bodies(&[body(None), body(Some(0))]).unwrap();
        let frame = |t: f32| {
            [Vec3::new(t * t, 0.3, -t), Vec3::new(0.2, 1.0 - t, t * t * t)]
                .map(|v| Transform::new(math::exp(v), v * 0.5))
        };
        let frames = [0.0, 0.1, 0.2, 0.3, 0.4, 0.9, 1.1, 1.3].map(frame);
        let mut steps = [Twist::ZERO; 2];
        let (mut expected, mut found) = (JointTargets::rest(&tree), JointTargets::rest(&tree));
        // Three successive windows, then a jump and two more.
        for (at, first) in [0, 1, 2, 4, 5].into_iter().enumerate() {
            let window = [0, 1, 2].map(|k| &frames[first + k][..]);
            // At the start, and after a jump.
            if at == 0 || at == 3 {
                begin(window, 0.1, steps.iter_mut()).unwrap();
            }
            aligned_targets(window, 0.1, &mut expected).unwrap();
            advance(window, 0.1, steps.iter_mut(), &mut found).unwrap();
            assert_eq!(found, expected);
        }
        // Without `begin` after a jump, the first step would be that of the earlier frames.
        let jumped = [0, 1, 2].map(|k| &frames[k][..]);
        advance(jumped, 0.1, steps.iter_mut(), &mut found).unwrap();
        aligned_targets(jumped, 0.1, &mut expected).unwrap();
        assert_ne!(found, expected);
    }
}
