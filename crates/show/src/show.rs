//! A show, opened in place: the head is checked at opening, blocks when they are read.

use crc::{CRC_32_ISO_HDLC, Crc};

use crate::bits::Bits;
use crate::cue::{Cue, Cues};
use crate::error::ShowError;
use crate::joint::Joint;
use crate::layout::{
    BLOCK_HEAD_LEN, CHANNEL_LEN, CRC_LEN, ChannelRecord, HEADER_LEN, Header, LONGEST, MAGIC,
    VERSION,
};
use crate::position::{Pace, Position, Rate};
use crate::time_code::TimeCode;
use crate::time_warp::{PAIR_LEN, TimeWarp};

pub(crate) const CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// A show of version 2, read in place.
///
/// Opening checks the head: O(size of the head). Each block has its own CRC, which is checked when playing reaches
/// the block, or for all blocks at once by [`Self::check_blocks`].
#[derive(Debug, Clone, Copy)]
pub struct Show<'a> {
    bytes: &'a [u8],
    header: Header,
    /// Tables of the head: kinds of joints, channels, cues, course, index of blocks.
    pub(crate) joints: &'a [u8],
    channels: &'a [u8],
    cues: &'a [u8],
    course: &'a [u8],
    index: &'a [u8],
}

impl<'a> Show<'a> {
    /// Opens a show in place.
    ///
    /// # Errors
    /// [`ShowError`] with the problem and its place.
    pub fn open(bytes: &'a [u8]) -> Result<Self, ShowError> {
        let found = bytes.len();
        let short = |expected| ShowError::Length { expected, found };
        let magic = *bytes.first_chunk::<4>().ok_or(short(HEADER_LEN))?;
        if magic != MAGIC {
            return Err(ShowError::Magic { found: magic });
        }
        let (start, _) = bytes.split_first_chunk::<6>().ok_or(short(HEADER_LEN))?;
        let version = u16::from_le_bytes([start[4], start[5]]);
        if version != VERSION {
            return Err(ShowError::Version { found: version });
        }
        let raw = bytes.first_chunk::<HEADER_LEN>().ok_or(short(HEADER_LEN))?;
        let header = Header::read(raw);
        let head_len = usize::try_from(header.head_len).unwrap_or(usize::MAX);
        let total = usize::try_from(header.total_len).unwrap_or(usize::MAX);
        if found != total {
            return Err(short(total));
        }
        let (content, rest) = bytes.split_at_checked(head_len).ok_or(short(head_len))?;
        let stored =
            rest.first_chunk::<CRC_LEN>().ok_or(short(head_len.saturating_add(CRC_LEN)))?;
        let (stored, computed) = (u32::from_le_bytes(*stored), CHECKSUM.checksum(content));
        if stored != computed {
            return Err(ShowError::Checksum { stored, computed });
        }
        header.check()?;
        let tables = content.get(HEADER_LEN..).unwrap_or_default();
        let mut rest = tables;
        let mut take = |len: usize| {
            let (table, behind) = rest.split_at_checked(len)?;
            rest = behind;
            Some(table)
        };
        let field = ShowError::Field { what: "length of head", index: 0, found: header.head_len };
        let joints = take(usize::from(header.joints)).ok_or(field)?;
        let channels =
            take(usize::from(header.channels).saturating_mul(CHANNEL_LEN)).ok_or(field)?;
        let cues = take(usize::from(header.cues_len)).ok_or(field)?;
        let course = if header.is_slowed() {
            let pairs = take(2).and_then(<[u8]>::first_chunk::<2>).ok_or(field)?;
            let pairs = usize::from(u16::from_le_bytes(*pairs));
            take(pairs.saturating_mul(PAIR_LEN)).ok_or(field)?
        } else {
            &[]
        };
        let index = take((header.block_count() as usize).saturating_mul(4)).ok_or(field)?;
        if !rest.is_empty() {
            return Err(field);
        }
        let show = Self { bytes, header, joints, channels, cues, course, index };
        show.check_tables()?;
        Ok(show)
    }

