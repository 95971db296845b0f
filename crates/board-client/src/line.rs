//! Sends bytes to a controller and receives bytes from it.

use std::fs::File;
use std::io;
use std::path::Path;
use std::time::{Duration, Instant};

use serial2::SerialPort;
use sinew_servo_tools::{ServiceError, open_alone};

/// A line to a controller, with a clock: that of the machine, or that of an emulator.
pub trait Line {
    /// Sends all bytes.
    ///
    /// # Errors
    /// An I/O error if the line has failed.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Receives bytes. If there are none, waits for at most `wait`. Returns the number of bytes, 0 if none arrived.
    ///
    /// # Errors
    /// An I/O error if the line has failed.
    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize>;

    /// Returns the time since an arbitrary start; it never decreases.
    fn now(&self) -> Duration;
}

impl<L: Line + ?Sized> Line for Box<L> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        (**self).send(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        (**self).receive(into, wait)
    }

    fn now(&self) -> Duration {
        (**self).now()
    }
}

/// A serial port that only this program uses.
#[derive(Debug)]
pub struct SerialBoard {
    port: SerialPort,
    /// Lock on the port, held until the value is dropped.
    _lock: File,
    start: Instant,
}

impl SerialBoard {
    /// Opens a port at a rate in bit/s, with 8 data bits, no parity and 1 stop bit.
    ///
    /// # Errors
    /// [`ServiceError::Port`] with the problem of the port and its remedy.
    pub fn open(path: &Path, baud: u32) -> Result<Self, ServiceError> {
        let (port, lock) = open_alone(path, baud)?;
        Ok(Self { port, _lock: lock, start: Instant::now() })
    }
}

impl Line for SerialBoard {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.port.write_all(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        // Below a millisecond the port would not time out at all.
        self.port.set_read_timeout(wait.max(Duration::from_millis(1)))?;
        match self.port.read(into) {
            Ok(0) => Err(io::ErrorKind::UnexpectedEof.into()),
            // An interrupting signal is handled elsewhere.
            Err(error)
                if matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::Interrupted) =>
            {
                Ok(0)
            }
            read => read,
        }
    }

    fn now(&self) -> Duration {
        self.start.elapsed()
    }
}
