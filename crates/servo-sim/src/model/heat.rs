//! Temperatures of two masses: the winding, and the case with its sensor.

use super::Parameters;

/// Temperature of the air, °C.
pub(super) const AMBIENT_C: f64 = 25.0;
/// Relative increase of copper's resistance per kelvin.
const COPPER_1_K: f64 = 0.0039;

/// Temperatures of a servo.
#[derive(Debug, Clone, PartialEq)]
pub struct Heat {
    winding_k_w: f64,
    case_k_w: f64,
    winding_j_k: f64,
    case_j_k: f64,
    /// Temperature of the air, °C.
    pub ambient_c: f64,
    /// Temperature of the winding, °C.
    pub winding_c: f64,
    /// Temperature of the case, at the sensor, °C.
    pub case_c: f64,
}

impl Heat {
    /// Creates the temperatures of a servo that is as warm as the air.
    pub fn new(parameters: &Parameters) -> Self {
        Self {
            winding_k_w: parameters.winding_k_w,
            case_k_w: parameters.case_k_w,
            winding_j_k: parameters.winding_time_s / parameters.winding_k_w,
            case_j_k: parameters.case_time_s / parameters.case_k_w,
            ambient_c: AMBIENT_C,
            winding_c: AMBIENT_C,
            case_c: AMBIENT_C,
        }
    }

    /// Returns the winding's resistance, relative to that at 25 °C.
    pub fn resistance_ratio(&self) -> f64 {
        1.0 + COPPER_1_K * (self.winding_c - 25.0)
    }

    /// Advances by `dt_s` with these power losses in the winding and by friction, W.
    pub fn step(&mut self, dt_s: f64, winding_w: f64, friction_w: f64) {
        let into_case_w = (self.winding_c - self.case_c) / self.winding_k_w;
        let into_air_w = (self.case_c - self.ambient_c) / self.case_k_w;
        self.winding_c += dt_s * (winding_w - into_case_w) / self.winding_j_k;
        self.case_c += dt_s * (into_case_w + friction_w - into_air_w) / self.case_j_k;
    }
}
