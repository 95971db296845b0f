//! Socket of a program that has no board but a simulated rig: other terminals can only stop the rig.

use std::io;
use std::sync::mpsc::{Receiver, sync_channel};

use super::{Door, Reply, Request, Role};
use crate::server::ToHub;

/// Maximum number of requests that wait.
const WAITING: usize = 8;

/// A socket that accepts stops and e-stops.
#[derive(Debug)]
pub struct Bell {
    _door: Door,
    inbox: Receiver<ToHub>,
    is_stopped: bool,
}

impl Bell {
    /// Opens the socket.
    ///
    /// # Errors
    /// An I/O error if the socket's folder does not belong to this user, or another program uses the name.
    pub fn open(name: &str) -> io::Result<Self> {
        let (requests, inbox) = sync_channel(WAITING);
        Ok(Self { _door: Door::open(name, requests)?, inbox, is_stopped: false })
    }

    /// Answers all waiting requests. Returns whether a stop has arrived since the socket was opened, and whether an
    /// e-stop has arrived since the last call.
    pub fn asked(&mut self) -> (bool, bool) {
        let mut is_cut = false;
        for message in self.inbox.try_iter() {
            let ToHub::Asked { request, answer, .. } = message else { continue };
            let (ok, text) = match request {
                Request::Stop => {
                    self.is_stopped = true;
                    (true, super::STOPS)
                }
                Request::EStop => {
                    is_cut = true;
                    (true, super::CUTS)
                }
                Request::Who => (true, Role::Simulates.name()),
                _ => (
                    false,
                    "refused: the rig is simulated by `sinew play`, and can only be stopped",
                ),
            };
            // If the asking command has ended, nobody receives the reply.
            let _ = answer.try_send(Reply { ok, text: text.to_owned() });
        }
        (self.is_stopped, is_cut)
    }
}
