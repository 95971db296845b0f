//! Waiting for Enter, while something else goes on.

use std::io;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};

use anyhow::bail;
use sinew_servo_tools::calibrate::LOOK_EVERY;

/// Lines of standard input.
pub(super) struct Prompt(Receiver<String>);

impl Prompt {
    /// Reads standard input from now on.
    pub(super) fn new() -> Self {
        let (sender, receiver) = mpsc::channel();
        std::thread::spawn(move || {
            for line in io::stdin().lines() {
                let Ok(line) = line else { break };
                if sender.send(line).is_err() {
                    break;
                }
            }
        });
        Self(receiver)
    }

    /// Does `meanwhile` again and again until a line comes.
    pub(super) fn enter(
        &self,
        mut meanwhile: impl FnMut() -> anyhow::Result<()>,
    ) -> anyhow::Result<String> {
        loop {
            meanwhile()?;
            match self.0.recv_timeout(LOOK_EVERY) {
                Ok(line) => return Ok(line),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    bail!("the input ended; what was not told to be done is not done")
                }
            }
        }
    }
}
