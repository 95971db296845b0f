//! The console as a program uses it: it opens the port for pages, returns the page's addresses, and runs the hub.

use std::io;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;

use sinew_board_client::{Board, ClientError, Line};

use crate::hub::{Ended, Hub, OwnShow};
use crate::local::{Door, Reply, Request};
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

/// Executes a single command on a board that has no console. For a motion, arms the rig first and stops it afterwards.
///
/// # Errors
/// [`ClientError`] if the board does not answer.
pub fn execute<L: Line>(
    board: &mut Board<L>,
    scene: &Scene,
    request: &Request,
    stops: &dyn Fn() -> u32,
) -> Result<Reply, ClientError> {
    Hub::new(board, scene, false).execute(request, stops)
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

    /// Runs the hub of a board, which serves pages and other commands; the commands find the console by `name`. `stops`
    /// counts the signals to end. At the first signal, the hub stops the rig, and ends when torque is off. It ends at
    /// once at the second signal, if the board does not answer, or if torque is still on a minute later.
    ///
    /// # Errors
    /// [`ClientError`] if the board's line has failed.
    pub fn run<L: Line>(
        self,
        board: &mut Board<L>,
        scene: &Scene,
        (name, shows): (&str, Vec<OwnShow>),
        stops: &dyn Fn() -> u32,
    ) -> Result<Ended, ClientError> {
        let Self { shared, inbox, options, addresses, listeners } = self;
        shows.iter().filter_map(|show| show.sound.as_ref()).for_each(|own| shared.sounds.add(own));
        let slot = usize::try_from(board.about().capacities.slot_bytes).unwrap_or(usize::MAX);
        shared.show_bytes.store(slot, Ordering::Relaxed);
        for listener in listeners {
            let shared = Arc::clone(&shared);
            let builder = thread::Builder::new().name("pages".to_owned());
            builder.spawn(move || accept(&listener, &shared)).map_err(ClientError::Line)?;
        }
        let door = Door::open(name, shared.hub.clone()).map_err(|error| {
            ClientError::Impatient(format!("the socket for other commands: {error}"))
        })?;
        let ended = Hub::new(board, scene, options.unattended).run(shows, &inbox, stops);
        drop(door);
        shared.is_over.store(true, Ordering::Relaxed);
        // A connection wakes each listener, which then sees that the server is over.
        for address in addresses {
            let _ = TcpStream::connect(address);
        }
        ended
    }
}
