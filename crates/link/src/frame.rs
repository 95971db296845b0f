//! Encodes a message as a frame: `00`, COBS of (direction, message, CRC-32), `00`.

use core::fmt;

use crc::{CRC_32_ISO_HDLC, Crc};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::message::{ToController, ToHost};

/// Maximum length of a body, in bytes: direction and message, without the CRC.
///
/// The body has room for 256 bytes of content (64 numbers of a pose, or a page of flash) and 16 bytes of description.
/// At 115,200 baud a frame of this length takes 24 ms. A frame that follows it, such as an e-stop or its answer,
/// therefore waits for at most 24 ms. Up to this length, CRC-32 detects any four wrong bits at any positions (a
/// test tries all; Koopman's tables confirm it up to 371 bytes).
pub const BODY_MAX: usize = 272;

/// Length of the CRC, in bytes.
pub(crate) const CRC_LEN: usize = 4;

/// Maximum length of a frame with its zeros, in bytes.
pub const FRAME_MAX: usize = frame_len(BODY_MAX);

/// Returns the maximum length of a frame with a body of this length, in bytes: CRC, COBS, and a zero at both ends.
///
/// ```
/// # use sinew_link::rate::frame_len;
/// assert_eq!(frame_len(10), 17);
/// ```
pub const fn frame_len(body_len: usize) -> usize {
    let coded = body_len.saturating_add(CRC_LEN);
    coded.saturating_add(coded.div_ceil(254)).saturating_add(2)
}

/// A CRC of 32 bits, not 16: of frames with random damage, 1 in 65,536 passes a CRC-16, and 1 in 4·10⁹ passes a
/// CRC-32.
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

pub(crate) fn crc32(body: &[u8]) -> [u8; CRC_LEN] {
    CRC.checksum(body).to_le_bytes()
}

/// A message of one direction: [`ToController`] or [`ToHost`].
pub trait Message: Serialize + DeserializeOwned + sealed::Sealed {
    /// First byte of a body. On a line that echoes, an end recognizes its own messages by this byte.
    const DIRECTION: u8;
}

impl Message for ToController {
    const DIRECTION: u8 = 0x53;
}

impl Message for ToHost {
    const DIRECTION: u8 = 0x48;
}

mod sealed {
    use crate::message::{ToController, ToHost};

    pub trait Sealed {}
    impl Sealed for ToController {}
    impl Sealed for ToHost {}
}

/// Writes the frame of a message into `out`, and returns the frame. [`FRAME_MAX`] bytes are always enough. O(length).
///
/// # Errors
/// [`EncodeError`] if the message cannot be encoded. Nothing may be sent then.
pub fn encode<'a, M: Message>(message: &M, out: &'a mut [u8]) -> Result<&'a [u8], EncodeError> {
    let mut body = [0; BODY_MAX + CRC_LEN];
    let (direction, rest) = body.split_first_mut().ok_or(EncodeError::Message)?;
    *direction = M::DIRECTION;
    let room = rest.get_mut(..BODY_MAX - 1).ok_or(EncodeError::Message)?;
    let len = postcard::to_slice(message, room).map_err(EncodeError::from)?.len().saturating_add(1);
    let crc = crc32(body.get(..len).ok_or(EncodeError::Message)?);
    let end = len.saturating_add(CRC_LEN);
    body.get_mut(len..end).ok_or(EncodeError::Message)?.copy_from_slice(&crc);

    let has = out.len();
    let room = EncodeError::Room { has };
    let coded = body.get(..end).ok_or(EncodeError::Message)?;
    let inner = out.get_mut(1..).ok_or(room)?;
    let last = cobs::try_encode(coded, inner).map_err(|_| room)?.saturating_add(1);
    *out.first_mut().ok_or(room)? = 0;
    *out.get_mut(last).ok_or(room)? = 0;
    out.get(..=last).ok_or(room)
}

/// An error that prevents the encoding of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum EncodeError {
    /// The buffer is too small.
    Room {
        /// Length of the buffer, in bytes.
        has: usize,
    },
    /// A number of the message is NaN or infinite.
    NotFinite,
    /// The message exceeds the maximum length of a frame, which no message of this crate does.
    Message,
}

impl From<postcard::Error> for EncodeError {
    fn from(error: postcard::Error) -> Self {
        match error {
            postcard::Error::SerdeSerCustom => Self::NotFinite,
            _ => Self::Message,
        }
    }
}

impl fmt::Display for EncodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Room { has } => {
                write!(f, "the frame does not fit in {has} bytes; {FRAME_MAX} are always enough")
            }
            Self::NotFinite => f.write_str("a number of the message is not finite"),
            Self::Message => f.write_str("the message is longer than a frame can be"),
        }
    }
}

impl core::error::Error for EncodeError {}