    fn check_tables(&self) -> Result<(), ShowError> {
        let mut channels: usize = 0;
        for (index, code) in self.joints.iter().enumerate() {
            let found = u32::from(*code);
            let joint = Joint::of_code(*code).ok_or(ShowError::Field {
                what: "kind of joint",
                index,
                found,
            })?;
            channels = channels.saturating_add(joint.coordinate_count());
        }
        if channels != self.channel_count() {
            let found = u32::from(self.header.channels);
            return Err(ShowError::Field { what: "number of channels", index: 0, found });
        }
        for index in 0..channels {
            self.channel(index).check(index)?;
        }
        let mut cues = self.cues();
        if cues.by_ref().count() != usize::from(self.header.cues) || !cues.is_whole() {
            let found = u32::from(self.header.cues);
            return Err(ShowError::Field { what: "number of cues", index: 0, found });
        }
        if let Some((index, found)) = self.course().fault(LONGEST) {
            return Err(ShowError::Field { what: "course", index, found });
        }
        let mut from = self.header.head_len.saturating_add(4);
        for block in 0..self.header.block_count() {
            let start = self.block_start(block);
            if start != from {
                let index = block as usize;
                return Err(ShowError::Field { what: "start of block", index, found: start });
            }
            from = self.block_start(block.saturating_add(1));
            if from < start.saturating_add(BLOCK_HEAD_LEN) {
                let index = block as usize;
                return Err(ShowError::Field { what: "end of block", index, found: from });
            }
        }
        Ok(())
    }

    /// Checks the CRC of every block. O(size), like reading the show once. A show that passes was not damaged after it
    /// was written.
    ///
    /// # Errors
    /// [`ShowError::Block`] with the first damaged block.
    pub fn check_blocks(&self) -> Result<(), ShowError> {
        (0..self.header.block_count()).try_for_each(|block| self.check_block(block))
    }

    /// Checks the CRC of a block. O(size of the block).
    pub(crate) fn check_block(&self, block: u32) -> Result<(), ShowError> {
        let content = self.block(block);
        let (stored, content) = content.split_first_chunk::<CRC_LEN>().unwrap_or((&[0; 4], &[]));
        let (stored, computed) = (u32::from_le_bytes(*stored), CHECKSUM.checksum(content));
        if stored == computed { Ok(()) } else { Err(ShowError::Block { block, stored, computed }) }
    }

