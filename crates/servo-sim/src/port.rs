//! A serial port of this machine that leads to simulated servos: a pseudo-terminal, and a link to it.

use std::fs::{File, Metadata, TryLockError};
use std::io::{self, ErrorKind};
use std::os::fd::OwnedFd;
use std::os::unix::ffi::OsStrExt as _;
use std::os::unix::fs::{MetadataExt as _, symlink};
use std::path::{Path, PathBuf};
use std::slice;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags, open};
use rustix::io::{Errno, ioctl_fionbio, read, write};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use thiserror::Error;

use crate::line::{Line, LineDevice, next_of, run_all};

/// Interval at which servos are simulated without traffic.
const IDLE: Duration = Duration::from_millis(5);
/// Maximum delay of the machine after which the simulation catches up with real time. After a longer delay, such as
/// a laptop's sleep, the servos' time is not advanced.
const CATCH_UP: Duration = Duration::from_millis(200);

/// The reason why the port could not be opened.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PortError {
    /// A file with the link's name exists and is not a link.
    #[error("{}: exists already and is not a link; choose another name", .0.display())]
    Occupied(PathBuf),
    /// Another running program serves servos at this link.
    #[error("{}: another simulation serves it; end that one, or choose another name", .0.display())]
    Taken(PathBuf),
    /// The link could not be created.
    #[error("{}: {source}", link.display())]
    Link {
        /// Path of the link.
        link: PathBuf,
        /// Cause of the error.
        source: io::Error,
    },
    /// The operating system provides no pseudo-terminal.
    #[error("no pseudo-terminal: {0}")]
    Terminal(#[from] Errno),
}

/// A pseudo-terminal with a link to it, which is removed on drop. Programs may open and close the terminal repeatedly.
#[derive(Debug)]
pub struct Port {
    servos: OwnedFd,
    /// The program's end of the terminal. It is held open: otherwise the terminal would hang up when a program closes
    /// it.
    program: OwnedFd,
    link: PathBuf,
    lock: Lock,
}

/// Lock file beside a link. It is locked while a program serves the link; if the program is killed, the system releases
/// the lock.
#[derive(Debug)]
struct Lock {
    path: PathBuf,
    _file: File,
}

impl Lock {
    fn of(link: &Path) -> Result<Self, PortError> {
        let failed = |source| PortError::Link { link: link.to_owned(), source };
        let name = link.file_name().ok_or_else(|| failed(ErrorKind::InvalidInput.into()))?;
        let path = link.with_file_name(format!(".{}.lock", name.to_string_lossy()));
        loop {
            let file = File::create(&path).map_err(failed)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Err(PortError::Taken(link.to_owned())),
                Err(TryLockError::Error(error)) => return Err(failed(error)),
            }
            // The previous program may have removed the file after this program opened it.
            let own = file.metadata().map_err(failed)?;
            if path.metadata().is_ok_and(|named| named.ino() == own.ino()) {
                return Ok(Self { path, _file: file });
            }
        }
    }
}

impl Port {
    /// Opens a pseudo-terminal, and creates `link` to it. Replaces a link that a killed program has left.
    /// `baud` is the port's rate until a program sets another rate.
    ///
    /// # Errors
    /// [`PortError`] contains the cause.
    pub fn open(link: &Path, baud: u32) -> Result<Self, PortError> {
        let lock = Lock::of(link)?;
        let servos = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
        grantpt(&servos)?;
        unlockpt(&servos)?;
        ioctl_fionbio(&servos, true)?;
        let name = ptsname(&servos, Vec::new())?;
        let program = open(name.as_c_str(), OFlags::RDWR | OFlags::NOCTTY, Mode::empty())?;
        let mut settings = tcgetattr(&program)?;
        settings.make_raw();
        settings.set_speed(baud)?;
        tcsetattr(&program, OptionalActions::Now, &settings)?;

        let failed = |source| PortError::Link { link: link.to_owned(), source };
        match link.symlink_metadata() {
            Ok(found) if !is_link(&found) => return Err(PortError::Occupied(link.to_owned())),
            Ok(_) => std::fs::remove_file(link).map_err(failed)?,
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            Err(error) => return Err(failed(error)),
        }
        symlink(std::ffi::OsStr::from_bytes(name.as_bytes()), link).map_err(failed)?;
        Ok(Self { servos, program, link: link.to_owned(), lock })
    }

    /// Returns the path of the link.
    pub fn link(&self) -> &Path {
        &self.link
    }

