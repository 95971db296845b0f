//! The joint: a rotor, a soft gear, a load.

use std::f64::consts::FRAC_2_PI;

use super::matrix::Matrix;

/// A joint whose servo has a soft gear, all as the joint sees it: kg m² and rad, or kg and m of one that slides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlexibleJoint {
    /// Inertia of the rotor, kg m² or kg.
    pub rotor_inertia: f64,
    /// Inertia of what is at the output, kg m² or kg.
    pub load_inertia: f64,
    /// Stiffness of the gear, N m/rad or N/m.
    pub stiffness: f64,
    /// Damping of the gear, between its ends, N m s or N s/m.
    pub gear_damping: f64,
    /// Viscous friction of the rotor, N m s or N s/m.
    pub damping: f64,
}

impl FlexibleJoint {
    /// Returns the joint with a gear of this share of its stiffness.
    #[must_use]
    pub fn softened(self, share: f64) -> Self {
        Self { stiffness: self.stiffness * share, ..self }
    }

    /// Returns the joint with a gear that swings with this amplitude of its windup; play takes `half_play` of it each
    /// way.
    ///
    /// Its describing function: the fundamental of what a spring with play gives to a sine is a spring without play
    /// that is softer, by `N = 1 - 2/π (asin r + r √(1 - r²))` with `r = half_play / amplitude`; nothing is left where
    /// the swing stays within the play. The damper acts while the teeth touch, which leaves the same share of it.
    #[must_use]
    pub fn with_play(self, half_play: f64, amplitude: f64) -> Self {
        let r = (half_play / amplitude).clamp(0.0, 1.0);
        let share = 1.0 - FRAC_2_PI * (libm::asin(r) + r * libm::sqrt(1.0 - r * r));
        Self { stiffness: self.stiffness * share, gear_damping: self.gear_damping * share, ..self }
    }

    /// Resonance of the rotor on the gear with the output held, rad/s.
    pub fn resonance_rad_s(&self) -> f64 {
        libm::sqrt(self.stiffness / self.rotor_inertia)
    }

    /// Inertia of both, kg m² or kg: what the torque for an acceleration is computed with.
    pub fn inertia(&self) -> f64 {
        self.rotor_inertia + self.load_inertia
    }

    /// Turns the state `[load, load speed, rotor, rotor speed]` by a time in which the torque on the rotor is held.
    /// Exact: the exponential of the equations of motion.
    pub(super) fn step(&self, time_s: f64) -> Step {
        let Self { rotor_inertia, load_inertia, stiffness, gear_damping, damping } = *self;
        let load = [stiffness, gear_damping].map(|x| x / load_inertia);
        let rotor = [stiffness, gear_damping].map(|x| x / rotor_inertia);
        let lost = damping / rotor_inertia;
        let exponential = Matrix::of_map(5, |x| {
            let [angle, speed, rotor_angle, rotor_speed, torque] = x else { return Vec::new() };
            let (windup, rate) = (rotor_angle - angle, rotor_speed - speed);
            vec![
                time_s * speed,
                time_s * (load[0] * windup + load[1] * rate),
                time_s * rotor_speed,
                time_s
                    * (torque / rotor_inertia
                        - rotor[0] * windup
                        - rotor[1] * rate
                        - lost * rotor_speed),
                0.0,
            ]
        })
        .exponential();
        let mut state = [[0.0; 4]; 4];
        let mut torque = [0.0; 4];
        for ((row, state), torque) in exponential.rows().zip(&mut state).zip(&mut torque) {
            state.copy_from_slice(&row[..4]);
            *torque = row[4];
        }
        Step { state, torque }
    }
}

/// A step of the joint's state under a torque that is held.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    state: [[f64; 4]; 4],
    torque: [f64; 4],
}

impl Step {
    pub(super) fn of(&self, state: [f64; 4], torque: f64) -> [f64; 4] {
        let mut next = self.torque.map(|item| item * torque);
        for (next, row) in next.iter_mut().zip(&self.state) {
            *next += row.iter().zip(state).map(|(a, b)| a * b).sum::<f64>();
        }
        next
    }
}
