//! A serial port of this machine that leads to simulated servos: a pseudo-terminal, and a link to it.

use std::fs::Metadata;
use std::io::{self, ErrorKind};
use std::os::fd::OwnedFd;
use std::os::unix::ffi::OsStrExt as _;
use std::os::unix::fs::symlink;
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

/// Servos move on after so long, though nobody says anything.
const IDLE: Duration = Duration::from_millis(5);
/// What the machine is late by beyond this is taken out of the servos' time, not made good: a laptop that slept.
const CATCH_UP: Duration = Duration::from_millis(200);

/// Why there is no port.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PortError {
    /// Something else has its name.
    #[error("{}: is there already and is no link; choose another name", .0.display())]
    Occupied(PathBuf),
    /// The link cannot be made.
    #[error("{}: {source}", link.display())]
    Link {
        /// Where.
        link: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The machine gives no pseudo-terminal.
    #[error("no pseudo-terminal: {0}")]
    Terminal(#[from] Errno),
}

/// A pseudo-terminal with a link to it, that is gone when this is dropped. Programs may open and close it as often as
/// they like.
#[derive(Debug)]
pub struct Port {
    servos: OwnedFd,
    /// Held open: else the terminal hangs up when a program closes it.
    program: OwnedFd,
    link: PathBuf,
}

impl Port {
    /// Opens a terminal, and makes `link` lead to it. A link that is there is replaced: a program that was killed left
    /// it. `baud` is what the port is set to until a program sets it.
    ///
    /// # Errors
    /// [`PortError`].
    pub fn open(link: &Path, baud: u32) -> Result<Self, PortError> {
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
        Ok(Self { servos, program, link: link.to_owned() })
    }

    /// Where it is.
    pub fn link(&self) -> &Path {
        &self.link
    }

    /// Lets programs talk to the servos of a line: see [`serve`].
    ///
    /// # Errors
    /// What the system says if reading or writing fails.
    pub fn serve<W: LineDevice>(&self, line: &mut Line<W>, stop: &AtomicBool) -> io::Result<()> {
        serve(slice::from_ref(self), slice::from_mut(line), stop)
    }

    /// What programs have written, at once; 0 if they have written nothing.
    ///
    /// # Errors
    /// What the system says.
    pub fn read(&self, into: &mut [u8]) -> io::Result<usize> {
        match read(&self.servos, into) {
            Err(Errno::AGAIN | Errno::INTR) => Ok(0),
            read => Ok(read?),
        }
    }

    /// Gives bytes to programs: how many there was room for.
    ///
    /// # Errors
    /// What the system says.
    pub fn write(&self, bytes: &[u8]) -> io::Result<usize> {
        if bytes.is_empty() {
            return Ok(0);
        }
        match write(&self.servos, bytes) {
            Err(Errno::AGAIN | Errno::INTR) => Ok(0),
            written => Ok(written?),
        }
    }

    /// Takes what a program has written, and gives it what servos have said. Whether there was something to give.
    fn pass<W: LineDevice>(&self, line: &mut Line<W>, bytes: &mut [u8]) -> io::Result<bool> {
        match read(&self.servos, &mut *bytes) {
            Ok(count) => {
                line.servos.set_rate(tcgetattr(&self.program)?.output_speed());
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

/// Lets programs talk to servos in real time, a port for each line, at the rate to which they set the port, until
/// `stop` is true: within 5 ms of that. What a program does not read in time is lost, as it is behind a real port.
///
/// # Errors
/// What the system says if reading or writing fails, and at which port.
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

/// Until a program writes, or for a time.
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
        // Gone already is as good.
        let _ = std::fs::remove_file(&self.link);
    }
}

fn is_link(found: &Metadata) -> bool {
    found.file_type().is_symlink()
}
