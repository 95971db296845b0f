//! What a board declares: where its flash is free, and how large a rig it holds.

use embedded_storage::nor_flash::NorFlash;
use thiserror::Error;

use crate::descriptor::DESCRIPTOR_LEN;
use crate::flash::{CHUNK_LEN, padded};
use crate::record::{HEAD_LEN, Record};

/// A board's flash and capacity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoardTable {
    /// At least two equal sectors for settings, rig and faults.
    pub log: Area,
    /// Slots of shows, one area each.
    pub slots: &'static [Area],
    /// The largest rig.
    pub capacity: Capacity,
}

/// Some equal sectors of flash, one behind the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Area {
    /// Where the first begins, from the beginning of the flash.
    pub start: u32,
    /// Bytes that are erased together.
    pub sector_len: u32,
    /// How many.
    pub sectors: u32,
}

/// The largest rig that a board holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Capacity {
    /// Bodies.
    pub bodies: u16,
    /// Degrees of dof.
    pub dofs: u16,
    /// Servos.
    pub servos: u16,
}

/// Why a board does not take a rig.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum CapacityError {
    /// It is too large.
    #[error("the rig has {found} {what}, the board holds {holds}")]
    TooLarge {
        /// Of what it has too many.
        what: &'static str,
        /// How many it has.
        found: u16,
        /// How many the board holds.
        holds: u16,
    },
    /// The bytes do not begin as a rig of version 1.
    #[error("not a rig of version 1: it begins with {found:02x?} in place of `SNWR`, 1")]
    NotARig {
        /// How they begin.
        found: [u8; 6],
    },
}

/// Why a table cannot be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum TableError {
    /// The flash writes units that are no power of two up to 32 bytes.
    #[error("the flash writes {found} bytes at once; 1, 2, 4, 8, 16, 32 are possible")]
    Granule {
        /// Bytes it writes at once.
        found: usize,
    },
    /// Areas begin at multiples of 64 bytes, sectors have multiples of 64, and those of the log hold all faults.
    #[error(
        "the area at {start:#x} has sectors of {sector_len} bytes: it takes multiples of 64, at least {least}"
    )]
    Sector {
        /// Where the area begins.
        start: u32,
        /// The length of its sectors.
        sector_len: u32,
        /// The least length.
        least: u32,
    },
    /// The log has one sector, or an area none.
    #[error("the area at {start:#x} has {found} sectors, it needs {least}")]
    Sectors {
        /// Where the area begins.
        start: u32,
        /// How many sectors it has.
        found: u32,
        /// How many it needs.
        least: u32,
    },
    /// An area ends behind the flash.
    #[error("the area at {start:#x} ends at {end:#x}, the flash at {capacity:#x}")]
    Beyond {
        /// Where the area begins.
        start: u32,
        /// Where it ends.
        end: u64,
        /// Bytes of flash.
        capacity: u64,
    },
    /// Two areas share sectors.
    #[error("the areas at {first:#x} and {second:#x} overlap")]
    Overlap {
        /// Where one begins.
        first: u32,
        /// Where the other begins.
        second: u32,
    },
}

impl Area {
    /// Bytes of all its sectors.
    pub const fn total_len(&self) -> u32 {
        self.sector_len.saturating_mul(self.sectors)
    }

    /// Where it ends.
    pub const fn end(&self) -> u32 {
        self.start.saturating_add(self.total_len())
    }

    /// Where the sectors end that so many bytes from its beginning lie in.
    pub(crate) fn sectors_end(&self, len: u32) -> u32 {
        let behind = len.saturating_add(self.sector_len.saturating_sub(1));
        let count = behind.checked_div(self.sector_len).unwrap_or_default();
        self.start.saturating_add(count.saturating_mul(self.sector_len)).min(self.end())
    }

    /// Bytes of show that it holds as a slot.
    pub fn holds<F: NorFlash>(&self) -> u32 {
        self.total_len().saturating_sub(Record::room::<F>(DESCRIPTOR_LEN))
    }

    /// Minutes of show that it holds as a slot, by the bytes that a second of such a show takes. `None` where those are
    /// not above 0.
    pub fn minutes<F: NorFlash>(&self, bytes_per_second: f32) -> Option<f32> {
        (bytes_per_second > 0.0).then(|| self.holds::<F>() as f32 / bytes_per_second / 60.0)
    }

    /// Whether it is one, of so many sectors at least, which have so many bytes at least.
    fn check(&self, least: [u32; 2], capacity: usize) -> Result<(), TableError> {
        let Self { start, sector_len, sectors } = *self;
        let [least_sectors, least] = least;
        let aligned = (start | sector_len) & CHUNK_LEN.saturating_sub(1) == 0;
        if !aligned || sector_len < least {
            return Err(TableError::Sector { start, sector_len, least });
        }
        if sectors < least_sectors {
            return Err(TableError::Sectors { start, found: sectors, least: least_sectors });
        }
        let len = u64::from(sector_len).saturating_mul(u64::from(sectors));
        let end = u64::from(start).saturating_add(len);
        // Places are u32; the last chunk of them is not used, so that sums of lengths saturate above all areas.
        let capacity = (capacity as u64).min(u64::from(u32::MAX.saturating_sub(CHUNK_LEN)));
        if end > capacity {
            return Err(TableError::Beyond { start, end, capacity });
        }
        Ok(())
    }
}

impl BoardTable {
    /// ST NUCLEO-F446RE: sectors of 16, 64 and 128 kB (RM0390, embedded flash memory). Sector 0 has the
    /// vectors, 4 and 5 the code.
    pub const NUCLEO_F446RE: Self = Self {
        log: Area { start: 0x4000, sector_len: 0x4000, sectors: 3 },
        slots: &[
            Area { start: 0x4_0000, sector_len: 0x2_0000, sectors: 1 },
            Area { start: 0x6_0000, sector_len: 0x2_0000, sectors: 1 },
        ],
        capacity: Capacity { bodies: 33, dofs: 33, servos: 32 },
    };

    /// Bytes of rig that the log holds beside settings of a length: while a new one comes, the old one stays.
    pub fn largest_rig<F: NorFlash>(&self, settings_len: u32) -> u32 {
        let item = Record::room::<F>(DESCRIPTOR_LEN);
        let fixed = padded::<F>(HEAD_LEN)
            .saturating_add(crate::fault::room_for_all::<F>())
            .saturating_add(item.saturating_add(padded::<F>(settings_len)));
        let each = self.log.sector_len.saturating_sub(fixed) >> 1;
        // Two of them, each in whole granules.
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
    /// Bytes of a rig's compact form that [`Self::check`] looks at.
    pub const HEAD_LEN: usize = 16;

    /// Refuses a rig by number, from the beginning of its compact form (`sinew_rig::board`).
    ///
    /// # Errors
    /// [`CapacityError`] names of what it has too many, or how the bytes begin that are no rig's.
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
