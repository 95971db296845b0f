//! A command without pages that is the hub of its board: other terminals may watch and stop the rig.

use std::io;
use std::sync::mpsc::sync_channel;
use std::time::Duration;

use sinew_board_client::{Board, ClientError, Line};

use super::{Hub, Owner};
use crate::local::Door;
use crate::scene::Scene;

/// Maximum number of requests that wait for the hub.
const WAITING: usize = 32;

/// A board that belongs to a command. The command controls the board with [`Self::board_mut`], and must call
/// [`Self::step`] regularly.
#[derive(Debug)]
pub struct Hosted<'a, L> {
    // Drop order: the socket is removed before the port is closed.
    door: Option<Door>,
    hub: Hub<'a, L>,
    /// Number of faults in the board's log that were already sent to watching commands.
    faults: usize,
}

impl<'a, L: Line> Hosted<'a, L> {
    /// Starts to serve requests of other terminals, which reach the board by `name`. Without a name, no terminal can
    /// reach it.
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

    /// Returns the board, for commands to it.
    pub fn board_mut(&mut self) -> &mut Board<L> {
        self.hub.board
    }

    /// Executes requests of other terminals. Then receives messages of the board, and waits up to `wait` for them.
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

    /// Returns whether another terminal has stopped the rig with a stop or an e-stop.
    pub fn is_stopped(&self) -> bool {
        self.hub.asked.stopped
    }

    /// Returns whether another command has stopped the rig since the last call.
    pub fn take_stop(&mut self) -> bool {
        std::mem::take(&mut self.hub.asked.stopped)
    }

    /// Returns whether another command has asked for the port. Only an [`Owner::Watches`] gives its port up.
    pub fn yields(&self) -> bool {
        self.hub.asked.yields
    }

    /// Returns whether other terminals can reach the board.
    pub fn is_open(&self) -> bool {
        self.door.is_some()
    }
}
