//! A board's declaration: its free areas of flash, and its capacity for a rig.

use embedded_storage::nor_flash::NorFlash;

use crate::area::Area;
use crate::descriptor::DESCRIPTOR_LEN;
use crate::error::{CapacityError, TableError};
use crate::flash::{CHUNK_LEN, padded};
use crate::record::{HEAD_LEN, Record};

/// A board's flash and capacity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoardTable {
    /// Area of the log for settings, rig and faults: at least two equal sectors.
    pub log: Area,
    /// Areas of the slots for shows, one per slot.
    pub slots: &'static [Area],
    /// Limits of the rig.
    pub capacity: Capacity,
}

/// The maximum size of a rig on a board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Capacity {
    /// Maximum number of bodies.
    pub bodies: u16,
    /// Maximum number of dofs.
    pub dofs: u16,
    /// Maximum number of servos.
    pub servos: u16,
}

impl BoardTable {
    /// ST NUCLEO-F446RE: sectors of 16, 64 and 128 kB (RM0390, embedded flash memory). Sector 0 contains the vectors,
    /// and sectors 4 and 5 contain the code.
    pub const NUCLEO_F446RE: Self = Self {
        log: Area { start: 0x4000, sector_len: 0x4000, sectors: 3 },
        slots: &[
            Area { start: 0x4_0000, sector_len: 0x2_0000, sectors: 1 },
            Area { start: 0x6_0000, sector_len: 0x2_0000, sectors: 1 },
        ],
        capacity: Capacity { bodies: 33, dofs: 33, servos: 32 },
    };

    /// Returns the maximum length of a rig in the log next to settings of a given length, in bytes. The log must hold
    /// two rigs, because the old rig stays until the new one is complete.
    pub fn largest_rig<F: NorFlash>(&self, settings_len: u32) -> u32 {
        let item = Record::room::<F>(DESCRIPTOR_LEN);
        let fixed = padded::<F>(HEAD_LEN)
            .saturating_add(crate::fault::room_for_all::<F>())
            .saturating_add(item.saturating_add(padded::<F>(settings_len)));
        let each = self.log.sector_len.saturating_sub(fixed) >> 1;
        // Room for two rigs, each in whole granules.
        each.saturating_sub(item) & !padded::<F>(1).saturating_sub(1)
    }

    pub(crate) fn check<F: NorFlash>(&self, capacity: usize) -> Result<(), TableError> {
        if !F::WRITE_SIZE.is_power_of_two() || F::WRITE_SIZE > 32 {
            return Err(TableError::Granule { found: F::WRITE_SIZE });
        }
        let least = padded::<F>(HEAD_LEN).saturating_add(crate::fault::room_for_all::<F>());
        self.log.check([2, least], capacity)?;
        for (index, slot) in self.slots.iter().enumerate() {
            slot.check([1, CHUNK_LEN], capacity)?;
            for other in self.slots.iter().take(index).chain([&self.log]) {
                if slot.start < other.end() && other.start < slot.end() {
                    return Err(TableError::Overlap { first: other.start, second: slot.start });
                }
            }
        }
        Ok(())
    }
}

impl Capacity {
    /// Length of the part of a rig's compact form that [`Self::check`] reads, in bytes.
    pub const HEAD_LEN: usize = 16;

    /// Refuses a rig that is too large, from the start of its compact form (`sinew_rig::board`).
    ///
    /// # Errors
    /// [`CapacityError`] with the count that is too large, or with the first bytes if they are not a rig's.
    pub fn check(self, head: &[u8; Self::HEAD_LEN]) -> Result<(), CapacityError> {
        let [m0, m1, m2, m3, v0, v1, b0, b1, f0, f1, l0, l1, d0, d1, s0, s1] = *head;
        let found = [m0, m1, m2, m3, v0, v1];
        if found != *b"SNWR\x01\x00" {
            return Err(CapacityError::NotARig { found });
        }
        let dof = self.dofs;
        for (what, found, holds) in [
            ("bodies", [b0, b1], self.bodies),
            ("degrees of freedom", [f0, f1], dof),
            ("linked limits", [l0, l1], dof),
            ("drives", [d0, d1], self.servos),
            ("servos", [s0, s1], self.servos),
        ] {
            let found = u16::from_le_bytes(found);
            if found > holds {
                return Err(CapacityError::TooLarge { what, found, holds });
            }
        }
        Ok(())
    }
}
