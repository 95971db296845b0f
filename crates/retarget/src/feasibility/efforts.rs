//! Efforts that a motion needs, from inverse dynamics and friction.

use sinew_core::TreeError;
use sinew_core::coordinates::CoordinatesError;
use sinew_rig::Mechanism;
use sinew_rig::mechanism::{InverseDynamics, LANES};

use super::curve::{Instant, Performance};
use super::error::CheckError;
use super::limits::{DofLimits, Limits};

/// A calculator of efforts with rotors and friction, which [`check`](super::check()) compares with limits.
#[derive(Debug)]
pub struct Efforts {
    dynamics: InverseDynamics,
    single: [Vec<f32>; 3],
    side_by_side: [Vec<[f32; LANES]>; 3],
    /// Friction of each dof: Coulomb friction, and viscous friction per speed.
    friction: Vec<[f64; 2]>,
    /// Whether any limit needs the efforts; if not, they are computed as friction alone.
    is_asked: bool,
}

impl Efforts {
    /// Creates a calculator for a rig. O(bodies · depth).
    ///
    /// # Errors
    /// [`TreeError`] if the rig exceeds the core's capacity.
    pub fn of(mechanism: &Mechanism) -> Result<Self, TreeError> {
        let of_link = |link: &sinew_rig::mechanism::Link| {
            let count = link.joint.kind().dof_count();
            std::iter::repeat_n([link.friction, link.damping], count)
        };
        Ok(Self {
            dynamics: InverseDynamics::of(mechanism)?,
            single: [vec![], vec![], vec![]],
            side_by_side: [vec![], vec![], vec![]],
            friction: mechanism.bodies.iter().flat_map(of_link).collect(),
            is_asked: true,
        })
    }

    /// Creates a calculator for a comparison with limits. Without a limit of effort or heat, it computes no
    /// dynamics.
    pub(super) fn asked_by(mechanism: &Mechanism, limits: &Limits) -> Result<Self, TreeError> {
        let asks = |limits: &DofLimits| limits.effort.is_finite() || limits.heat.is_some();
        Ok(Self { is_asked: limits.dofs.iter().any(asks), ..Self::of(mechanism)? })
    }

    /// Returns the effort of Coulomb friction of a dof at a speed, N m or N. Below 0.01 rad/s (or m/s) the effort is
    /// proportional to the speed, so that a joint at rest has no friction.
    pub fn dry_friction(&self, dof: usize, speed: f64) -> f64 {
        let [dry, _] = self.friction[dof];
        dry * (speed / 0.01).clamp(-1.0, 1.0)
    }

    /// Returns the effort of viscous friction of a dof, N m or N.
    pub(super) fn viscous_friction(&self, dof: usize, speed: f64) -> f64 {
        let [_, viscous] = self.friction[dof];
        viscous * speed
    }

    /// Computes the efforts along the dofs, including the joints' friction, N m or N. O(n).
    ///
    /// # Errors
    /// [`CoordinatesError`] if the instant is invalid for the rig.
    pub fn at(&mut self, instant: &Instant, out: &mut Vec<f64>) -> Result<(), CoordinatesError> {
        self.without_friction([&instant.q, &instant.qd, &instant.qdd], out)?;
        for (dof, (effort, speed)) in out.iter_mut().zip(&instant.qd).enumerate() {
            *effort += self.dry_friction(dof, *speed) + self.viscous_friction(dof, *speed);
        }
        Ok(())
    }

    /// Computes the efforts without friction. `motion`: positions, speeds and accelerations.
    pub(super) fn without_friction(
        &mut self,
        motion: [&[f64]; 3],
        out: &mut Vec<f64>,
    ) -> Result<(), CoordinatesError> {
        for (single, wide) in self.single.iter_mut().zip(motion) {
            single.clear();
            #[expect(clippy::cast_possible_truncation, reason = "the core computes in f32")]
            single.extend(wide.iter().map(|x| *x as f32));
        }
        let [q, qd, qdd] = &self.single;
        let efforts = self.dynamics.efforts(q, qd, qdd)?;
        out.clear();
        out.extend(efforts.iter().map(|effort| f64::from(*effort)));
        Ok(())
    }

    /// Computes the efforts without friction for several instants at once, which is faster.
    fn side_by_side(
        &mut self,
        motions: &[[&[f64]; 3]; LANES],
        out: &mut [Vec<f64>; LANES],
    ) -> Result<(), CoordinatesError> {
        if !self.is_asked {
            for out in out {
                out.clear();
                out.resize(self.friction.len(), 0.0);
            }
            return Ok(());
        }
        for (kind, side_by_side) in self.side_by_side.iter_mut().enumerate() {
            let count = motions[0][kind].len();
            side_by_side.resize(count, [0.0; LANES]);
            for (lane, motion) in motions.iter().enumerate() {
                #[expect(clippy::cast_possible_truncation, reason = "the core computes in f32")]
                for (of_lanes, wide) in side_by_side.iter_mut().zip(motion[kind]) {
                    of_lanes[lane] = *wide as f32;
                }
            }
        }
        let [q, qd, qdd] = &self.side_by_side;
        let efforts = self.dynamics.efforts_side_by_side(q, qd, qdd)?;
        for (lane, out) in out.iter_mut().enumerate() {
            out.clear();
            out.extend(efforts.iter().map(|of_lanes| f64::from(of_lanes[lane])));
        }
        Ok(())
    }

