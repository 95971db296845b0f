//! Masses of the segments by regression.
//!
//! The regressions have the form of C. E. Clauser et al., AMRL-TR-69-70 (1969), as in implementations of the modified
//! Hanavan model. No mass is computed as density times volume. The forearm's regression in those implementations uses
//! the total mass in place of the wrist's circumference. That would give a forearm of 5.8 kg for a man of 75 kg; with
//! the wrist it is 1.13 kg, near de Leva's 1.2 kg.

use super::inputs::Inputs;

/// Masses of one side's segments, of the head and of the trunk, in kg.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Masses {
    pub hand: f64,
    pub forearm: f64,
    pub upper_arm: f64,
    pub foot: f64,
    pub shank: f64,
    pub thigh: f64,
    pub head: f64,
    pub trunk: f64,
}

impl Masses {
    pub(super) fn new(inputs: &Inputs) -> Self {
        let i = inputs;
        let total = i.mass_kg.get();
        Self {
            hand: 0.038 * i.wrist_circumference_m.cm() + 0.080 * i.wrist_breadth_m.cm() - 0.660,
            forearm: 0.081 * i.wrist_circumference_m.cm() + 0.052 * i.forearm_circumference_m.cm()
                - 1.650,
            upper_arm: 0.007 * total
                + 0.092 * i.axillary_arm_circumference_m.cm()
                + 0.050 * i.upper_arm_length_m.cm()
                - 3.101,
            foot: 0.003 * total
                + 0.048 * i.ankle_circumference_m.cm()
                + 0.027 * i.foot_length_m.cm()
                - 0.869,
            shank: 0.135 * i.calf_circumference_m.cm() - 1.318,
            thigh: 0.074 * total + 0.138 * i.upper_thigh_circumference_m.cm() - 4.641,
            head: 0.104 * i.head_circumference_m.cm() + 0.015 * total - 2.189,
            trunk: 0.349 * total
                + 0.423 * i.trunk_length_m.cm()
                + 0.229 * i.chest_circumference_m.cm()
                - 35.460,
        }
    }
}
