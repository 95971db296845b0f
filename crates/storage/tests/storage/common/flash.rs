//! A NOR flash whose power can fail at any point.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use sinew_storage::{Area, BoardTable};

/// Words of 4 bytes, as in the F446.
const WORD: usize = 4;

/// A flash with the contract of [`NorFlash`]: bits only fall until a sector is erased, and no word is written twice.
///
/// Writing a word has two points at which power can fail: before it, and within it, after some bits have fallen. An
/// erase has five: before it, and within it in four ways.
#[derive(Debug, Clone)]
pub(crate) struct MockFlash {
    pub(crate) bytes: Vec<u8>,
    /// Starts of the sectors, and how often each was erased.
    pub(crate) erases: Vec<(usize, u32)>,
    /// Steps until power fails.
    pub(crate) power: Option<u32>,
    /// Steps so far.
    pub(crate) steps: u32,
    /// Number of words that were written twice. The store must never do that: this flash then panics, unless
    /// `may_write_twice` is set.
    pub(crate) twice: u32,
    pub(crate) may_write_twice: bool,
    random: u64,
    is_on: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PowerFailed;

impl NorFlashError for PowerFailed {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl MockFlash {
    /// Returns blank flash with the sectors of a table, and a sector for each gap between them.
    pub(crate) fn new(table: &BoardTable) -> Self {
        let areas: Vec<Area> = [table.log].into_iter().chain(table.slots.iter().copied()).collect();
        let len = areas.iter().map(Area::end).max().unwrap() as usize;
        let sectors = |area: &Area| {
            let (start, len) = (area.start as usize, area.sector_len as usize);
            (0..area.sectors as usize).map(move |index| start + index * len)
        };
        let mut starts: Vec<usize> = areas.iter().flat_map(sectors).collect();
        starts.extend(areas.iter().map(|area| area.end() as usize));
        starts.extend([0, len]);
        starts.sort_unstable();
        starts.dedup();
        let erases = starts.into_iter().map(|start| (start, 0)).collect();
        Self {
            bytes: vec![0xFF; len],
            erases,
            power: None,
            steps: 0,
            twice: 0,
            may_write_twice: false,
            random: 1,
            is_on: true,
        }
    }

    /// Restores power permanently.
    pub(crate) fn restart(&mut self) {
        self.is_on = true;
        self.power = None;
    }

    pub(crate) fn random(&mut self) -> u64 {
        self.random = self.random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let mixed = (self.random ^ (self.random >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed ^ (mixed >> 32)
    }

    pub(crate) fn seed(&mut self, seed: u64) {
        self.random = seed ^ 0x9E37_79B9_7F4A_7C15;
    }

    fn byte(&mut self) -> u8 {
        self.random().to_le_bytes()[0]
    }

    /// Counts a step. Returns `true` if there is still power.
    fn step(&mut self) -> Result<(), PowerFailed> {
        if !self.is_on {
            return Err(PowerFailed);
        }
        self.steps += 1;
        match &mut self.power {
            Some(0) => {
                self.is_on = false;
                return Err(PowerFailed);
            }
            Some(left) => *left -= 1,
            None => {}
        }
        Ok(())
    }

    fn write_word(&mut self, at: usize, word: [u8; WORD]) -> Result<(), PowerFailed> {
        if self.bytes[at..at + WORD] != [0xFF; WORD] {
            assert!(self.may_write_twice, "the word at {at:#x} is written twice");
            self.twice += 1;
        }
        self.step()?;
        let within = self.step();
        for (index, byte) in word.into_iter().enumerate() {
            let still_up = if within.is_ok() { 0 } else { self.byte() };
            self.bytes[at + index] &= byte | still_up;
        }
        within
    }

    fn erase_sector(&mut self, start: usize, end: usize) -> Result<(), PowerFailed> {
        self.step()?;
        for garbage in 0..4 {
            let Err(failed) = self.step() else { continue };
            let middle = start.midpoint(end);
            for at in start..end {
                let (old, any) = (self.bytes[at], self.byte());
                self.bytes[at] = match garbage {
                    0 => any,
                    1 if at < middle => 0xFF,
                    2 if at >= middle => 0xFF,
                    // Bits that are rising during the erase.
                    3 => old | any,
                    _ => old,
                };
            }
            return Err(failed);
        }
        self.bytes[start..end].fill(0xFF);
        Ok(())
    }
}

impl ErrorType for MockFlash {
    type Error = PowerFailed;
}

impl ReadNorFlash for MockFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), PowerFailed> {
        if !self.is_on {
            return Err(PowerFailed);
        }
        bytes.copy_from_slice(&self.bytes[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for MockFlash {
    const WRITE_SIZE: usize = WORD;
    // The smallest sector: sectors differ in length.
    const ERASE_SIZE: usize = 1024;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), PowerFailed> {
        let (from, to) = (from as usize, to as usize);
        let first = self.erases.iter().position(|(start, _)| *start == from).expect("a sector");
        let end = self.erases.iter().position(|(start, _)| *start == to).expect("a sector's end");
        assert!(first < end);
        for sector in first..end {
            self.erases[sector].1 += 1;
            self.erase_sector(self.erases[sector].0, self.erases[sector + 1].0)?;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), PowerFailed> {
        let is_aligned = (offset as usize).is_multiple_of(WORD) && bytes.len().is_multiple_of(WORD);
        assert!(is_aligned, "not in words");
        for (word, at) in bytes.as_chunks::<WORD>().0.iter().zip((offset as usize..).step_by(WORD))
        {
            // An erased word stays erased.
            if *word != [0xFF; WORD] || self.bytes[at..at + WORD] != *word {
                self.write_word(at, *word)?;
            }
        }
        Ok(())
    }
}
