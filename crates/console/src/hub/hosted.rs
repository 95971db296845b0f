//! A board whose hub is a command without pages: other terminals may watch and stop the rig meanwhile.

use std::io;
use std::sync::mpsc::sync_channel;
use std::time::Duration;

use sinew_board_client::{Board, ClientError, Line};

use super::{Hub, Owner};
use crate::local::Door;
use crate::scene::Scene;

/// Number of requests that wait for the command.
const WAITING: usize = 32;

/// A board that a command owns. The command drives it by [`Self::board_mut`], and calls [`Self::step`] all the time.
#[derive(Debug)]
pub struct Hosted<'a, L> {
    // The socket is removed before the port is closed.
    door: Option<Door>,
    hub: Hub<'a, L>,
    /// Number of faults of the board's log that watching commands know.
    faults: usize,
}

impl<'a, L: Line> Hosted<'a, L> {
    /// Begins to serve requests of other terminals, which know the board by `name`. Without a name, nobody reaches it.
    ///
    /// # Errors
    /// An I/O error of the socket.
    pub fn open(
        board: &'a mut Board<L>,
        scene: &'a Scene,
        owner: Owner,
        name: Option<&str>,
    ) -> io::Result<Self> {
        let (requests, inbox) = sync_channel(WAITING);
        let door = name.map(|name| Door::open(name, requests)).transpose()?;
        let faults = board.log.faults.len();
        Ok(Self { door, hub: Hub::new(board, scene, (owner, true), inbox), faults })
    }

    /// Returns the board.
    pub fn board(&self) -> &Board<L> {
        self.hub.board
    }

    /// Returns the board, to command it.
    pub fn board_mut(&mut self) -> &mut Board<L> {
        self.hub.board
    }

    /// Executes requests of other terminals, and receives messages of the board, waiting up to `wait`.
    ///
    /// # Errors
    /// As in [`Board::step`].
    pub fn step(&mut self, wait: Duration) -> Result<(), ClientError> {
        self.hub.take_messages();
        if let Some(error) = self.hub.failed.take() {
            return Err(error);
        }
        self.hub.board.step(wait)?;
        let faults = self.hub.board.log.faults.get(self.faults..).unwrap_or_default();
        self.hub.watchers.tell(self.hub.board, faults);
        self.faults += faults.len();
        Ok(())
    }

    /// Returns whether another terminal has stopped the rig, by a stop or an e-stop.
    pub fn is_stopped(&self) -> bool {
        self.hub.asked.stopped
    }

    /// Returns whether another terminal has stopped the rig since the last call.
    pub fn take_stop(&mut self) -> bool {
        std::mem::take(&mut self.hub.asked.stopped)
    }

    /// Returns whether another command wants the port. Only a hub that watches is asked.
    pub fn yields(&self) -> bool {
        self.hub.asked.yields
    }

    /// Returns whether other terminals can reach the board.
    pub fn is_open(&self) -> bool {
        self.door.is_some()
    }
}
