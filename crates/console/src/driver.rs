//! The other end of a console for a program that drives like a page, over the Unix socket.

use std::collections::BTreeMap;
use std::io::{self, BufRead as _, BufReader, ErrorKind, Write as _};
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};

use serde::Deserialize;
use sinew_board_client::console::{Request, connect};

use crate::message::{FromPage, PageCommand};

/// Interval of messages that show that the program still runs. After 2 s without a message, the console holds the rig.
const PING_EVERY: Duration = Duration::from_millis(500);

/// A connection to a console. [`Self::step`] must be called regularly: it receives, and keeps the wheel.
#[derive(Debug)]
pub struct Driver {
    stream: BufReader<UnixStream>,
    line: Vec<u8>,
    start: Instant,
    pinged: Duration,
    asked: u64,
    answers: BTreeMap<u64, Result<String, String>>,
    drives: bool,
    slots: Vec<(u8, Option<[u8; 32]>)>,
}

/// Messages of the console that a program uses.
#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
enum Told {
    Answer {
        id: u64,
        ok: bool,
        text: String,
    },
    Role {
        driver: bool,
    },
    Shows {
        slots: Vec<Slot>,
    },
    #[serde(other)]
    Other,
}

#[derive(Deserialize)]
struct Slot {
    slot: u8,
    hash: Option<[u8; 32]>,
}

impl Driver {
    /// Connects to the console of this name. If nobody drives, this program then has the wheel.
    ///
    /// # Errors
    /// An I/O error if no such console runs, or it refuses.
    pub fn open(name: &str) -> io::Result<Self> {
        Ok(Self {
            stream: connect(name, &Request::Drive)?,
            line: Vec::new(),
            start: Instant::now(),
            pinged: Duration::ZERO,
            asked: 0,
            answers: BTreeMap::new(),
            drives: false,
            slots: Vec::new(),
        })
    }

    /// Returns the time since the connection was opened.
    pub fn now(&self) -> Duration {
        self.start.elapsed()
    }

    /// Returns whether this program has the wheel.
    pub fn drives(&self) -> bool {
        self.drives
    }

    /// Returns the slot that has a show with this SHA-256; `None` if the board does not have the show.
    pub fn slot_of(&self, hash: &[u8; 32]) -> Option<u8> {
        self.slots.iter().find(|(_, own)| own.as_ref() == Some(hash)).map(|(slot, _)| *slot)
    }

    /// Receives for at most `wait`. Before it, tells the console that the program still runs.
    ///
    /// # Errors
    /// An I/O error if the console has ended.
    pub fn step(&mut self, wait: Duration) -> io::Result<()> {
        if self.now() >= self.pinged + PING_EVERY {
            self.pinged = self.now();
            self.say(None, PageCommand::Ping { t: 0.0 })?;
        }
        // A time-out of 0 would be none at all.
        let wait = wait.max(Duration::from_millis(1));
        self.stream.get_ref().set_read_timeout(Some(wait))?;
        match self.stream.read_until(b'\n', &mut self.line) {
            Ok(_) if self.line.last() == Some(&b'\n') => self.take(),
            Ok(_) => Err(ErrorKind::UnexpectedEof.into()),
            // The part of the line that has arrived stays.
            Err(error)
                if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) =>
            {
                Ok(())
            }
            Err(error) => Err(error),
        }
    }

    fn take(&mut self) -> io::Result<()> {
        let told = serde_json::from_slice(&self.line).map_err(io::Error::other)?;
        self.line.clear();
        match told {
            Told::Answer { id, ok, text } => {
                self.answers.insert(id, if ok { Ok(text) } else { Err(text) });
            }
            Told::Role { driver } => self.drives = driver,
            Told::Shows { slots } => {
                self.slots = slots.into_iter().map(|own| (own.slot, own.hash)).collect();
            }
            Told::Other => {}
        }
        Ok(())
    }

    fn say(&mut self, id: Option<u64>, command: PageCommand) -> io::Result<()> {
        let mut text = serde_json::to_vec(&FromPage { id, command }).map_err(io::Error::other)?;
        text.push(b'\n');
        self.stream.get_ref().write_all(&text)
    }

    /// Sends a command. Returns its number, by which [`Self::answer`] finds the answer.
    ///
    /// # Errors
    /// An I/O error if the console has ended.
    pub fn ask(&mut self, command: PageCommand) -> io::Result<u64> {
        self.asked += 1;
        self.say(Some(self.asked), command)?;
        Ok(self.asked)
    }

    /// Sends the bytes of a show after [`PageCommand::Upload`].
    ///
    /// # Errors
    /// An I/O error if the console has ended.
    pub fn send_show(&mut self, show: &[u8]) -> io::Result<()> {
        self.stream.get_ref().write_all(show)
    }

    /// Takes the answer to a request, once it has arrived: the console's words.
    pub fn answer(&mut self, id: u64) -> Option<Result<String, String>> {
        self.answers.remove(&id)
    }
}
