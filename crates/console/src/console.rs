//! The console as a program uses it: it opens the port for pages, returns the page's addresses, and runs the hub.

use std::io;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;

use sinew_board_client::{Board, ClientError, Line};

use crate::hub::{Ended, Hub, OwnShows, Owner, Records};
use crate::local::{Door, Reply, Request};
use crate::replay::{Player, Replay};
use crate::scene::Scene;
use crate::server::{Shared, ToHub, Token, accept, listen};

/// Maximum number of messages that wait for the hub. If more arrive, the threads of the pages wait.
const WAITING: usize = 256;

/// Options of a console.
#[derive(Debug, Clone, Copy, Default)]
pub struct Options {
    /// Address at which pages of other machines are served, too; `None`: only pages of this machine. A port of 0 stands
    /// for any free port.
    pub listen: Option<SocketAddr>,
    /// Whether pages of other machines may drive. Otherwise they may only watch, hold and stop.
    pub allow_drive: bool,
    /// Whether a show goes on while no page drives, or the driving page is silent.
    pub unattended: bool,
}

/// Executes a single request on a board that has no hub. A motion arms the rig, and stops it afterwards. Meanwhile,
/// other terminals reach the board by `name`, and may stop the rig.
///
/// # Errors
/// [`ClientError`] if the board does not answer.
pub fn execute<L: Line>(
    board: &mut Board<L>,
    scene: &Scene,
    (name, request): (&str, &Request),
    stops: &dyn Fn() -> u32,
) -> Result<Reply, ClientError> {
    let (requests, inbox) = sync_channel(WAITING);
    let _door = open_door(name, requests)?;
    let owner = Owner::Drives("board");
    Hub::new(board, scene, (owner, false), inbox).execute(request, stops)
}

fn open_door(name: &str, hub: SyncSender<ToHub>) -> Result<Door, ClientError> {
    Door::open(name, hub)
        .map_err(|error| ClientError::Impatient(format!("the socket for other commands: {error}")))
}

/// An open console: pages can connect, and then wait for the hub.
#[derive(Debug)]
pub struct Console {
    shared: Arc<Shared>,
    inbox: Receiver<ToHub>,
    options: Options,
    addresses: Vec<SocketAddr>,
    listeners: Vec<TcpListener>,
}

impl Console {
    /// Opens the port for pages, and creates a new token.
    ///
    /// # Errors
    /// An I/O error if the address cannot be used, or the system gives no random numbers.
    pub fn open(options: Options) -> io::Result<Self> {
        let listeners = listen(options.listen)?;
        let addresses = listeners.iter().map(TcpListener::local_addr).collect::<io::Result<_>>()?;
        let (hub, inbox) = sync_channel(WAITING);
        let shared = Shared::new(Token::random()?, hub, options.allow_drive);
        Ok(Self { shared: Arc::new(shared), inbox, options, addresses, listeners })
    }

    /// Returns the addresses of the page for a browser, each with the token. The first is for this machine.
    pub fn addresses(&self) -> Vec<String> {
        let token = self.shared.token.text();
        let of = |address: &SocketAddr| match (address.ip().is_unspecified(), address.port()) {
            (true, port) => format!("http://127.0.0.1:{port}/#{token}"),
            (false, _) => format!("http://{address}/#{token}"),
        };
        self.addresses.iter().map(of).collect()
    }

    /// Shows a recording to pages until `stops` counts a signal to end. `name`: name that pages show.
    ///
    /// # Errors
    /// [`ClientError::Line`] if the system has no threads.
    pub fn replay(
        self,
        replay: &Replay,
        (scene, name): (&Scene, &str),
        stops: &dyn Fn() -> u32,
    ) -> Result<(), ClientError> {
        let (served, inbox, _) = self.serve()?;
        Player::new(replay, scene, name).run(&inbox, stops);
        drop(served);
        Ok(())
    }

    /// Runs the hub of a board for pages and other commands, until `stops` counts a signal to end. At the first signal
    /// the rig is stopped, and the hub ends when torque is off; at the second signal the hub ends at once. `name`: name
    /// by which other commands reach the console; `records`: recordings of the session, with
    /// [`RECORD_HZ`](crate::RECORD_HZ) rows a second.
    ///
    /// # Errors
    /// [`ClientError`] if the board's line has failed.
    pub fn run<L: Line>(
        self,
        board: &mut Board<L>,
        scene: &Scene,
        (name, own, records): (&str, OwnShows, Records<'_>),
        stops: &dyn Fn() -> u32,
    ) -> Result<Ended, ClientError> {
        own.shows
            .iter()
            .filter_map(|show| show.sound.as_ref())
            .for_each(|own| self.shared.sounds.add(own));
        let slot = usize::try_from(board.about().capacities.slot_bytes).unwrap_or(usize::MAX);
        self.shared.show_bytes.store(slot, Ordering::Relaxed);
        let (served, inbox, options) = self.serve()?;
        let door = open_door(name, served.shared.hub.clone())?;
        let owner = (Owner::Console, options.unattended);
        let ended = Hub::new(board, scene, owner, inbox).run((own, records), stops);
        drop((door, served));
        ended
    }

    /// Starts to accept pages, until the returned [`Served`] is dropped.
    fn serve(self) -> Result<(Served, Receiver<ToHub>, Options), ClientError> {
        let Self { shared, inbox, options, addresses, listeners } = self;
        let served = Served { shared, addresses };
        for listener in listeners {
            let shared = Arc::clone(&served.shared);
            let builder = thread::Builder::new().name("pages".to_owned());
            builder.spawn(move || accept(&listener, &shared)).map_err(ClientError::Line)?;
        }
        Ok((served, inbox, options))
    }
}

/// A server that accepts pages until it is dropped.
struct Served {
    shared: Arc<Shared>,
    addresses: Vec<SocketAddr>,
}

impl Drop for Served {
    fn drop(&mut self) {
        self.shared.is_over.store(true, Ordering::Relaxed);
        // A connection wakes each listener, which then sees that the server is over.
        for address in &self.addresses {
            let _ = TcpStream::connect(address);
        }
    }
}
