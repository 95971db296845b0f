//! A receiver that sees the whole stream at once. It is written from the text of the protocols, without code of the
//! crate. At each byte, either a whole packet begins, or the byte is dropped.

/// A whole packet, without header, stuffing and check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Found {
    /// Index of the packet's first byte in the stream.
    pub(crate) start: usize,
    pub(crate) id: u8,
    /// Instruction byte; in Feetech's replies the status.
    pub(crate) code: u8,
    pub(crate) params: Vec<u8>,
}

fn scan(stream: &[u8], packet_at: impl Fn(usize, &[u8]) -> Option<(Found, usize)>) -> Vec<Found> {
    let (mut found, mut at) = (Vec::new(), 0);
    while at < stream.len() {
        if let Some((packet, len)) = packet_at(at, &stream[at..]) {
            found.push(packet);
            at += len;
        } else {
            at += 1;
        }
    }
    found
}

/// Finds Dynamixel 2.0 packets of at most `longest` bytes on the wire.
pub(crate) fn dynamixel(stream: &[u8], longest: usize) -> Vec<Found> {
    scan(stream, |start, bytes| {
        if bytes.len() < 7 || bytes[..4] != [0xFF, 0xFF, 0xFD, 0] {
            return None;
        }
        let (id, length) = (bytes[4], usize::from(u16::from_le_bytes([bytes[5], bytes[6]])));
        let len = length + 7;
        if (id > 252 && id != 254) || length < 3 || len > longest || bytes.len() < len {
            return None;
        }
        let (said, crc) = bytes[..len].split_at(len - 2);
        if crc16(said).to_le_bytes() != crc {
            return None;
        }
        let body = &said[7..];
        // The answer to a fast read is not stuffed.
        let body = if id == 254 && body[0] == 0x55 { body.to_vec() } else { unstuffed(body) };
        Some((Found { start, id, code: body[0], params: body[1..].to_vec() }, len))
    })
}

/// Finds Feetech packets of at most `longest` bytes.
pub(crate) fn feetech(stream: &[u8], longest: usize) -> Vec<Found> {
    scan(stream, |start, bytes| {
        if bytes.len() < 4 || bytes[..2] != [0xFF, 0xFF] {
            return None;
        }
        let (id, length) = (bytes[2], usize::from(bytes[3]));
        let len = length + 4;
        if id == 0xFF || length < 2 || len > longest || bytes.len() < len {
            return None;
        }
        let sum: usize = bytes[2..len].iter().map(|byte| usize::from(*byte)).sum();
        // The last byte is the inverted sum of the others, so that the sum of all is 255.
        (sum % 256 == 255).then(|| {
            let params = bytes[5..len - 1].to_vec();
            (Found { start, id, code: bytes[4], params }, len)
        })
    })
}

/// Returns the parts of the answer to a fast read before the first wrong check: id, error, data. `servos` lists id and
/// number of bytes of each servo. Each check covers all bytes from the header on.
pub(crate) fn fast(servos: &[(u8, usize)], stream: &[u8]) -> Vec<(u8, u8, Vec<u8>)> {
    let all: usize = servos.iter().map(|(_, len)| len + 4).sum();
    let [low, high] = u16::try_from(all + 1).unwrap().to_le_bytes();
    let head = [0xFF, 0xFF, 0xFD, 0, 0xFE, low, high, 0x55];
    let mut found = Vec::new();
    let Some(start) = stream.windows(8).position(|bytes| bytes == head) else { return found };
    let answer = &stream[start..];
    let mut end = 8;
    for (id, len) in servos {
        let from = end;
        end += len + 4;
        let Some(said) = answer.get(..end) else { break };
        let (said, crc) = said.split_at(end - 2);
        if said[from + 1] != *id || crc16(said).to_le_bytes() != crc {
            break;
        }
        found.push((*id, said[from], said[from + 2..].to_vec()));
    }
    found
}

/// Computes the CRC-16 with polynomial 8005, high bit first, from 0.
pub(crate) fn crc16(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0, |crc, byte| {
        (0..8).fold(crc ^ (u16::from(*byte) << 8), |crc, _| {
            if crc & 0x8000 == 0 { crc << 1 } else { (crc << 1) ^ 0x8005 }
        })
    })
}

/// Removes an FD after each FF FF FD.
fn unstuffed(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut rest = bytes;
    while let Some((byte, behind)) = rest.split_first() {
        out.push(*byte);
        rest = behind;
        if out.ends_with(&[0xFF, 0xFF, 0xFD]) && rest.first() == Some(&0xFD) {
            rest = &rest[1..];
        }
    }
    out
}
