//! Efforts that a motion takes: those of inverse dynamics, and friction.

use sinew_core::TreeError;
use sinew_core::coordinates::CoordinatesError;
use sinew_rig::Mechanism;
use sinew_rig::mechanism::InverseDynamics;

use super::curve::Instant;

/// Computes the efforts of instants, with rotors and friction: what [`check`](super::check()) compares with limits.
#[derive(Debug)]
pub struct Efforts {
    dynamics: InverseDynamics,
    single: [Vec<f32>; 3],
    /// What friction takes of each freedom: Coulomb's, and per speed.
    friction: Vec<[f64; 2]>,
}

impl Efforts {
    /// Of a rig. O(bodies · depth).
    ///
    /// # Errors
    /// [`TreeError`] if the rig is larger than the core takes.
    pub fn of(mechanism: &Mechanism) -> Result<Self, TreeError> {
        let of_link = |link: &sinew_rig::mechanism::Link| {
            let count = link.joint.kind().degrees_of_freedom();
            std::iter::repeat_n([link.friction, link.damping], count)
        };
        Ok(Self {
            dynamics: InverseDynamics::of(mechanism)?,
            single: [vec![], vec![], vec![]],
            friction: mechanism.bodies.iter().flat_map(of_link).collect(),
        })
    }

    /// What dry friction takes of a freedom at a speed, N m or N: softened below 0.01 rad/s, so that a joint that
    /// stands asks for none.
    pub fn dry_friction(&self, freedom: usize, speed: f64) -> f64 {
        let [dry, _] = self.friction[freedom];
        dry * (speed / 0.01).clamp(-1.0, 1.0)
    }

    /// What friction that grows with the speed takes of a freedom, N m or N.
    pub(super) fn viscous_friction(&self, freedom: usize, speed: f64) -> f64 {
        let [_, viscous] = self.friction[freedom];
        viscous * speed
    }

    /// Efforts along the degrees of freedom, with the joints' friction, N m or N. O(n).
    ///
    /// # Errors
    /// [`CoordinatesError`] if the instant is none of the rig.
    pub fn at(&mut self, instant: &Instant, out: &mut Vec<f64>) -> Result<(), CoordinatesError> {
        self.without_friction([&instant.q, &instant.qd, &instant.qdd], out)?;
        for (freedom, (effort, speed)) in out.iter_mut().zip(&instant.qd).enumerate() {
            *effort += self.dry_friction(freedom, *speed) + self.viscous_friction(freedom, *speed);
        }
        Ok(())
    }

    /// The same without friction, of positions, speeds and accelerations.
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
}
