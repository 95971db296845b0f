//! Parses the host's commands, one per line.

use std::io::BufRead;

use crate::board::Port;

/// A command of the host.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Command {
    /// Runs until a time, or until the firmware has sent a burst on the bus.
    Run(u64),
    /// Sends bytes on a line, starting at a time.
    Say(Port, u64, Vec<u8>),
    /// Puts a level on a pin, by port (0: A) and number.
    Pin(usize, u8, bool),
    /// Presses the reset button.
    Reset,
    /// Stops the core until a reset; everything else continues.
    Hang,
    /// Prints the content of flash.
    Flash,
}

pub struct Line;

impl Line {
    /// Reads the next command, or returns an error for an invalid line. Returns `None` if the host is done.
    pub fn read(input: &mut impl BufRead) -> Option<Result<Command, String>> {
        let mut line = String::new();
        if input.read_line(&mut line).ok()? == 0 {
            return None;
        }
        let words: Vec<&str> = line.split_whitespace().collect();
        Some(parsed(&words).ok_or_else(|| format!("unknown command `{}`", line.trim_end())))
    }
}

fn parsed(words: &[&str]) -> Option<Command> {
    Some(match words {
        ["run", to] => Command::Run(to.parse().ok()?),
        ["bus", from, bytes] => Command::Say(Port::Bus, from.parse().ok()?, from_hex(bytes)?),
        ["link", from, bytes] => Command::Say(Port::Link, from.parse().ok()?, from_hex(bytes)?),
        ["pin", name, level] => {
            let (port, pin) = name.strip_prefix('P')?.split_at_checked(1)?;
            let port = "ABCDEFGH".find(port)?;
            Command::Pin(port, pin.parse().ok().filter(|pin| *pin < 16)?, *level == "1")
        }
        ["reset"] => Command::Reset,
        ["hang"] => Command::Hang,
        ["flash"] => Command::Flash,
        _ => return None,
    })
}

fn from_hex(text: &str) -> Option<Vec<u8>> {
    let digits = text.as_bytes().chunks(2);
    digits.map(|pair| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok()).collect()
}

/// Formats bytes as hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    use std::fmt::Write as _;
    bytes.iter().fold(String::with_capacity(2 * bytes.len()), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}
