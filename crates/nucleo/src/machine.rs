//! The emulator as a process. Commands and events are lines of text.

use std::ffi::OsStr;
use std::io::{self, BufRead as _, BufReader, BufWriter, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use thiserror::Error;

/// The reason why the emulated board is not available.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MachineError {
    /// The emulator could not be started.
    #[error("{0}: the emulator cannot be started ({1}); `cargo xtask emulate` builds it")]
    NoEmulator(String, #[source] io::Error),
    /// The emulator has ended.
    #[error("the emulator has ended: its output is above")]
    Ended(#[source] io::Error),
    /// The emulator sent a line that is not in its protocol.
    #[error("the emulator says `{0}`: it is of another version; `cargo xtask emulate` rebuilds it")]
    Version(String),
}

/// A serial port of the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Port {
    /// USART1: the bus of the servos.
    Bus,
    /// USART2: the host link.
    Link,
}

/// An event of the emulated board. Times are in ns since power-on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MachineEvent {
    /// Consecutive bytes that the board sent on the bus.
    Bus {
        /// Time at which the last byte had left.
        end_ns: u64,
        /// Baud rate, bits per second.
        baud: u32,
        /// Bytes that were sent.
        bytes: Vec<u8>,
    },
    /// Bytes on the host link, with the time at which the last of them had left.
    Link(u64, Vec<u8>),
    /// Number of bytes that were sent to a port that did not listen.
    Unheard(Port, u64),
    /// The board restarted: time and cause (`pin`: the button, `iwdg`: the watchdog, `core`: the program itself).
    Reset(u64, String),
    /// An erase of a flash sector begins; the core stops meanwhile.
    Erase(u64, usize),
    /// An erase of a flash sector has ended.
    Erased(u64, usize),
    /// The core accesses memory that does not exist, for example beyond the end of its stack: time, address, and
    /// address of the instruction. Reported only once. The real chip would fault; the emulator reads 0.
    Stray(u64, u32, u32),
    /// The light was switched on or off.
    Light(u64, bool),
}

/// The state after a run: time and events.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stopped {
    /// Time of the stop: at most the requested time, ns.
    pub at_ns: u64,
    /// Events during the run.
    pub heard: Vec<MachineEvent>,
}

/// An emulated board, which runs only during calls.
#[derive(Debug)]
pub struct Machine {
    tool: Child,
    to: BufWriter<ChildStdin>,
    from: BufReader<ChildStdout>,
}

impl Machine {
    /// Starts the emulator and powers the board on with an image (ELF). `flash` is a file with the flash contents at an
    /// earlier loss of power; without it, the flash contains only the image. The emulator is ended when this value is
    /// dropped.
    ///
    /// # Errors
    /// [`MachineError`] if the emulator or the image does not exist.
    pub fn start(
        tool: impl AsRef<OsStr>,
        image: &Path,
        flash: Option<&Path>,
    ) -> Result<Self, MachineError> {
        let mut command = Command::new(&tool);
        command.arg(image).args(flash).stdin(Stdio::piped()).stdout(Stdio::piped());
        // Ctrl-C on a terminal must reach only this program, which uses it to stop the rig.
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

    /// Runs until a time, or until the board has sent on the bus, or has restarted.
    ///
    /// # Errors
    /// [`MachineError`] if the emulator has ended.
    pub fn run(&mut self, to_ns: u64) -> Result<Stopped, MachineError> {
        self.tell(&format!("run {to_ns}"))?;
        self.to.flush().map_err(MachineError::Ended)?;
        self.stopped()
    }

    /// Sends bytes to a port, the first at `from_ns`.
    ///
    /// # Errors
    /// [`MachineError`] if the emulator has ended.
    pub fn say(&mut self, port: Port, from_ns: u64, bytes: &[u8]) -> Result<(), MachineError> {
        let port = match port {
            Port::Bus => "bus",
            Port::Link => "link",
        };
        self.tell(&format!("{port} {from_ns} {}", hex(bytes)))
    }

    /// Sets the level of a pin, such as `PC8`.
    ///
    /// # Errors
    /// [`MachineError`] if the emulator has ended.
    pub fn pin(&mut self, pin: &str, is_high: bool) -> Result<(), MachineError> {
        self.tell(&format!("pin {pin} {}", u8::from(is_high)))
    }

    /// Presses the reset button.
    ///
    /// # Errors
    /// [`MachineError`] if the emulator has ended.
    pub fn reset(&mut self) -> Result<(), MachineError> {
        self.tell("reset")
    }

    /// Stops the core until a reset; timers, DMA and the watchdog continue.
    ///
    /// # Errors
    /// [`MachineError`] if the emulator has ended.
    pub fn hang(&mut self) -> Result<(), MachineError> {
        self.tell("hang")
    }

    /// Returns the flash contents, as they would remain if power were lost now.
    ///
    /// # Errors
    /// [`MachineError`] if the emulator has ended.
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
        // The emulator may have ended by itself.
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
