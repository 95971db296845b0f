//! Flash of a simulated board: memory, and a file that stores it.

use std::cell::RefCell;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::ops::Range;
use std::path::Path;
use std::rc::Rc;

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use sinew_storage::{Area, BoardTable, Capacity};

use crate::play::{BODIES, DOFS, SERVOS};

const SECTOR_LEN: u32 = 0x4000;

/// Size of a sector of the log, bytes. It has room for two rigs of [`SERVOS`] servos: the old rig stays until the new
/// one is complete.
const LOG_SECTOR_LEN: u32 = 0x1_0000;

/// Size of the flash, bytes.
const FLASH_LEN: usize = 0xA_4000;

#[expect(clippy::cast_possible_truncation, reason = "they are small")]
const CAPACITY: Capacity =
    Capacity { bodies: BODIES as u16, dofs: DOFS as u16, servos: SERVOS as u16 };

/// Layout with two slots of 256 kB, enough for minutes.
pub(super) const TABLE: BoardTable = BoardTable {
    log: Area { start: 0x4000, sector_len: LOG_SECTOR_LEN, sectors: 2 },
    slots: &[
        Area { start: 0x2_4000, sector_len: SECTOR_LEN, sectors: 16 },
        Area { start: 0x6_4000, sector_len: SECTOR_LEN, sectors: 16 },
    ],
    capacity: CAPACITY,
};

/// Error of an access outside the flash, or of writing the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FlashError;

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

/// Flash that the driver and the processor share.
#[derive(Debug, Clone)]
pub struct Chip {
    bytes: Rc<RefCell<Vec<u8>>>,
    file: Option<Rc<RefCell<File>>>,
}

impl Chip {
    /// Creates blank flash that is lost when the program ends.
    pub fn blank() -> Self {
        Self { bytes: Rc::new(RefCell::new(vec![0xFF; FLASH_LEN])), file: None }
    }

    /// Opens the flash in a file, and locks the file. A missing file is blank flash.
    ///
    /// # Errors
    /// An I/O error, another program that has locked the file, or a file that is not the flash of such a board.
    pub fn in_file(path: &Path) -> io::Result<Self> {
        let mut options = OpenOptions::new();
        let mut file = options.read(true).write(true).create(true).truncate(false).open(path)?;
        file.try_lock().map_err(|error| match error {
            TryLockError::WouldBlock => io::Error::other("another simulated board uses it"),
            TryLockError::Error(error) => error,
        })?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes)?;
        if bytes.is_empty() {
            bytes = vec![0xFF; FLASH_LEN];
            file.write_all(&bytes)?;
        }
        if bytes.len() != FLASH_LEN {
            let found = bytes.len();
            return Err(io::Error::other(format!(
                "is not the flash of a simulated board of this version: it has {found} bytes, expected {FLASH_LEN}; \
                 another file, or none, is blank flash"
            )));
        }
        let file = Some(Rc::new(RefCell::new(file)));
        Ok(Self { bytes: Rc::new(RefCell::new(bytes)), file })
    }

    /// Passes the bytes of a range to `look`. Returns `None` if the range is not within the flash.
    pub(super) fn look<R>(&self, range: Range<u32>, look: impl FnOnce(&[u8]) -> R) -> Option<R> {
        let bytes = self.bytes.borrow();
        bytes.get(range.start as usize..range.end as usize).map(look)
    }

    /// Changes a range, also in the file.
    fn change(
        &mut self,
        from: u32,
        len: usize,
        change: impl FnOnce(&mut [u8]),
    ) -> Result<(), FlashError> {
        let mut bytes = self.bytes.borrow_mut();
        let range = bytes.get_mut(from as usize..).and_then(|rest| rest.get_mut(..len));
        let range = range.ok_or(FlashError)?;
        change(range);
        let Some(file) = &self.file else { return Ok(()) };
        let mut file = file.borrow_mut();
        let written = file.seek(SeekFrom::Start(from.into())).and_then(|_| file.write_all(range));
        written.map_err(|_| FlashError)
    }
}

impl ErrorType for Chip {
    type Error = FlashError;
}

impl ReadNorFlash for Chip {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        let end = offset + u32::try_from(bytes.len()).map_err(|_| FlashError)?;
        self.look(offset..end, |from| bytes.copy_from_slice(from)).ok_or(FlashError)
    }

    fn capacity(&self) -> usize {
        FLASH_LEN
    }
}

impl NorFlash for Chip {
    // The word of the F446's flash; its sectors are larger.
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = 1024;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        let len = to.checked_sub(from).ok_or(FlashError)?;
        self.change(from, len as usize, |bytes| bytes.fill(0xFF))
    }

    fn write(&mut self, offset: u32, new: &[u8]) -> Result<(), FlashError> {
        // Writing can only clear bits.
        self.change(offset, new.len(), |bytes| {
            bytes.iter_mut().zip(new).for_each(|(old, new)| *old &= new);
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_keeps_what_was_written_and_is_held_by_one() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("flash.bin");
        let mut chip = Chip::in_file(&path).unwrap();
        chip.write(64, &[1, 2, 3, 4]).unwrap();
        let second = Chip::in_file(&path).unwrap_err().to_string();
        assert!(second.contains("another"), "{second}");
        drop(chip);
        let mut bytes = [0; 6];
        Chip::in_file(&path).unwrap().read(63, &mut bytes).unwrap();
        assert_eq!(bytes, [0xFF, 1, 2, 3, 4, 0xFF]);
        std::fs::write(&path, "no flash").unwrap();
        let other = Chip::in_file(&path).unwrap_err().to_string();
        assert!(other.contains("8 bytes"), "{other}");
    }
}
