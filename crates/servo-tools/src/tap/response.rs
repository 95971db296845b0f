//! What the shaft does after a step of the motor's torque.

/// Two masses with a spring and a damper between them, all at the output shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint {
    /// Inertia of the rotor as the gear shows it, kg m².
    pub rotor_kg_m2: f64,
    /// Inertia of what hangs on the shaft, kg m².
    pub load_kg_m2: f64,
    /// Stiffness of the gear, N m/rad.
    pub stiffness_nm_rad: f64,
    /// Damping of the gear between its ends, N m s.
    pub damping_nm_s: f64,
    /// Viscous friction and back-EMF at the rotor, N m s.
    pub drag_nm_s: f64,
}

impl Joint {
    /// Returns the frequency of the ring without damping, rad/s.
    pub fn ring_rad_s(&self) -> f64 {
        (self.stiffness_nm_rad * self.mobility()).sqrt()
    }

    /// Returns the part of the critical damping that the ring has.
    pub fn damping_ratio(&self) -> f64 {
        0.5 * self.damping_nm_s * self.mobility() / self.ring_rad_s()
    }

    /// Returns the shaft's part of a ring after a step of torque, rad per N m: what it is behind a rigid gear.
    pub fn ring_rad_nm(&self) -> f64 {
        let [rotor, load] = [self.rotor_kg_m2, self.load_kg_m2];
        rotor * load / ((rotor + load) * (rotor + load)) / self.stiffness_nm_rad
    }

    fn mobility(&self) -> f64 {
        1.0 / self.rotor_kg_m2 + 1.0 / self.load_kg_m2
    }

    /// Returns where the shaft is after a step of 1 N m at the rotor, rad, at every [`Response::STEP_S`].
    pub(super) fn response(&self, until_s: f64) -> Response {
        // Semi-implicit Euler at a tenth of the step: 10 us, 1e-3 of the fastest ring.
        const PARTS: usize = 5;
        let h = Response::STEP_S / PARTS as f64;
        let [mut rotor, mut shaft] = [[0.0_f64; 2]; 2];
        let mut positions = vec![0.0];
        while (positions.len() as f64) * Response::STEP_S < until_s + 2.0 * Response::STEP_S {
            for _ in 0..PARTS {
                let gear = self.stiffness_nm_rad * (rotor[0] - shaft[0])
                    + self.damping_nm_s * (rotor[1] - shaft[1]);
                rotor[1] += h * (1.0 - self.drag_nm_s * rotor[1] - gear) / self.rotor_kg_m2;
                shaft[1] += h * gear / self.load_kg_m2;
                rotor[0] += h * rotor[1];
                shaft[0] += h * shaft[1];
            }
            positions.push(shaft[0]);
        }
        Response { positions }
    }
}

/// A response, tabulated.
pub(super) struct Response {
    positions: Vec<f64>,
}

impl Response {
    const STEP_S: f64 = 1e-4;

    /// Returns where the shaft is at a time after the step; at rest before it.
    pub(super) fn at(&self, time_s: f64) -> f64 {
        if time_s <= 0.0 {
            return 0.0;
        }
        let place = time_s / Self::STEP_S;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a number of steps, above 0"
        )]
        let index = place as usize;
        let at = |index: usize| {
            self.positions.get(index).or(self.positions.last()).copied().unwrap_or(0.0)
        };
        let (before, after) = (at(index), at(index + 1));
        before + (place - index as f64) * (after - before)
    }
}
