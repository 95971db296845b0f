//! Places and words of a text file, as errors show them.

/// A place in a text; both numbers count from 1, columns in characters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Position {
    /// Line; ends are LF, CR LF or CR.
    pub line: usize,
    /// Character in the line.
    pub column: usize,
}

/// A word of the file for a message, cut short and without control characters.
pub(crate) fn shown(word: &str) -> String {
    const LENGTH_MAX: usize = 40;
    let mut shown: String = word.chars().take(LENGTH_MAX).flat_map(char::escape_debug).collect();
    if word.chars().nth(LENGTH_MAX).is_some() {
        shown.push('…');
    }
    shown
}

/// What stands where something else was expected: a word of the file, or in words that it is none.
pub(crate) fn found(word: &str) -> String {
    if word.contains(|c: char| c.is_control() || c == char::REPLACEMENT_CHARACTER) {
        return "bytes that are no text".to_owned();
    }
    format!("`{}`", shown(word))
}

/// `count` things: "1 frame", "2 frames".
pub fn counted(count: usize, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}
