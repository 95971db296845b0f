//! The pose that a motion is drawn towards where gravity or heat needs too much effort.

use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;

use super::super::curve::Instant;
use super::super::efforts::Efforts;
use super::super::limits::Limits;
use super::within::Within;
use crate::feasibility::error::CheckError;

/// Maximum share of its effort limit that a joint may need at rest: the remainder is available for motion.
const LIGHT: f64 = 0.9;
/// First and last step of the search, rad or m.
const STEPS: [f64; 2] = [0.2, 0.003];

/// A rest pose with its holding efforts.
pub(super) struct Rest {
    pub(super) q: Vec<f64>,
    /// Holding effort of each dof, N m or N.
    pub(super) holding: Vec<f64>,
}

impl Rest {
    /// Returns the home pose. If home needs too much effort, returns a nearby pose that does not, or the lightest
    /// pose found: a pattern search joint by joint, O(n²) for each of a few dozen passes.
    pub(super) fn of(
        mechanism: &Mechanism,
        limits: &Limits,
        within: &mut Within,
    ) -> Result<Self, CheckError> {
        let mut efforts = Efforts::of(mechanism)?;
        let mut rest = Self { q: mechanism.home(), holding: Vec::new() };
        rest.hold(&mut efforts, limits)?;
        let mut step = STEPS[0];
        while rest.excess(limits) > 0.0 && step > STEPS[1] {
            if !rest.is_lighter_by(step, mechanism, limits, within, &mut efforts)? {
                step *= 0.5;
            }
        }
        Ok(rest)
    }

    /// Performs one pass: moves each joint by the step if the pose becomes lighter. Returns whether any joint
    /// moved.
    fn is_lighter_by(
        &mut self,
        step: f64,
        mechanism: &Mechanism,
        limits: &Limits,
        within: &mut Within,
        efforts: &mut Efforts,
    ) -> Result<bool, CheckError> {
        let mut is_lighter = false;
        for (link, numbers) in mechanism.bodies.iter().zip(mechanism.coordinate_ranges()) {
            if !matches!(link.joint, JointModel::Revolute(_) | JointModel::Prismatic(_)) {
                continue;
            }
            for by in [step, -step] {
                let mut other = Self { q: self.q.clone(), holding: Vec::new() };
                other.q[numbers.start] += by;
                within.bring(limits, &mut other.q);
                other.hold(efforts, limits)?;
                if other.excess(limits) < self.excess(limits) {
                    *self = other;
                    is_lighter = true;
                }
            }
        }
        Ok(is_lighter)
    }

    fn hold(&mut self, efforts: &mut Efforts, limits: &Limits) -> Result<(), CheckError> {
        let still = vec![0.0; limits.dofs.len()];
        let instant = Instant { q: self.q.clone(), qd: still.clone(), qdd: still };
        efforts
            .at(&instant, &mut self.holding)
            .map_err(|source| CheckError::Instant { time_s: 0.0, source })
    }

    /// Returns how much the efforts exceed the permitted share, as a sum of squares over the dofs; 0 if none does.
    fn excess(&self, limits: &Limits) -> f64 {
        let of_dofs = self.holding.iter().zip(&limits.dofs);
        of_dofs
            .map(|(held, limits)| (held.abs() / limits.effort - LIGHT).max(0.0))
            .map(|excess| excess * excess)
            .sum()
    }
}
