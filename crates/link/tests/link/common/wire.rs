//! Frames, also with the tests' own COBS and CRC-32.

use sinew_link::{FRAME_MAX, Message, encode};

pub(crate) fn frame<M: Message>(message: &M) -> Vec<u8> {
    encode(message, &mut [0; FRAME_MAX]).expect("every message fits").to_vec()
}

/// Returns the frame of any body with a correct CRC.
pub(crate) fn frame_of(body: &[u8]) -> Vec<u8> {
    let crc = crc32(body);
    let mut whole = body.to_vec();
    whole.extend(crc.to_le_bytes());
    let mut frame = vec![0];
    frame.extend(stuff(&whole));
    frame.push(0);
    frame
}

/// Returns direction and message of a frame, decoded without the code of this crate.
pub(crate) fn body_of(frame: &[u8]) -> Vec<u8> {
    let mut body = Vec::new();
    let mut rest = &frame[1..frame.len() - 1];
    while let Some((&code, behind)) = rest.split_first() {
        let count = usize::from(code) - 1;
        body.extend(&behind[..count]);
        rest = &behind[count..];
        if code < 255 && !rest.is_empty() {
            body.push(0);
        }
    }
    body.truncate(body.len() - 4);
    body
}

/// Encodes COBS by its definition, for comparison.
fn stuff(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut rest = bytes;
    loop {
        let run = rest.iter().take(254).take_while(|&&byte| byte != 0).count();
        out.push(run as u8 + 1);
        out.extend(&rest[..run]);
        rest = &rest[run..];
        if rest.is_empty() {
            return out;
        }
        if run < 254 {
            rest = &rest[1..];
            if rest.is_empty() {
                out.push(1);
                return out;
            }
        }
    }
}

/// Computes CRC-32 bit by bit, by its definition, for comparison.
pub(crate) fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |mut crc: u32, &byte| {
        crc ^= u32::from(byte);
        for _ in 0..8 {
            crc = (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg());
        }
        crc
    })
}

/// Returns `true` if the `Debug` output of a value contains no NaN and no infinity outside quotes.
pub(crate) fn is_finite(value: &impl std::fmt::Debug) -> bool {
    let text = format!("{value:?}").replace("\\\"", "");
    text.split('"').step_by(2).all(|piece| !piece.contains("NaN") && !piece.contains("inf"))
}
