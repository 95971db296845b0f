//! Converts a file's bytes to text: UTF-8, or UTF-16 in either byte order, which some Windows programs write.

use std::borrow::Cow;

/// Encoding of characters as bytes.
#[derive(Clone, Copy)]
enum Encoding {
    Utf8,
    Utf16(fn([u8; 2]) -> u16),
}

/// Bytes that are not valid text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("expected text in {encoding}, found other bytes from byte {at} on: save the file as UTF-8")]
pub struct EncodingError {
    encoding: &'static str,
    at: usize,
}

impl EncodingError {
    /// Returns the offset of the first invalid byte.
    pub const fn at(self) -> usize {
        self.at
    }
}

/// Returns the text of a file, without its byte order mark.
///
/// # Errors
/// [`EncodingError`] at the first invalid character.
pub fn decoded(bytes: &[u8]) -> Result<Cow<'_, str>, EncodingError> {
    match of(bytes) {
        (Encoding::Utf8, mark) => core::str::from_utf8(&bytes[mark..])
            .map(Cow::Borrowed)
            .map_err(|error| EncodingError { encoding: "UTF-8", at: mark + error.valid_up_to() }),
        (Encoding::Utf16(unit), mark) => {
            let mut at = mark;
            let mut text = String::with_capacity(bytes.len() / 2);
            for character in utf16(&bytes[mark..], unit) {
                let character = character.ok_or(EncodingError { encoding: "UTF-16", at })?;
                at += 2 * character.len_utf16();
                text.push(character);
            }
            Ok(text.into())
        }
    }
}

/// Returns the text of a file whose names may be in an old encoding: invalid characters are replaced.
pub fn lossy(bytes: &[u8]) -> Cow<'_, str> {
    match of(bytes) {
        (Encoding::Utf8, mark) => String::from_utf8_lossy(&bytes[mark..]),
        (Encoding::Utf16(unit), mark) => utf16(&bytes[mark..], unit)
            .map(|character| character.unwrap_or(char::REPLACEMENT_CHARACTER))
            .collect(),
    }
}

/// Returns the encoding of a text, and the length of its byte order mark. Without a mark, the first character
/// decides: it is ASCII, which in UTF-16 is a zero byte and another byte.
fn of(bytes: &[u8]) -> (Encoding, usize) {
    match bytes {
        [0xef, 0xbb, 0xbf, ..] => (Encoding::Utf8, 3),
        [0xff, 0xfe, ..] => (Encoding::Utf16(u16::from_le_bytes), 2),
        [0xfe, 0xff, ..] => (Encoding::Utf16(u16::from_be_bytes), 2),
        [1..=0xff, 0, ..] => (Encoding::Utf16(u16::from_le_bytes), 0),
        [0, 1..=0xff, ..] => (Encoding::Utf16(u16::from_be_bytes), 0),
        _ => (Encoding::Utf8, 0),
    }
}

/// Returns the characters, and `None` for an incomplete one.
fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> impl Iterator<Item = Option<char>> {
    let pairs = bytes.chunks_exact(2);
    let half = (!pairs.remainder().is_empty()).then_some(None);
    char::decode_utf16(pairs.map(move |pair| unit([pair[0], pair[1]]))).map(Result::ok).chain(half)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a text in UTF-16, in both byte orders, with and without a mark.
    fn in_utf16(text: &str) -> [Vec<u8>; 4] {
        let bytes = |mark: &str, of: fn(u16) -> [u8; 2]| -> Vec<u8> {
            mark.encode_utf16().chain(text.encode_utf16()).flat_map(of).collect()
        };
        [
            bytes("\u{feff}", u16::to_le_bytes),
            bytes("\u{feff}", u16::to_be_bytes),
            bytes("", u16::to_le_bytes),
            bytes("", u16::to_be_bytes),
        ]
    }

    #[test]
    fn texts_are_read_in_each_encoding() {
        let text = "ROOT Hüfte 髋 \u{1f9b4}\n";
        for bytes in in_utf16(text) {
            assert_eq!(decoded(&bytes).unwrap(), text);
            assert_eq!(lossy(&bytes), text);
        }
        for mark in ["", "\u{feff}"] {
            let bytes = format!("{mark}{text}").into_bytes();
            assert_eq!(decoded(&bytes).unwrap(), text);
            assert_eq!(lossy(&bytes), text);
        }
        assert_eq!(decoded(b"").unwrap(), "");
    }

    #[test]
    fn what_is_no_character_is_told_or_replaced() {
        let [mut cut, ..] = in_utf16("ab");
        cut.pop();
        let error = decoded(&cut).unwrap_err().to_string();
        assert!(
            error.starts_with("expected text in UTF-16, found other bytes from byte 4 on"),
            "{error}"
        );
        assert_eq!(lossy(&cut), "a\u{fffd}");
        // The second half of a character without the first.
        let half = [0xff, 0xfe, b'a', 0, 0, 0xdc, b'b', 0];
        assert_eq!(decoded(&half).unwrap_err().at, 4);
        assert_eq!(lossy(&half), "a\u{fffd}b");
        let error = decoded(b"\xef\xbb\xbfa\xff").unwrap_err();
        assert_eq!(error, EncodingError { encoding: "UTF-8", at: 4 });
        assert_eq!(lossy(b"H\xfcfte"), "H\u{fffd}fte");
    }
}
