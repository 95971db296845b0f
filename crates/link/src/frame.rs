//! One message as a frame: `00`, COBS of (direction, message, CRC-32), `00`.

use core::fmt;

use crc::{CRC_32_ISO_HDLC, Crc};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::message::{ToController, ToHost};

/// The longest body: direction and message, without the CRC, in bytes.
///
/// 256 bytes of content (64 numbers of a pose, or a page of flash) and 16 that say what it is. At 115,200 baud such a
/// frame takes 24 ms, so what waits behind it, an e-stop or its answer, waits no longer than that. And up to this
/// length CRC-32 finds any four wrong bits, wherever they are (a test tries all; Koopman's tables say the same to 371
/// bytes).
pub const BODY_MAX: usize = 272;

/// Bytes of the CRC.
pub(crate) const CRC_LEN: usize = 4;

/// The longest frame with its zeros, in bytes.
pub const FRAME_MAX: usize = frame_len(BODY_MAX);

/// Bytes of the frame of a body of this length, at most: CRC, COBS, and a zero at both ends.
///
/// ```
/// # use sinew_link::rate::frame_len;
/// assert_eq!(frame_len(10), 17);
/// ```
pub const fn frame_len(body_len: usize) -> usize {
    let coded = body_len.saturating_add(CRC_LEN);
    coded.saturating_add(coded.div_ceil(254)).saturating_add(2)
}

/// Of 32 bits, not 16: of random damage one frame in 65,536 passes a CRC-16, one in 4·10⁹ a CRC-32.
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

pub(crate) fn crc32(body: &[u8]) -> [u8; CRC_LEN] {
    CRC.checksum(body).to_le_bytes()
}

/// A message of one direction: [`ToController`] or [`ToHost`].
pub trait Message: Serialize + DeserializeOwned + sealed::Sealed {
    /// The first byte of a body. A line that echoes brings back what was sent; no one takes it for the other's.
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

/// Writes the frame of a message into `out`, and returns it; [`FRAME_MAX`] bytes are always enough. O(length).
///
/// # Errors
/// [`EncodeError`]: nothing may be sent then.
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

/// Why a message cannot be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum EncodeError {
    /// The buffer is too small.
    Room {
        /// How many bytes it has.
        has: usize,
    },
    /// A number of the message is NaN or infinite.
    NotFinite,
    /// The message is longer than a frame can be. No message of this crate is.
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
