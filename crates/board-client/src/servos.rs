//! A controller as a line to its servos: it passes packets on while torque is off.

use std::io;
use std::time::Duration;

use sinew_link::message::{
    Applied, Command, PASS_LEAST_BAUD, PASS_MAX, PASS_WAIT_US, Pass, Passed, Refusal,
};
use sinew_servo_tools::Exchange;

use crate::{Board, ClientError, Line};

/// First minor version of the host link that has these messages.
const SINCE: u8 = 1;

/// A bus line of a controller's servos.
#[derive(Debug)]
pub struct BoardServos<L> {
    board: Board<L>,
    line: u8,
    baud: u32,
    took: Duration,
}

impl<L: Line> BoardServos<L> {
    /// Creates access to a bus line, first at the line's own rate. `line`: index, 0 for the first.
    ///
    /// # Errors
    /// [`ClientError::Old`] if the firmware does not pass packets on.
    pub fn new(board: Board<L>, line: u8) -> Result<Self, ClientError> {
        board.needs(SINCE)?;
        Ok(Self { board, line, baud: 0, took: Duration::ZERO })
    }

    /// Returns the controller.
    pub fn board_mut(&mut self) -> &mut Board<L> {
        &mut self.board
    }

    /// Returns the controller and ends the access.
    pub fn into_board(self) -> Board<L> {
        self.board
    }

    /// Returns the duration of the last exchange by the controller's clock, from the first sent to the last received
    /// byte; zero if no byte was received.
    pub fn took(&self) -> Duration {
        self.took
    }

    /// Switches the bus line back to its own rate.
    pub fn own_rate(&mut self) {
        self.baud = 0;
    }

    fn pass(&mut self, bytes: &[u8], wait: Duration) -> Result<Vec<u8>, ClientError> {
        let wait_us = u32::try_from(wait.as_micros()).unwrap_or(PASS_WAIT_US).min(PASS_WAIT_US);
        let bytes = bytes.try_into().map_err(|_| {
            ClientError::Refused(Refusal::Capacity {
                room: u32::try_from(PASS_MAX).unwrap_or(u32::MAX),
                needs: u32::try_from(bytes.len()).unwrap_or(u32::MAX),
            })
        })?;
        let pass = Pass { line: self.line, baud: self.baud, wait_us, bytes };
        let mut came: Vec<u8> = Vec::new();
        let mut command = Command::PassOn(pass);
        loop {
            let Applied::Passed(Passed { count, took_us, bytes }) = self.board.ask(command)? else {
                return Err(ClientError::Unexpected("packets for servos"));
            };
            self.took = Duration::from_micros(took_us.into());
            came.extend_from_slice(&bytes);
            if bytes.is_empty() || came.len() >= count.into() {
                return Ok(came);
            }
            let offset = u16::try_from(came.len()).unwrap_or(count);
            command = Command::ReadPassed { offset };
        }
    }
}

impl<L: Line> Exchange for BoardServos<L> {
    /// Passes bytes on and receives the answer. The controller listens for at most 20 ms after the last sent byte;
    /// later bytes are lost.
    fn exchange(
        &mut self,
        bytes: &[u8],
        wait: Duration,
        take: &mut dyn FnMut(&[u8]) -> bool,
    ) -> io::Result<()> {
        let came = self.pass(bytes, wait).map_err(explained)?;
        let _ = take(&came);
        Ok(())
    }

    fn set_baud(&mut self, baud: u32) -> io::Result<()> {
        let before = std::mem::replace(&mut self.baud, baud);
        // Sends no bytes: only tests whether the line supports this rate.
        let tried = self.pass(&[], Duration::ZERO);
        if tried.is_err() {
            self.baud = before;
        }
        tried.map(|_| ()).map_err(explained)
    }

    fn pause(&mut self, time: Duration) {
        // If the line has failed, the next exchange reports it.
        let _ = self.board.run(time);
    }
}

fn explained(error: ClientError) -> io::Error {
    let (kind, text) = match error {
        ClientError::Refused(Refusal::State(state)) => (
            io::ErrorKind::ResourceBusy,
            format!(
                "the rig is {state}: a controller passes packets on only while it is limp, off or faulted. Nothing was sent"
            ),
        ),
        ClientError::Refused(Refusal::Unsupported) => (
            io::ErrorKind::Unsupported,
            "the board has no such line of servos, or does not support this rate".to_owned(),
        ),
        ClientError::Refused(Refusal::Value) => (
            io::ErrorKind::InvalidInput,
            format!(
                "the board sends at most what fits in {} ms, and nothing below {PASS_LEAST_BAUD} bit/s. Nothing was \
                 sent",
                PASS_WAIT_US / 1000
            ),
        ),
        ClientError::Refused(Refusal::Fault(_)) => (
            io::ErrorKind::ResourceBusy,
            "the board has no rig, and so no line of servos: `sinew board upload rig` first"
                .to_owned(),
        ),
        other => (io::ErrorKind::ResourceBusy, other.to_string()),
    };
    io::Error::new(kind, text)
}
