//! Bytes to a controller and back.

use std::fs::File;
use std::io;
use std::path::Path;
use std::time::{Duration, Instant};

use serial2::SerialPort;
use sinew_servo_tools::{ServiceError, open_alone};

/// A line to a controller, with a clock: that of the machine, or an emulator's own.
pub trait Line {
    /// Sends all bytes.
    ///
    /// # Errors
    /// What the line says: it is gone.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// What has come, at once or after up to `wait`: how many bytes, 0 if none came.
    ///
    /// # Errors
    /// What the line says: it is gone.
    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize>;

    /// Time since any beginning; it never goes back.
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

/// A serial port that no other program has.
#[derive(Debug)]
pub struct SerialBoard {
    port: SerialPort,
    /// Holds the lock on the port as long as it lives.
    _lock: File,
    start: Instant,
}

impl SerialBoard {
    /// Opens a port, 8N1, bits per second.
    ///
    /// # Errors
    /// [`ServiceError::Port`] says what is wrong with the port and what helps.
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
        // A timeout below a millisecond would be none at all.
        self.port.set_read_timeout(wait.max(Duration::from_millis(1)))?;
        match self.port.read(into) {
            Ok(0) => Err(io::ErrorKind::UnexpectedEof.into()),
            // A signal that came meanwhile is told elsewhere.
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