    /// Computes the efforts with friction for instants at these times.
    pub(super) fn of_instants(
        &mut self,
        times_s: [f64; LANES],
        instants: [&Instant; LANES],
        out: &mut [Vec<f64>; LANES],
    ) -> Result<(), CheckError> {
        let motions = instants.map(|Instant { q, qd, qdd }| [&q[..], qd, qdd]);
        self.of_motions(times_s, &motions, out)?;
        for (instant, efforts) in instants.into_iter().zip(out) {
            for (dof, (effort, speed)) in efforts.iter_mut().zip(&instant.qd).enumerate() {
                *effort += self.dry_friction(dof, *speed) + self.viscous_friction(dof, *speed);
            }
        }
        Ok(())
    }

    /// Computes the efforts without friction for positions, speeds and accelerations at these times.
    fn of_motions(
        &mut self,
        times_s: [f64; LANES],
        motions: &[[&[f64]; 3]; LANES],
        out: &mut [Vec<f64>; LANES],
    ) -> Result<(), CheckError> {
        if self.side_by_side(motions, out).is_err() {
            // Computing one instant after the other finds the invalid one.
            for ((time_s, motion), out) in times_s.into_iter().zip(motions).zip(out) {
                self.without_friction(*motion, out)
                    .map_err(|source| CheckError::Instant { time_s, source })?;
            }
        }
        Ok(())
    }
}

/// Consecutive instants of a performance, with their efforts.
#[derive(Debug, Default)]
pub(super) struct Block {
    /// Number of instants; the other places repeat the last one.
    pub(super) count: usize,
    pub(super) times_s: [f64; LANES],
    pub(super) instants: [Instant; LANES],
    pub(super) efforts: [Vec<f64>; LANES],
}

impl Block {
    /// Reads the performance at the next of these times, still without efforts. Returns whether there were any
    /// times.
    pub(super) fn next(
        &mut self,
        performance: &impl Performance,
        times_s: &mut impl Iterator<Item = f64>,
    ) -> bool {
        self.count = 0;
        for (time_s, instant) in times_s.take(LANES).zip(&mut self.instants) {
            performance.at(time_s, instant);
            self.times_s[self.count] = time_s;
            self.count += 1;
        }
        if let Some(last) = self.count.checked_sub(1) {
            let (taken, rest) = self.instants.split_at_mut(self.count);
            for instant in rest {
                instant.clone_from(&taken[last]);
            }
        }
        self.count > 0
    }

    /// Returns time, motion and efforts of each instant.
    pub(super) fn each(&self) -> impl Iterator<Item = (f64, &Instant, &[f64])> {
        let motions = self.times_s.iter().zip(&self.instants).take(self.count);
        motions
            .zip(&self.efforts)
            .map(|((time_s, instant), efforts)| (*time_s, instant, &efforts[..]))
    }

    /// Computes the efforts, with friction.
    pub(super) fn find_efforts(&mut self, efforts: &mut Efforts) -> Result<(), CheckError> {
        let instants = self.instants.each_ref();
        efforts.of_instants(self.times_s, instants, &mut self.efforts)
    }

    /// Computes the efforts without friction.
    pub(super) fn find_without_friction(
        &mut self,
        efforts: &mut Efforts,
    ) -> Result<(), CheckError> {
        let motions = self.instants.each_ref().map(|Instant { q, qd, qdd }| [&q[..], qd, qdd]);
        efforts.of_motions(self.times_s, &motions, &mut self.efforts)
    }

    /// Computes the efforts that hold the poses of the instants.
    pub(super) fn holding(
        &mut self,
        efforts: &mut Efforts,
        out: &mut [Vec<f64>; LANES],
    ) -> Result<(), CheckError> {
        let still = self.still();
        let motions = self.instants.each_ref().map(|Instant { q, .. }| [&q[..], &still, &still]);
        efforts.of_motions(self.times_s, &motions, out)
    }

    /// Computes the efforts that hold the poses and accelerate from rest, with accelerations equal to the instants'
    /// speeds.
    pub(super) fn changing(
        &mut self,
        efforts: &mut Efforts,
        out: &mut [Vec<f64>; LANES],
    ) -> Result<(), CheckError> {
        let still = self.still();
        let motions = self.instants.each_ref().map(|Instant { q, qd, .. }| [&q[..], &still, qd]);
        efforts.of_motions(self.times_s, &motions, out)
    }

    fn still(&self) -> Vec<f64> {
        vec![0.0; self.instants[0].qd.len()]
    }
}
