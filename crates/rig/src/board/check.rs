//! Checks that the parts of a rig fit each other.

use heapless::Vec;
use sinew_core::{JointKind, math};

use super::{BoardDrive, BoardRig, BoardRigError};
use crate::drive::Drive;

impl<const BODIES: usize, const DOFS: usize, const SERVOS: usize> BoardRig<BODIES, DOFS, SERVOS> {
    /// Checks that the parts of the rig fit each other.
    pub(super) fn check(&self) -> Result<(), BoardRigError> {
        if self.tree.is_empty() {
            return Err(BoardRigError::Count { what: "bodies", expected: 1, found: 0 });
        }
        let (expected, found) = (self.tree.dof_count(), self.dofs.len());
        if expected != found {
            return Err(BoardRigError::Count { what: "degrees of freedom", expected, found });
        }
        self.check_dofs()?;
        self.check_balls()?;
        self.check_limits()?;
        self.check_drives()?;
        for (index, servo) in self.servos.iter().enumerate() {
            let place = (servo.bus, servo.address);
            if self.servos.iter().take(index).any(|other| (other.bus, other.address) == place) {
                return Err(BoardRigError::Shared { what: "address of servo", index });
            }
        }
        Ok(())
    }

    fn check_dofs(&self) -> Result<(), BoardRigError> {
        for (index, dof) in self.dofs.iter().enumerate() {
            check_range("range of dof", index, dof.range)?;
            if !dof.home.is_finite() {
                return Err(BoardRigError::Number { what: "home of dof", index, found: dof.home });
            }
            for (what, found) in [
                ("speed of dof", dof.speed),
                ("acceleration of dof", dof.acceleration),
                ("effort of dof", dof.effort),
            ] {
                // NaN is not in the range either.
                if !(0.0..).contains(&found) {
                    return Err(BoardRigError::Number { what, index, found });
                }
            }
        }
        Ok(())
    }

    /// Checks that homes are within their ranges: each coordinate of a joint with axes, and the angle of a ball
    /// joint from its zero pose.
    fn check_balls(&self) -> Result<(), BoardRigError> {
        let mut first = 0_usize;
        for body in self.tree.bodies() {
            let count = body.joint.dof_count();
            let own = || self.dofs.iter().skip(first).take(count);
            let what = "home, beyond its range, of dof";
            if body.joint == JointKind::Spherical {
                let squares: f32 = own().map(|dof| dof.home * dof.home).sum();
                let (angle, most) =
                    (math::sqrt(squares), own().next().map_or(0.0, |dof| dof.range[1]));
                // Rounding of the three squares in f32 may lift the angle above the bound.
                if !(..=most * (1.0 + 4.0 * f32::EPSILON)).contains(&angle) {
                    return Err(BoardRigError::Number { what, index: first, found: angle });
                }
            } else {
                for (place, dof) in own().enumerate() {
                    let ([least, most], found) = (dof.range, dof.home);
                    if found < least || found > most {
                        let index = first.saturating_add(place);
                        return Err(BoardRigError::Number { what, index, found });
                    }
                }
            }
            first = first.saturating_add(count);
        }
        Ok(())
    }

    fn check_limits(&self) -> Result<(), BoardRigError> {
        for (index, limit) in self.limits.iter().enumerate() {
            for found in [limit.dof, limit.other].map(usize::from) {
                if found >= self.dofs.len() {
                    let (what, part) = ("limit", "dof");
                    return Err(BoardRigError::Index { what, index, part, found });
                }
            }
            if limit.dof == limit.other {
                return Err(BoardRigError::Shared { what: "dof of limit", index });
            }
            for found in [limit.factor, limit.other_factor] {
                if !found.is_finite() {
                    return Err(BoardRigError::Number { what: "factor of limit", index, found });
                }
            }
            check_range("range of limit", index, limit.range)?;
        }
        Ok(())
    }

    fn check_drives(&self) -> Result<(), BoardRigError> {
        let (mut dofs, mut servos) = (Vec::<u16, DOFS>::new(), Vec::<u16, SERVOS>::new());
        for (index, drive) in self.drives.iter().enumerate() {
            take(index, "dof", &drive.dofs, self.dofs.len(), &mut dofs)?;
            take(index, "servo", &drive.servos, self.servos.len(), &mut servos)?;
            for (what, expected, found) in [
                ("dofs of a drive", drive.drive.dofs(), drive.dofs.len()),
                ("servos of a drive", drive.drive.servos(), drive.servos.len()),
            ] {
                if expected != found {
                    return Err(BoardRigError::Count { what, expected, found });
                }
            }
            if !self.fits(drive) {
                return Err(BoardRigError::Joints { drive: index });
            }
        }
        Ok(())
    }

    /// Returns whether a drive moves whole joints: one ball joint, or joints with axes.
    fn fits(&self, drive: &BoardDrive) -> bool {
        let is_ball = matches!(&drive.drive, Drive::Matrix(matrix) if matrix.is_ball());
        let mut rest = &drive.dofs[..];
        while let Some(first) = rest.first() {
            let mut at = 0_usize;
            let joint = self.tree.bodies().iter().map(|body| body.joint).find(|joint| {
                let here = at;
                at = at.saturating_add(joint.dof_count());
                here == usize::from(*first) && joint.dof_count() > 0
            });
            let count = joint.map_or(0, JointKind::dof_count);
            let Some((own, behind)) = rest.split_at_checked(count) else { return false };
            let in_order = own.windows(2).all(|pair| match pair {
                [a, b] => a.checked_add(1) == Some(*b),
                _ => false,
            });
            let suits = match joint {
                Some(JointKind::Spherical) => is_ball,
                Some(
                    JointKind::Revolute { .. }
                    | JointKind::Prismatic { .. }
                    | JointKind::Universal { .. },
                ) => !is_ball,
                Some(JointKind::Fixed | JointKind::Free) | None => false,
            };
            if !(in_order && suits) {
                return false;
            }
            rest = behind;
        }
        true
    }
}

/// Marks dofs or servos as taken by a drive; fails if another drive has taken them.
fn take<const N: usize>(
    index: usize,
    part: &'static str,
    wanted: &[u16],
    count: usize,
    taken: &mut Vec<u16, N>,
) -> Result<(), BoardRigError> {
    for number in wanted {
        let found = usize::from(*number);
        if found >= count {
            return Err(BoardRigError::Index { what: "drive", index, part, found });
        }
        // The list has room for all parts; if it is full, some part was taken twice.
        if taken.contains(number) || taken.push(*number).is_err() {
            return Err(BoardRigError::Shared { what: part, index: found });
        }
    }
    Ok(())
}

fn check_range(
    what: &'static str,
    index: usize,
    [least, most]: [f32; 2],
) -> Result<(), BoardRigError> {
    // The comparison also refuses NaN.
    if least <= most { Ok(()) } else { Err(BoardRigError::Number { what, index, found: least }) }
}
