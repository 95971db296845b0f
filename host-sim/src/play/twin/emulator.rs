//! QEMU with the image of the node.

use std::env;
use std::io::{BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use sinew_emulated::message::Bytes;

use super::error::TwinError;

/// Names an image.
pub(super) const IMAGE: &str = "SINEW_NODE_IMAGE";
/// Where `cargo xtask node` puts one, in the folder of all that cargo builds.
const IN_TARGET: &str = "arm/thumbv7em-none-eabihf/firmware/node";

/// QEMU with the image of a node that waits for its power-on.
pub struct Emulator {
    from: Box<dyn Read>,
    to: Box<dyn Write>,
    /// Who runs it.
    qemu: Option<Child>,
}

impl Emulator {
    /// A node that somebody runs at the other end of two pipes.
    pub(super) fn over(from: impl Read + 'static, to: impl Write + 'static) -> Self {
        Self { from: Box::new(BufReader::new(from)), to: Box::new(to), qemu: None }
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
        self.from.read_exact(bytes).map_err(|_| self.left())
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