    /// Lets programs exchange bytes with the servos of a line: see [`serve`].
    ///
    /// # Errors
    /// An error of the operating system while reading or writing.
    pub fn serve<W: LineDevice>(&self, line: &mut Line<W>, stop: &AtomicBool) -> io::Result<()> {
        serve(slice::from_ref(self), slice::from_mut(line), stop)
    }

    /// Returns the rate that the program has set, bit/s.
    ///
    /// # Errors
    /// An error of the operating system.
    pub fn baud(&self) -> io::Result<u32> {
        Ok(tcgetattr(&self.program)?.output_speed())
    }

    /// Reads the bytes that programs have written, without waiting. Returns their number: 0 if there are none.
    ///
    /// # Errors
    /// An error of the operating system.
    pub fn read(&self, into: &mut [u8]) -> io::Result<usize> {
        match read(&self.servos, into) {
            Err(Errno::AGAIN | Errno::INTR) => Ok(0),
            read => Ok(read?),
        }
    }

    /// Writes bytes to programs. Returns the number of bytes for which there was room.
    ///
    /// # Errors
    /// An error of the operating system.
    pub fn write(&self, bytes: &[u8]) -> io::Result<usize> {
        if bytes.is_empty() {
            return Ok(0);
        }
        match write(&self.servos, bytes) {
            Err(Errno::AGAIN | Errno::INTR) => Ok(0),
            written => Ok(written?),
        }
    }

    /// Passes bytes between a program and the servos. Returns whether the servos had bytes for the program.
    fn pass<W: LineDevice>(&self, line: &mut Line<W>, bytes: &mut [u8]) -> io::Result<bool> {
        match read(&self.servos, &mut *bytes) {
            Ok(count) => {
                line.servos.set_rate(self.baud()?);
                line.write(&bytes[..count]);
            }
            Err(Errno::AGAIN | Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
        let count = line.take(bytes);
        if count > 0 {
            match write(&self.servos, &bytes[..count]) {
                Ok(_) | Err(Errno::AGAIN | Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Ok(count > 0)
    }
}

/// Connects programs to servos in real time, one port for each line, at the rate to which a program sets its port. Ends
/// at most 5 ms after `stop` becomes true. Bytes that a program does not read in time are lost, as on a real port.
///
/// # Errors
/// An error of the operating system while reading or writing, with the port.
pub fn serve<W: LineDevice>(
    ports: &[Port],
    lines: &mut [Line<W>],
    stop: &AtomicBool,
) -> io::Result<()> {
    let time_ns = |lines: &[Line<W>]| lines.iter().map(|line| line.servos.now_ns()).max();
    let begin_ns = time_ns(lines).unwrap_or(0);
    let start = Instant::now();
    let mut lost = Duration::ZERO;
    let mut bytes = [0; 4096];
    while !stop.load(Ordering::Relaxed) {
        let simulated = Duration::from_nanos(time_ns(lines).unwrap_or(0) - begin_ns);
        let passed = start.elapsed().saturating_sub(lost);
        lost += passed.saturating_sub(simulated + CATCH_UP);
        let now = start.elapsed().saturating_sub(lost);
        let now_ns = begin_ns + u64::try_from(now.as_nanos()).unwrap_or(u64::MAX);
        run_all(lines, now_ns);

        let mut has_said = false;
        for (port, line) in ports.iter().zip(&mut *lines) {
            has_said |= port.pass(line, &mut bytes).map_err(|error| {
                io::Error::new(error.kind(), format!("{}: {error}", port.link.display()))
            })?;
        }
        if !has_said {
            let next_ns = next_of(lines).map_or(u64::MAX, |(_, next)| next.saturating_sub(now_ns));
            wait(ports, IDLE.min(Duration::from_nanos(next_ns)))?;
        }
    }
    Ok(())
}

/// Waits until a program writes, at most for a time.
fn wait(ports: &[Port], most: Duration) -> io::Result<()> {
    let timeout = Timespec { tv_sec: 0, tv_nsec: most.subsec_nanos().into() };
    let mut polled: Vec<_> =
        ports.iter().map(|port| PollFd::new(&port.servos, PollFlags::IN)).collect();
    match poll(&mut polled, Some(&timeout)) {
        Ok(_) | Err(Errno::INTR) => Ok(()),
        Err(error) => Err(error.into()),
    }
}

impl Drop for Port {
    fn drop(&mut self) {
        // The link may already have been removed.
        let _ = std::fs::remove_file(&self.link);
        let _ = std::fs::remove_file(&self.lock.path);
    }
}

fn is_link(found: &Metadata) -> bool {
    found.file_type().is_symlink()
}
