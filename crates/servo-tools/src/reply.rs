//! Finds replies in the bytes that were received from a line.

use sinew_servo_bus::{dynamixel, feetech};

use crate::Protocol;

/// A reply of a servo.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Reply {
    pub(crate) id: u8,
    /// Error byte. Dynamixel: error number and alert. Feetech: faults, bit by bit.
    pub(crate) error: u8,
    pub(crate) data: Vec<u8>,
}

/// The replies received within a time.
#[derive(Debug, Default)]
pub(crate) struct ReceivedReply {
    pub(crate) replies: Vec<Reply>,
    /// Whether bytes arrived that are not a reply.
    pub(crate) is_noisy: bool,
}

/// Length of the longest Dynamixel reply that is accepted.
const LONGEST: usize = 512;
/// Length of the longest packet of Feetech.
const LONGEST_FEETECH: usize = 259;

/// Returns all replies in `heard`, without the adapter's echo of `sent`: an instruction of Feetech looks like a reply.
///
/// `is_over` means that no more bytes will arrive, so a packet after a damaged packet is searched too.
pub(crate) fn replies(
    protocol: Protocol,
    sent: &[u8],
    heard: &[u8],
    is_over: bool,
) -> ReceivedReply {
    let mut rest = match heard.strip_prefix(sent) {
        Some(rest) => rest,
        // The bytes so far may be the beginning of an echo.
        None if !is_over && sent.starts_with(heard) => return ReceivedReply::default(),
        None => heard,
    };
    let is_silent = rest.is_empty();
    let mut replies = Vec::new();
    let damaged = match protocol {
        Protocol::Dynamixel => {
            let mut parser = dynamixel::Parser::<LONGEST>::new();
            let mut take = |packet: dynamixel::Packet<'_>| {
                if let Some(status) = dynamixel::Status::of(packet) {
                    let (id, error) = (status.id, status.error.byte());
                    replies.push(Reply { id, error, data: status.data.to_vec() });
                }
            };
            while let Some(packet) = parser.next(&mut rest) {
                take(packet);
            }
            while is_over && let Some(packet) = parser.flush() {
                take(packet);
            }
            parser.damaged()
        }
        Protocol::Feetech => {
            let mut parser = feetech::Parser::<LONGEST_FEETECH>::new();
            let mut take = |packet: feetech::Packet<'_>| {
                if let Some(status) = feetech::Status::of(packet) {
                    let (id, error) = (status.id, status.bits);
                    replies.push(Reply { id, error, data: status.data.to_vec() });
                }
            };
            while let Some(packet) = parser.next(&mut rest) {
                take(packet);
            }
            while is_over && let Some(packet) = parser.flush() {
                take(packet);
            }
            parser.damaged()
        }
    };
    let is_noisy = damaged > 0 || (replies.is_empty() && !is_silent);
    ReceivedReply { replies, is_noisy }
}
