//! The tool as a process: what it is told and what it tells, a line of text each.

use std::ffi::OsStr;
use std::io::{self, BufRead as _, BufReader, BufWriter, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use thiserror::Error;

/// Why there is no emulated board any more.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MachineError {
    /// The tool cannot be started.
    #[error("{0}: the emulator cannot be started ({1}); `cargo xtask emulate` builds it")]
    NoEmulator(String, #[source] io::Error),
    /// It has ended.
    #[error("the emulator has ended: what it said stands above")]
    Ended(#[source] io::Error),
    /// It says what is not in its protocol.
    #[error(
        "the emulator says `{0}`: it is of another version; `cargo xtask emulate` builds it anew"
    )]
    Version(String),
}

/// A serial port of the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Port {
    /// USART1: the servos.
    Bus,
    /// USART2: the link.
    Link,
}

/// What the machine did. Times are since power-on, ns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MachineEvent {
    /// Bytes one behind the other on the bus: when the last of them had left, at how many bits per second.
    Bus {
        /// When.
        end_ns: u64,
        /// Bits per second.
        baud: u32,
        /// Which.
        bytes: Vec<u8>,
    },
    /// Bytes of the link, and when the last of them had left.
    Link(u64, Vec<u8>),
    /// So many bytes were said to a port that did not listen.
    Unheard(Port, u64),
    /// It has begun anew: when, and by what (`pin`: the button, `iwdg`: the watchdog, `core`: itself).
    Reset(u64, String),
    /// An erase of a flash sector begins. The core stands still.
    Erase(u64, usize),
    /// It is over.
    Erased(u64, usize),
    /// The core reaches for memory that is not there, as behind the end of its stack: when, where, and from which
    /// instruction. Told once. The chip would fault; here it reads 0.
    Stray(u64, u32, u32),
    /// The light is on, or off.
    Light(u64, bool),
}

/// Where it stands, and what it did on its way.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stopped {
    /// Where: at most where it was to run to.
    pub at_ns: u64,
    /// What it did.
    pub heard: Vec<MachineEvent>,
}

/// An emulated board that stands still.
#[derive(Debug)]
pub struct Machine {
    tool: Child,
    to: BufWriter<ChildStdin>,
    from: BufReader<ChildStdout>,
}

impl Machine {
    /// Power-on with an image (ELF). `flash`: a file of what its flash held when power was lost; else it is empty but
    /// for the image. The tool ends with this value.
    ///
    /// # Errors
    /// [`MachineError`] if the tool or the image is not there.
    pub fn start(
        tool: impl AsRef<OsStr>,
        image: &Path,
        flash: Option<&Path>,
    ) -> Result<Self, MachineError> {
        let mut command = Command::new(&tool);
        command.arg(image).args(flash).stdin(Stdio::piped()).stdout(Stdio::piped());
        // Ctrl-C on a terminal is for this program, which stops the rig by it.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let name = || tool.as_ref().to_string_lossy().into_owned();
        let mut tool = command.spawn().map_err(|why| MachineError::NoEmulator(name(), why))?;
        let pipes = tool.stdin.take().zip(tool.stdout.take());
        let (to, from) = pipes.expect("both are piped");
        let mut machine = Self { tool, to: BufWriter::new(to), from: BufReader::new(from) };
        machine.stopped()?;
        Ok(machine)
    }

    /// Runs until a time, or until something has been said on the bus, or it has begun anew.
    ///
    /// # Errors
    /// [`MachineError`] if the tool has ended.
    pub fn run(&mut self, to_ns: u64) -> Result<Stopped, MachineError> {
        self.tell(&format!("run {to_ns}"))?;
        self.to.flush().map_err(MachineError::Ended)?;
        self.stopped()
    }

    /// Says bytes to a port, the first from a time on.
    ///
    /// # Errors
    /// [`MachineError`] if the tool has ended.
    pub fn say(&mut self, port: Port, from_ns: u64, bytes: &[u8]) -> Result<(), MachineError> {
        let port = match port {
            Port::Bus => "bus",
            Port::Link => "link",
        };
        self.tell(&format!("{port} {from_ns} {}", hex(bytes)))
    }

