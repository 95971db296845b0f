//! An area of flash: a number of equal sectors.

use embedded_storage::nor_flash::NorFlash;

use crate::descriptor::DESCRIPTOR_LEN;
use crate::error::TableError;
use crate::flash::CHUNK_LEN;
use crate::record::Record;

/// Consecutive equal sectors of flash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Area {
    /// Address of the first sector, from the start of the flash.
    pub start: u32,
    /// Length of a sector, in bytes: the unit of erasing.
    pub sector_len: u32,
    /// Number of sectors.
    pub sectors: u32,
}

impl Area {
    /// Returns the length of all sectors, in bytes.
    pub const fn total_len(&self) -> u32 {
        self.sector_len.saturating_mul(self.sectors)
    }

    /// Returns the address after the last sector.
    pub const fn end(&self) -> u32 {
        self.start.saturating_add(self.total_len())
    }

    /// Returns the address after the last sector that the first `len` bytes of the area touch.
    pub(crate) fn sectors_end(&self, len: u32) -> u32 {
        let behind = len.saturating_add(self.sector_len.saturating_sub(1));
        let count = behind.checked_div(self.sector_len).unwrap_or_default();
        self.start.saturating_add(count.saturating_mul(self.sector_len)).min(self.end())
    }

    /// Returns the maximum length of a show in this area as a slot, in bytes.
    pub fn holds<F: NorFlash>(&self) -> u32 {
        self.total_len().saturating_sub(Record::room::<F>(DESCRIPTOR_LEN))
    }

    /// Returns the maximum duration of a show in this area as a slot, in minutes, from the show's bytes per second.
    /// Returns `None` if `bytes_per_second` is not above 0.
    pub fn minutes<F: NorFlash>(&self, bytes_per_second: f32) -> Option<f32> {
        (bytes_per_second > 0.0).then(|| self.holds::<F>() as f32 / bytes_per_second / 60.0)
    }

    /// Checks the area. `least`: minimum number of sectors, and minimum length of each.
    pub(crate) fn check(&self, least: [u32; 2], capacity: usize) -> Result<(), TableError> {
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
        // Addresses are u32. The last chunk of this range is excluded, so that saturated sums of lengths are beyond
        // all areas.
        let capacity = (capacity as u64).min(u64::from(u32::MAX.saturating_sub(CHUNK_LEN)));
        if end > capacity {
            return Err(TableError::Beyond { start, end, capacity });
        }
        Ok(())
    }
}
