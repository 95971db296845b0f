//! The lowest supply voltage while torque was on.

use crate::controller::MotionController;

/// The lowest supply voltage that servos reported while torque was on, V.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct MinSupply(pub(super) Option<f32>);

impl MinSupply {
    /// Updates the minimum with the readings of a tick with torque. O(servos).
    pub(super) fn note<
        const BODIES: usize,
        const DOFS: usize,
        const SERVOS: usize,
        const COORDS: usize,
    >(
        &mut self,
        controller: &MotionController<'_, BODIES, DOFS, SERVOS, COORDS>,
    ) {
        if controller.permission().torque {
            let servos = &controller.report().servos;
            let reported = servos.iter().filter_map(|servo| servo.voltage_v);
            self.0 = reported.filter(|v| v.is_finite()).chain(self.0).reduce(f32::min);
        }
    }
}
