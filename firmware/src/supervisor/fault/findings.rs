//! Faults that detectors find in a tick.

use super::{Fault, FaultSet};

/// Faults that are present in a tick, with their servos.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Findings {
    present: FaultSet,
    servos: [Option<u16>; Fault::COUNT],
}

impl Findings {
    /// Adds a fault of the rig.
    pub fn note(&mut self, fault: Fault) {
        self.present = self.present.with(fault);
    }

    /// Adds a fault of a servo. If several servos have it, the first one is kept.
    pub fn note_of(&mut self, fault: Fault, servo: u16) {
        self.note(fault);
        if let Some((_, of)) = self.of_mut(fault) {
            *of = of.or(Some(servo));
        }
    }

    /// Returns the present faults.
    pub fn present(&self) -> FaultSet {
        self.present
    }

    /// Returns the servo for which a fault was added, or `None` if the fault belongs to no servo.
    pub fn servo(&self, fault: Fault) -> Option<u16> {
        let mut named = Fault::ALL.into_iter().zip(self.servos);
        named.find(|(of, _)| *of == fault).and_then(|(_, servo)| servo)
    }

    fn of_mut(&mut self, fault: Fault) -> Option<(Fault, &mut Option<u16>)> {
        Fault::ALL.into_iter().zip(&mut self.servos).find(|(of, _)| *of == fault)
    }
}
