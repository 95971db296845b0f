//! An area of flash: some equal sectors.

use embedded_storage::nor_flash::NorFlash;

use crate::descriptor::DESCRIPTOR_LEN;
use crate::error::TableError;
use crate::flash::CHUNK_LEN;
use crate::record::Record;

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
        // Places are u32; the last chunk of them is not used, so that sums of lengths saturate above all areas.
        let capacity = (capacity as u64).min(u64::from(u32::MAX.saturating_sub(CHUNK_LEN)));
        if end > capacity {
            return Err(TableError::Beyond { start, end, capacity });
        }
        Ok(())
    }
}
