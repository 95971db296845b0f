//! Largest motion of a rig that stands still.

use super::measure::Stillness;
use super::run::Run;

/// Allowed offset beyond half the play and a step of the encoder, deg.
const OFFSET_DEG: f64 = 0.3;

/// Largest allowed numbers; infinite if there is no limit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    pub(super) peak_to_peak_deg: f64,
    pub(super) speed_deg_s: f64,
    pub(super) alternating_a: f64,
}

/// Limits with friction at both ends of the gear.
pub(super) const SPLIT: Limits =
    Limits { peak_to_peak_deg: 0.3, speed_deg_s: 2.0, alternating_a: 0.05 };
/// Limits with all friction on the rotor.
pub(super) const ON_ROTOR: Limits =
    Limits { peak_to_peak_deg: 0.6, speed_deg_s: 3.0, alternating_a: f64::INFINITY };

impl Run {
    /// Describes the numbers that exceed the limits, by window and joint; also returns the largest of each number.
    pub(super) fn beyond(
        &self,
        windows_s: &[[f64; 2]],
        limits: Limits,
    ) -> (Vec<String>, Stillness) {
        let (mut beyond, mut worst) = (Vec::new(), Stillness::default());
        for (window, dofs) in self.stillness(windows_s).into_iter().enumerate() {
            for (dof, still) in dofs.into_iter().enumerate() {
                worst = worst.max(still);
                let offset_deg = self.blind_rad[dof].to_degrees() + OFFSET_DEG;
                let within = still.peak_to_peak_deg <= limits.peak_to_peak_deg
                    && still.speed_deg_s <= limits.speed_deg_s
                    && still.alternating_a <= limits.alternating_a
                    && still.offset_deg <= offset_deg;
                if !within {
                    let name = &self.names[dof];
                    beyond.push(format!(
                        "pose {window}, {name}: {still:.3?}, offset up to {offset_deg:.3}"
                    ));
                }
            }
        }
        (beyond, worst)
    }
}
