//! The token that a page must know.

use std::fmt::Write as _;
use std::hint::black_box;
use std::io;

/// A random number of 128 bits, as 32 hexadecimal digits.
#[derive(Debug, Clone)]
pub(crate) struct Token(String);

impl Token {
    /// Creates a random token.
    pub(crate) fn random() -> io::Result<Self> {
        let mut bytes = [0; 16];
        getrandom::fill(&mut bytes).map_err(io::Error::other)?;
        let mut text = String::new();
        for byte in bytes {
            let _ = write!(text, "{byte:02x}");
        }
        Ok(Self(text))
    }

    /// Returns the 32 digits.
    pub(crate) fn text(&self) -> &str {
        &self.0
    }

    /// Returns whether a text is the token. The time does not depend on the position of the first difference.
    pub(crate) fn is(&self, text: &str) -> bool {
        let (own, other) = (self.0.as_bytes(), text.as_bytes());
        let differs = own.iter().zip(other).fold(0, |sum, (a, b)| black_box(sum | (a ^ b)));
        own.len() == other.len() && differs == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_whole_token_is_the_token() {
        let token = Token::random().unwrap();
        assert_eq!(token.text().len(), 32);
        assert!(token.is(token.text()));
        let mut other = token.text().to_owned();
        let last = if other.pop() == Some('0') { '1' } else { '0' };
        for wrong in
            [other.clone() + &last.to_string(), other, String::new(), token.text().to_owned() + "0"]
        {
            assert!(!token.is(&wrong));
        }
        assert_ne!(Token::random().unwrap().text(), token.text());
    }
}
