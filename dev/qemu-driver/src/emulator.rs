//! Runs QEMU with the image of the node.

use std::collections::VecDeque;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use sinew_qemu_node::message::Bytes;

use super::error::QemuError;

/// The variable in which `cargo xtask node` puts the image's path.
pub const IMAGE: &str = "SINEW_NODE_IMAGE";

/// Time without output after which an image counts as stuck: answers take milliseconds.
const SILENT: Duration = Duration::from_secs(20);
const AT_ONCE: usize = 4096;

/// QEMU with the image of a node that waits for its power-on.
pub struct Emulator {
    from: Receiver<Vec<u8>>,
    /// Bytes that were received and not read yet.
    came: VecDeque<u8>,
    to: Box<dyn Write>,
    /// The process, if this value runs it.
    qemu: Option<Child>,
}

impl Emulator {
    /// Connects to a node that runs at the other end of two pipes.
    pub(super) fn over(mut from: impl Read + Send + 'static, to: impl Write + 'static) -> Self {
        let (give, take) = channel();
        // Reading a pipe has no time limit; reading a channel has. The thread ends with the pipe.
        thread::spawn(move || {
            let mut bytes = [0; AT_ONCE];
            while let Ok(len @ 1..) = from.read(&mut bytes) {
                if give.send(bytes[..len].to_vec()).is_err() {
                    break;
                }
            }
        });
        Self { from: take, came: VecDeque::new(), to: Box::new(to), qemu: None }
    }

    /// Starts QEMU with an image, until this value is dropped.
    ///
    /// # Errors
    /// [`QemuError`] says what to run.
    pub fn start(image: &Path) -> Result<Self, QemuError> {
        if !image.is_file() {
            return Err(QemuError::NoImage { path: image.to_owned(), variable: IMAGE });
        }
        let qemu = Command::new("qemu-system-arm")
            .args(["-machine", "mps2-an386", "-display", "none", "-monitor", "none"])
            .args(["-serial", "none", "-semihosting-config", "enable=on,target=native"])
            .arg("-kernel")
            .arg(image)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn();
        let mut qemu = qemu.map_err(|why| QemuError::NoQemu(why.into()))?;
        let pipes = qemu.stdout.take().zip(qemu.stdin.take());
        let (from, to) = pipes.expect("both are piped");
        let mut emulator = Self::over(from, to);
        emulator.qemu = Some(qemu);
        Ok(emulator)
    }

    /// Returns the error for an emulator that has ended.
    fn left(&mut self) -> QemuError {
        let status = self.qemu.as_mut().and_then(|qemu| qemu.wait().ok());
        QemuError::Left { status }
    }
}

impl Bytes for Emulator {
    type Error = QemuError;

    fn read(&mut self, bytes: &mut [u8]) -> Result<(), QemuError> {
        while self.came.len() < bytes.len() {
            match self.from.recv_timeout(SILENT) {
                Ok(more) => self.came.extend(more),
                Err(RecvTimeoutError::Timeout) => return Err(QemuError::Silent { image: IMAGE }),
                Err(RecvTimeoutError::Disconnected) => return Err(self.left()),
            }
        }
        // There are enough bytes.
        let _ = self.came.read_exact(bytes);
        Ok(())
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), QemuError> {
        self.to.write_all(bytes).map_err(|_| self.left())
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        if let Some(qemu) = &mut self.qemu {
            // The process may have ended by itself.
            let _ = qemu.kill();
            let _ = qemu.wait();
        }
    }
}
