//! QEMU with the image of the node.

use std::collections::VecDeque;
use std::env;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use sinew_qemu_node::message::Bytes;

use super::error::TwinError;

/// Names an image.
pub(super) const IMAGE: &str = "SINEW_NODE_IMAGE";
/// Where `cargo xtask node` puts one, in the folder of all that cargo builds.
const IN_TARGET: &str = "arm/thumbv7em-none-eabihf/firmware/node";

/// An answer takes milliseconds: an image that says nothing for so long waits for what this program never says.
const SILENT: Duration = Duration::from_secs(20);
const AT_ONCE: usize = 4096;

/// QEMU with the image of a node that waits for its power-on.
pub struct Emulator {
    from: Receiver<Vec<u8>>,
    /// What came, and was not read yet.
    came: VecDeque<u8>,
    to: Box<dyn Write>,
    /// Who runs it.
    qemu: Option<Child>,
}

impl Emulator {
    /// A node that somebody runs at the other end of two pipes.
    pub(super) fn over(mut from: impl Read + Send + 'static, to: impl Write + 'static) -> Self {
        let (give, take) = channel();
        // A read of a pipe has no time limit; that of a channel has. It ends with the pipe.
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

    /// Starts it. It ends with this value.
    ///
    /// # Errors
    /// [`TwinError`] says what to run.
    pub fn start() -> Result<Self, TwinError> {
        let path = image()?;
        let mut command = Command::new("qemu-system-arm");
        command
            .args(["-machine", "mps2-an386", "-display", "none", "-monitor", "none"])
            .args(["-serial", "none", "-semihosting-config", "enable=on,target=native"])
            .arg("-kernel")
            .arg(path)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped());
        // Ctrl-C on a terminal is for this program, which stops the rig by it.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut qemu = command.spawn().map_err(|why| TwinError::NoQemu(why.into()))?;
        let pipes = qemu.stdout.take().zip(qemu.stdin.take());
        let (from, to) = pipes.expect("both are piped");
        let mut emulator = Self::over(from, to);
        emulator.qemu = Some(qemu);
        Ok(emulator)
    }

    /// The other end says nothing more.
    fn left(&mut self) -> TwinError {
        let status = self.qemu.as_mut().and_then(|qemu| qemu.wait().ok());
        TwinError::Left { status }
    }
}

impl Bytes for Emulator {
    type Error = TwinError;

    fn read(&mut self, bytes: &mut [u8]) -> Result<(), TwinError> {
        while self.came.len() < bytes.len() {
            match self.from.recv_timeout(SILENT) {
                Ok(more) => self.came.extend(more),
                Err(RecvTimeoutError::Timeout) => return Err(TwinError::Silent { image: IMAGE }),
                Err(RecvTimeoutError::Disconnected) => return Err(self.left()),
            }
        }
        // There are as many.
        let _ = self.came.read_exact(bytes);
        Ok(())
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), TwinError> {
        self.to.write_all(bytes).map_err(|_| self.left())
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        if let Some(qemu) = &mut self.qemu {
            // It may have ended by itself.
            let _ = qemu.kill();
            let _ = qemu.wait();
        }
    }
}

/// The image that is named, or the one beside what cargo has built of this program.
fn image() -> Result<PathBuf, TwinError> {
    let built = || {
        let program = env::current_exe().unwrap_or_default();
        program.ancestors().nth(2).unwrap_or(Path::new("target")).join(IN_TARGET)
    };
    let path = env::var_os(IMAGE).map_or_else(built, PathBuf::from);
    if path.is_file() { Ok(path) } else { Err(TwinError::NoImage { path, variable: IMAGE }) }
}
