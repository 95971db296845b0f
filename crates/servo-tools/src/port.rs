//! Opens a serial port exclusively, and uses it as a line of servos.

use std::fs::File;
use std::io;
use std::os::fd::AsFd as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serial2::SerialPort;

use crate::{Exchange, ServiceError};

/// A serial port that is locked for this program. A pseudo-terminal works too; it accepts any baud rate.
#[derive(Debug)]
pub struct SerialLine {
    port: SerialPort,
    /// File that holds the lock on the port while it is open.
    _lock: File,
}

impl SerialLine {
    /// Opens a port with 8N1.
    ///
    /// # Errors
    /// [`ServiceError::Port`] contains the cause and the remedy: missing permission, another program, no such port.
    pub fn open(path: &Path) -> Result<Self, ServiceError> {
        // A rate that every port supports; the servos' rate is set before the first exchange.
        let (port, lock) = open_alone(path, 57_600)?;
        Ok(Self { port, _lock: lock })
    }
}

/// Opens a port with 8N1, and locks it against other programs while the returned file is open.
///
/// # Errors
/// [`ServiceError::Port`], like [`SerialLine::open`].
pub fn open_alone(path: &Path, baud: u32) -> Result<(SerialPort, File), ServiceError> {
    let refused =
        |error: io::Error| ServiceError::Port { path: path.to_owned(), what: help(path, &error) };
    let port = SerialPort::open(path, baud).map_err(refused)?;
    let lock = port.as_fd().try_clone_to_owned().map(File::from).map_err(refused)?;
    lock.try_lock().map_err(|error| match error {
        std::fs::TryLockError::WouldBlock => refused(io::ErrorKind::ResourceBusy.into()),
        std::fs::TryLockError::Error(error) => refused(error),
    })?;
    Ok((port, lock))
}

/// Returns the USB serial ports of this machine: only these can have servos at the other end.
pub fn usb_ports() -> Vec<PathBuf> {
    let all = SerialPort::available_ports().unwrap_or_default();
    all.into_iter().filter(|port| is_usb(port)).collect()
}

fn is_usb(port: &Path) -> bool {
    let name = port.to_string_lossy();
    name.contains("USB") || name.contains("ACM") || name.contains("usb")
}

impl Exchange for SerialLine {
    fn exchange(
        &mut self,
        bytes: &[u8],
        wait: Duration,
        take: &mut dyn FnMut(&[u8]) -> bool,
    ) -> io::Result<()> {
        let end = Instant::now() + wait;
        self.port.discard_input_buffer()?;
        self.port.write_all(bytes)?;
        let mut buffer = [0; 1024];
        loop {
            // Not less than a millisecond: a shorter timeout would mean no timeout.
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(());
            }
            self.port.set_read_timeout(left.max(Duration::from_millis(1)))?;
            match self.port.read(&mut buffer) {
                Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
                Ok(count) => {
                    if take(buffer.get(..count).unwrap_or_default()) {
                        return Ok(());
                    }
                }
                Err(error) if error.kind() == io::ErrorKind::TimedOut => return Ok(()),
                // A signal arrived: the read continues.
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }

    fn set_baud(&mut self, baud: u32) -> io::Result<()> {
        let mut settings = self.port.get_configuration()?;
        settings.set_baud_rate(baud)?;
        self.port.set_configuration(&settings)
    }

    fn pause(&mut self, time: Duration) {
        std::thread::sleep(time);
    }
}

/// Returns cause and remedy of a port error.
fn help(path: &Path, error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => not_there(&SerialPort::available_ports().unwrap_or_default()),
        io::ErrorKind::PermissionDenied => "you may not open it. On Linux serial ports belong to a group, mostly \
            `dialout` (`ls -l` on the port says which): `sudo usermod -aG dialout $USER`, then log out and in again. \
            Or give all users one kind of adapter by a udev rule, such as `SUBSYSTEM==\"tty\", \
            ATTRS{idVendor}==\"0403\", MODE=\"0666\"` in /etc/udev/rules.d/99-servos.rules"
            .to_owned(),
        io::ErrorKind::ResourceBusy => format!(
            "another program has it. `fuser {}` says which; on desktops ModemManager opens new ports for some seconds",
            path.display()
        ),
        _ if error.raw_os_error() == Some(NOT_A_TERMINAL) => {
            "it is no serial port; expected one such as /dev/ttyUSB0 or /dev/ttyACM0".to_owned()
        }
        _ => error.to_string(),
    }
}

/// Error code ENOTTY, the same on Linux and macOS.
const NOT_A_TERMINAL: i32 = 25;

fn not_there(ports: &[std::path::PathBuf]) -> String {
    // A PC also lists ports of its mainboard that have no plug; adapters have USB drivers.
    let names: Vec<_> = ports.iter().map(|port| port.display().to_string()).collect();
    let (usb, other): (Vec<_>, Vec<_>) =
        names.iter().partition(|name| name.contains("USB") || name.contains("ACM"));
    let join =
        |names: &[&String]| names.iter().map(|name| name.as_str()).collect::<Vec<_>>().join(", ");
    match (usb.as_slice(), other.as_slice()) {
        ([], []) => {
            "there is no such port, and no other one either. Is the adapter plugged in?".to_owned()
        }
        ([], other) => format!(
            "there is no such port. There are: {}, none of them on USB. Is the adapter plugged in?",
            join(other)
        ),
        (usb, _) => format!("there is no such port. On USB there are: {}", join(usb)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(path: &Path) -> String {
        SerialLine::open(path).unwrap_err().to_string()
    }

    #[test]
    fn what_is_no_port_is_refused_with_what_would_be_right() {
        let text = refusal(Path::new("/dev/no-such-port"));
        assert!(text.starts_with("/dev/no-such-port: there is no such port"), "{text}");
        let file = tempfile::NamedTempFile::new().unwrap();
        let text = refusal(file.path());
        assert!(text.contains("no serial port") && text.contains("/dev/ttyUSB0"), "{text}");
        let denied = help(Path::new("/dev/ttyUSB0"), &io::ErrorKind::PermissionDenied.into());
        assert!(denied.contains("dialout") && denied.contains("udev"), "{denied}");
    }

    #[test]
    fn ports_are_listed_adapters_first() {
        let ports = ["/dev/ttyS0", "/dev/ttyUSB1", "/dev/ttyACM0"].map(Into::into);
        assert_eq!(
            not_there(&ports),
            "there is no such port. On USB there are: /dev/ttyUSB1, /dev/ttyACM0"
        );
        assert!(not_there(&ports[..1]).contains("/dev/ttyS0, none of them on USB"));
        assert!(not_there(&[]).contains("plugged in"));
    }
}
