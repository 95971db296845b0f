//! Converts a file's bytes to text: UTF-8, or UTF-16 in either byte order, which some Windows programs write. Names in
//! older files may be in Latin-1 or GBK.

use std::borrow::Cow;

use encoding_rs::{GBK, WINDOWS_1252};

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

/// Returns the text of a file, without its byte order mark. XML may be in the encoding that it declares, or in Latin-1
/// or GBK.
///
/// # Errors
/// [`EncodingError`] at the first invalid character.
pub fn decoded(bytes: &[u8]) -> Result<Cow<'_, str>, EncodingError> {
    match of(bytes) {
        (Encoding::Utf8, mark) => match core::str::from_utf8(&bytes[mark..]) {
            Ok(text) => Ok(Cow::Borrowed(text)),
            Err(_) if is_xml(bytes) => Ok(old(bytes)),
            Err(error) => Err(EncodingError { encoding: "UTF-8", at: mark + error.valid_up_to() }),
        },
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

/// Returns the text of a file whose names may be in an old encoding: Latin-1 or GBK. Invalid characters are replaced.
pub fn lossy(bytes: &[u8]) -> Cow<'_, str> {
    match of(bytes) {
        // A file with a mark is UTF-8.
        (Encoding::Utf8, mark @ 1..) => String::from_utf8_lossy(&bytes[mark..]),
        (Encoding::Utf8, _) => match core::str::from_utf8(bytes) {
            Ok(text) => Cow::Borrowed(text),
            Err(_) => old(bytes),
        },
        (Encoding::Utf16(unit), mark) => utf16(&bytes[mark..], unit)
            .map(|character| character.unwrap_or(char::REPLACEMENT_CHARACTER))
            .collect(),
    }
}

fn is_xml(bytes: &[u8]) -> bool {
    bytes.trim_ascii_start().starts_with(b"<")
}

/// Returns a text that is not UTF-8: in the encoding that XML declares, otherwise in GBK if all its other bytes are
/// pairs of that, otherwise in Latin-1 as Windows extends it.
fn old(bytes: &[u8]) -> Cow<'_, str> {
    let declared = declared(bytes).filter(|encoding| *encoding != encoding_rs::UTF_8);
    let guess = if is_in_pairs(bytes) { GBK } else { WINDOWS_1252 };
    declared.unwrap_or(guess).decode_without_bom_handling(bytes).0
}

/// Returns the encoding that an XML declaration names; `None` if there is no declaration, or if the name is unknown.
fn declared(bytes: &[u8]) -> Option<&'static encoding_rs::Encoding> {
    /// Number of bytes within which a declaration ends.
    const LOOKED_AT: usize = 512;
    if !is_xml(bytes) {
        return None;
    }
    let begin = String::from_utf8_lossy(bytes.get(..LOOKED_AT).unwrap_or(bytes));
    let (_, declaration) = begin.split_once("<?xml")?;
    let (declaration, _) = declaration.split_once("?>")?;
    let (_, value) = declaration.split_once("encoding")?;
    let value = value.trim_start().strip_prefix('=')?.trim_start();
    let label = value.trim_start_matches(['"', '\'']).split(['"', '\'']).next()?;
    encoding_rs::Encoding::for_label(label.as_bytes())
}

/// Returns whether all bytes that are not ASCII are pairs of the Chinese characters of GB 2312, whose two bytes are
/// both above 0xa0. A letter of Latin-1 usually has ASCII letters beside it.
fn is_in_pairs(bytes: &[u8]) -> bool {
    let mut runs = bytes.split(u8::is_ascii).filter(|run| !run.is_empty());
    runs.all(|run| run.len() % 2 == 0 && run.iter().all(|byte| *byte > 0xa0))
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
        assert_eq!(lossy(b"\xef\xbb\xbfH\xfcfte"), "H\u{fffd}fte");
    }

    #[test]
    fn old_encodings_are_read() {
        assert_eq!(lossy(b"H\xfcfte"), "H\u{fc}fte");
        assert_eq!(lossy(b"JOINT \xd7\xf3\xcd\xc8\n{"), "JOINT \u{5de6}\u{817f}\n{");
        let xml = b" <robot name=\"H\xfcfte\"/>";
        assert_eq!(decoded(xml).unwrap(), " <robot name=\"H\u{fc}fte\"/>");
        let declared = b"<?xml version='1.0' encoding='GBK'?><robot name='\x81\x40'/>";
        assert!(decoded(declared).unwrap().contains("name='\u{4e02}'"));
        assert!(decoded(b"name = \"H\xfcfte\"").is_err());
    }
}