    fn block(&self, block: u32) -> &'a [u8] {
        let start = self.block_start(block) as usize;
        let end = self.block_start(block.saturating_add(1)) as usize;
        self.bytes.get(start..end).unwrap_or_default()
    }

    /// Returns the offset of a block; for the index after the last, the end of the show.
    fn block_start(&self, block: u32) -> u32 {
        let at = (block as usize).saturating_mul(4);
        let field = self.index.get(at..).and_then(<[u8]>::first_chunk::<4>);
        field.map_or(self.header.total_len, |field| u32::from_le_bytes(*field))
    }

    /// Returns the bits of a channel in a block, and the index of their end. O(channels).
    pub(crate) fn stream(&self, block: u32, channel: usize) -> (Bits<'a>, u32) {
        let content = self.block(block).get(CRC_LEN..).unwrap_or_default();
        let mut table = Bits { bytes: content, at: 0 };
        let width = table.number(5);
        let mut start = self.table_len(width);
        for _ in 0..channel {
            start = start.saturating_add(table.number(width));
        }
        let end = start.saturating_add(table.number(width));
        (Bits { bytes: content, at: start }, end)
    }

    /// Returns the bits of a block from an index on.
    pub(crate) fn bits(&self, block: u32, at: u32) -> Bits<'a> {
        Bits { bytes: self.block(block).get(CRC_LEN..).unwrap_or_default(), at }
    }

    /// Returns the block of a sample; for the end of the show, the last block.
    pub(crate) fn block_of(&self, sample: i32) -> u32 {
        let block = sample.cast_unsigned().checked_div(u32::from(self.header.block));
        block.unwrap_or(0).min(self.block_count().saturating_sub(1))
    }

    /// Returns the number of bits of a block's table.
    fn table_len(&self, width: u32) -> u32 {
        width.saturating_mul(u32::from(self.header.channels)).saturating_add(5)
    }

    pub(crate) fn header(&self) -> &Header {
        &self.header
    }

    pub(crate) fn channel(&self, index: usize) -> ChannelRecord {
        let at = index.saturating_mul(CHANNEL_LEN);
        let record = self.channels.get(at..).and_then(<[u8]>::first_chunk::<CHANNEL_LEN>);
        ChannelRecord::read(record.unwrap_or(&[0; CHANNEL_LEN]))
    }

    /// Returns the number of coordinates in `q` (nq), which is also the number of channels.
    pub fn channel_count(&self) -> usize {
        usize::from(self.header.channels)
    }

    /// Returns the number of dofs in `qd` and `qdd` (nv).
    pub fn dof_count(&self) -> usize {
        self.joints().map(Joint::dof_count).fold(0, usize::saturating_add)
    }

    /// Returns the samples per second: the unit of the show's times.
    pub fn rate(&self) -> Rate {
        self.header.rate
    }

    /// Returns the length in samples. In a looped show, sample `length` equals sample 0.
    pub fn length(&self) -> u32 {
        self.header.length
    }

    /// Returns the duration, s.
    pub fn duration_s(&self) -> f32 {
        self.header.length as f32 / self.header.rate.hz()
    }

    /// Returns `true` if the show continues from its end to its start without a jump.
    pub fn is_loop(&self) -> bool {
        self.header.is_loop()
    }

    /// Returns the number of blocks.
    pub fn block_count(&self) -> u32 {
        self.header.block_count()
    }

    /// Returns the maximum errors that the writer measured: of angles and rotations in rad, of displacements in m.
    pub fn largest_error(&self) -> (f32, f32) {
        (self.header.error_rad, self.header.error_m)
    }

    /// Returns the time code of the start, if the show has a time code.
    pub fn time_code(&self) -> Option<TimeCode> {
        self.header.time_code
    }

    /// Returns the time code at a sample: the production's clock, if the show has a time code. If the show is slower
    /// than its performance, its time code is slower, too. O(pairs of the course).
    pub fn time_code_at(&self, sample: u32) -> Option<TimeCode> {
        let code = self.header.time_code?;
        Some(code.after(code.frames_in(self.course().performed(sample), self.header.rate)))
    }

    /// Returns the map from a slowed-down show's time to its performance's time: empty if the show was not slowed
    /// down, or has no time code.
    pub fn course(&self) -> TimeWarp<'a> {
        TimeWarp::new(self.course)
    }

    /// Returns the cues, in the order of time.
    pub fn cues(&self) -> Cues<'a> {
        Cues::new(self.cues)
    }

    /// Returns the cues from position `from` (included) to position `to` (excluded). O(all cues).
    pub fn cues_between(&self, from: Position, to: Position) -> impl Iterator<Item = Cue<'a>> {
        self.cues().filter(move |cue| {
            let at = Position::from_samples(cue.sample);
            from <= at && at < to
        })
    }

    /// Returns the progress of the show in a tick of `dt_s`.
    pub fn pace(&self, dt_s: f32) -> Pace {
        self.header.rate.pace(dt_s)
    }

    /// Returns the position at a time in microseconds after the start: exact to 1e-9 of a sample, at any time.
    pub fn position_at_us(&self, time_us: u64) -> Position {
        self.header.rate.position(time_us)
    }

    /// Wraps a position to the round of a looped show; limits it to the end of another show.
    pub(crate) fn within(&self, position: Position) -> Position {
        let end = Position::from_samples(self.header.length);
        if self.is_loop() { position.modulo(end) } else { position.min(end) }
    }
}
