//! The sound of a show: a section after the show's bytes in its file. Only programs on a host read it; boards do not
//! get it.

use crate::layout::{CRC_LEN, MAGIC as SHOW_MAGIC, VERSION as SHOW_VERSION};
use crate::show::CHECKSUM;

/// First bytes of the section, and version of the section.
const MAGIC: [u8; 4] = *b"SNWA";
const VERSION: u16 = 1;
/// Length of the section without name and CRC.
const FIXED_LEN: usize = 68;
/// Longest name, bytes.
const NAME_MAX: usize = 255;

/// Description of the sound that belongs to a show.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sound {
    /// Name of the sound's file, without folders.
    pub name: String,
    /// SHA-256 of the file.
    pub sha256: [u8; 32],
    /// Length of the file, bytes.
    pub file_len: u64,
    /// Duration of the sound, us.
    pub duration_us: u64,
    /// Time of the sound at the start of the show, us. It is negative if the sound begins after the show.
    pub offset_us: i64,
}

/// Reason why a file is not a show with a sound.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SoundError {
    /// The section is cut off, or other bytes follow the show.
    #[error("the {0} bytes after the show are not a section for a sound")]
    Section(usize),
    /// The section is damaged.
    #[error(
        "the section for the sound is damaged: its CRC is {stored:08x}, and that of its bytes {computed:08x}"
    )]
    Checksum {
        /// CRC in the file.
        stored: u32,
        /// CRC of the bytes.
        computed: u32,
    },
}

/// Splits a file into the show and the description of its sound. Returns a file without a section, and a file that is
/// not a show, unchanged. If the section has another version, returns the show without a sound.
///
/// # Errors
/// [`SoundError`] if other bytes than a section follow the show, or the section is damaged.
pub fn split(file: &[u8]) -> Result<(&[u8], Option<Sound>), SoundError> {
    let total = file.get(8..12).and_then(<[u8]>::first_chunk::<4>);
    let total = total.map_or(0, |total| u32::from_le_bytes(*total) as usize);
    let Some((show, section)) = file.split_at_checked(total) else { return Ok((file, None)) };
    // A file that is shorter than its length field is not a show. A show of another version has its length elsewhere,
    // and is refused where it is opened.
    let is_show =
        file.starts_with(&SHOW_MAGIC) && file.get(4..6) == Some(&SHOW_VERSION.to_le_bytes()[..]);
    if !is_show || total == 0 || section.is_empty() {
        return Ok((file, None));
    }
    let wrong = SoundError::Section(section.len());
    let (content, stored) = section
        .split_last_chunk::<CRC_LEN>()
        .filter(|_| section.starts_with(&MAGIC))
        .ok_or(wrong)?;
    let (stored, computed) = (u32::from_le_bytes(*stored), CHECKSUM.checksum(content));
    if stored != computed {
        return Err(SoundError::Checksum { stored, computed });
    }
    let version = content.get(4..6).and_then(<[u8]>::first_chunk::<2>).ok_or(wrong)?;
    if u16::from_le_bytes(*version) != VERSION {
        return Ok((show, None));
    }
    let sound = Sound::read(content).ok_or(wrong)?;
    Ok((show, Some(sound)))
}

impl Sound {
    /// Appends the section to the bytes of a show. A name of more than 255 bytes is cut off.
    pub fn append_to(&self, show: &mut Vec<u8>) {
        let start = show.len();
        let mut end = self.name.len().min(NAME_MAX);
        while !self.name.is_char_boundary(end) {
            end = end.saturating_sub(1);
        }
        let name = self.name.get(..end).unwrap_or_default();
        show.extend(MAGIC);
        show.extend(VERSION.to_le_bytes());
        show.extend(u16::try_from(name.len()).unwrap_or_default().to_le_bytes());
        show.extend(self.sha256);
        show.extend(self.file_len.to_le_bytes());
        show.extend(self.duration_us.to_le_bytes());
        show.extend(self.offset_us.to_le_bytes());
        // Reserved for later fields.
        show.extend([0; 4]);
        show.extend(name.bytes());
        let content = show.get(start..).unwrap_or_default();
        show.extend(CHECKSUM.checksum(content).to_le_bytes());
    }

    fn read(content: &[u8]) -> Option<Self> {
        let (fixed, name) = content.split_at_checked(FIXED_LEN)?;
        let name_len = u16::from_le_bytes(*fixed.get(6..)?.first_chunk()?);
        let number = |at: usize| Some(u64::from_le_bytes(*fixed.get(at..)?.first_chunk()?));
        if name.len() != usize::from(name_len) {
            return None;
        }
        Some(Self {
            name: str::from_utf8(name).ok()?.to_owned(),
            sha256: *fixed.get(8..)?.first_chunk()?,
            file_len: number(40)?,
            duration_us: number(48)?,
            offset_us: number(56)?.cast_signed(),
        })
    }
}
