//! Cues: events at given times of a show.

use core::str;

/// An event at a sample of a show: a light, a sound, a mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cue<'a> {
    /// Time of the event, in samples from the start.
    pub sample: u32,
    /// Name of the event.
    pub name: &'a str,
}

/// The cues of a show, in the order of time.
#[derive(Debug, Clone)]
pub struct Cues<'a> {
    rest: &'a [u8],
}

impl<'a> Cues<'a> {
    pub(crate) fn new(table: &'a [u8]) -> Self {
        Self { rest: table }
    }

    /// Returns `true` if the whole table was read.
    pub(crate) fn is_whole(&self) -> bool {
        self.rest.is_empty()
    }
}

impl<'a> Iterator for Cues<'a> {
    type Item = Cue<'a>;

    fn next(&mut self) -> Option<Cue<'a>> {
        let (sample, rest) = self.rest.split_first_chunk::<4>()?;
        let (len, rest) = rest.split_first()?;
        let (name, rest) = rest.split_at_checked(usize::from(*len))?;
        let name = str::from_utf8(name).ok()?;
        self.rest = rest;
        Some(Cue { sample: u32::from_le_bytes(*sample), name })
    }
}
