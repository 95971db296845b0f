//! Waits for Enter while other work continues.

use std::io;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};

use anyhow::bail;
use sinew_servo_tools::calibrate::LOOK_EVERY;

/// Lines of standard input, read by a thread.
pub(super) struct Prompt(Receiver<String>);

impl Prompt {
    /// Starts to read standard input.
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

    /// Repeats `meanwhile` until there is a line, and returns the line. Fails if the input ends.
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
                    bail!("the input ended; nothing more is done")
                }
            }
        }
    }
}
