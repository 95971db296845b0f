//! Model of the joint: a rotor, an elastic gear, a load.

use std::f64::consts::FRAC_2_PI;

use super::matrix::Matrix;

/// A joint whose servo has an elastic gear. All values are referred to the joint: kg m² and rad, or kg and m for a
/// slide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlexibleJoint {
    /// Inertia of the rotor, kg m² or kg.
    pub rotor_inertia: f64,
    /// Inertia of the load at the output, kg m² or kg.
    pub load_inertia: f64,
    /// Stiffness of the gear, N m/rad or N/m.
    pub stiffness: f64,
    /// Damping between the ends of the gear, N m s or N s/m.
    pub gear_damping: f64,
    /// Viscous friction of the rotor, N m s or N s/m.
    pub damping: f64,
}

impl FlexibleJoint {
    /// Returns the joint with the gear's stiffness multiplied by `share`.
    #[must_use]
    pub fn softened(self, share: f64) -> Self {
        Self { stiffness: self.stiffness * share, ..self }
    }

    /// Returns the joint with play in its gear, for an oscillation. `amplitude` is the amplitude of the angle
    /// between rotor and load, and `half_play` the play in each direction.
    ///
    /// Uses the describing function: for a sine, the fundamental of a spring with play is that of a spring without
    /// play whose stiffness is multiplied by `N = 1 - 2/π (asin r + r √(1 - r²))`, with `r = half_play /
    /// amplitude`. The stiffness is zero if the oscillation stays within the play. The damper acts only while the
    /// teeth touch, therefore it is multiplied by the same factor.
    #[must_use]
    pub fn with_play(self, half_play: f64, amplitude: f64) -> Self {
        let r = (half_play / amplitude).clamp(0.0, 1.0);
        let share = 1.0 - FRAC_2_PI * (libm::asin(r) + r * libm::sqrt(1.0 - r * r));
        Self { stiffness: self.stiffness * share, gear_damping: self.gear_damping * share, ..self }
    }

    /// Returns the resonance of the rotor on the gear with the output held, rad/s.
    pub fn resonance_rad_s(&self) -> f64 {
        libm::sqrt(self.stiffness / self.rotor_inertia)
    }

    /// Returns the inertia of rotor and load, kg m² or kg. The controller uses it to convert accelerations to
    /// torques.
    pub fn inertia(&self) -> f64 {
        self.rotor_inertia + self.load_inertia
    }

    /// Returns the step of the state `[load, load speed, rotor, rotor speed]` over a time in which the torque on the
    /// rotor is held. The step is exact: it uses the exponential of the equations of motion.
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

/// A step of the joint's state under a constant torque.
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