    /// Puts a level on a pin, as `PC8`.
    ///
    /// # Errors
    /// [`MachineError`] if the tool has ended.
    pub fn pin(&mut self, pin: &str, is_high: bool) -> Result<(), MachineError> {
        self.tell(&format!("pin {pin} {}", u8::from(is_high)))
    }

    /// Presses the reset button.
    ///
    /// # Errors
    /// [`MachineError`] if the tool has ended.
    pub fn reset(&mut self) -> Result<(), MachineError> {
        self.tell("reset")
    }

    /// Hangs its core until a reset; timers, DMA and the watchdog go on.
    ///
    /// # Errors
    /// [`MachineError`] if the tool has ended.
    pub fn hang(&mut self) -> Result<(), MachineError> {
        self.tell("hang")
    }

    /// What flash holds: what it would if power were lost now.
    ///
    /// # Errors
    /// [`MachineError`] if the tool has ended.
    pub fn flash(&mut self) -> Result<Vec<u8>, MachineError> {
        self.tell("flash")?;
        self.to.flush().map_err(MachineError::Ended)?;
        let line = self.line()?;
        let bytes = line.strip_prefix("flash ").and_then(from_hex);
        bytes.ok_or(MachineError::Version(line))
    }

    fn tell(&mut self, line: &str) -> Result<(), MachineError> {
        writeln!(self.to, "{line}").map_err(MachineError::Ended)
    }

    fn line(&mut self) -> Result<String, MachineError> {
        let mut line = String::new();
        let len = self.from.read_line(&mut line).map_err(MachineError::Ended)?;
        if len == 0 {
            return Err(MachineError::Ended(io::ErrorKind::UnexpectedEof.into()));
        }
        Ok(line.trim_end().to_owned())
    }

    fn stopped(&mut self) -> Result<Stopped, MachineError> {
        let mut heard = Vec::new();
        loop {
            let line = self.line()?;
            let words: Vec<&str> = line.split(' ').collect();
            if let ["at", at_ns] = words.as_slice() {
                let at_ns = at_ns.parse().map_err(|_| MachineError::Version(line.clone()))?;
                return Ok(Stopped { at_ns, heard });
            }
            heard.push(parsed(&words).ok_or_else(|| MachineError::Version(line.clone()))?);
        }
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.tool.kill();
        let _ = self.tool.wait();
    }
}

fn parsed(words: &[&str]) -> Option<MachineEvent> {
    Some(match *words {
        ["bus", end_ns, baud, bytes] => MachineEvent::Bus {
            end_ns: end_ns.parse().ok()?,
            baud: baud.parse().ok()?,
            bytes: from_hex(bytes)?,
        },
        ["link", end_ns, bytes] => MachineEvent::Link(end_ns.parse().ok()?, from_hex(bytes)?),
        ["unheard", "bus", count] => MachineEvent::Unheard(Port::Bus, count.parse().ok()?),
        ["unheard", "link", count] => MachineEvent::Unheard(Port::Link, count.parse().ok()?),
        ["reset", at_ns, by] => MachineEvent::Reset(at_ns.parse().ok()?, by.to_owned()),
        ["erase", at_ns, sector] => MachineEvent::Erase(at_ns.parse().ok()?, sector.parse().ok()?),
        ["erased", at_ns, sector] => {
            MachineEvent::Erased(at_ns.parse().ok()?, sector.parse().ok()?)
        }
        ["stray", at_ns, address, from] => MachineEvent::Stray(
            at_ns.parse().ok()?,
            u32::from_str_radix(address, 16).ok()?,
            u32::from_str_radix(from, 16).ok()?,
        ),
        ["light", at_ns, level] => MachineEvent::Light(at_ns.parse().ok()?, level == "1"),
        _ => return None,
    })
}

fn hex(bytes: &[u8]) -> String {
    use std::fmt::Write as _;
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

fn from_hex(text: &str) -> Option<Vec<u8>> {
    let digits = text.as_bytes().chunks(2);
    digits.map(|pair| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok()).collect()
}
