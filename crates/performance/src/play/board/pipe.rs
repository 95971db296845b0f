//! A line between a simulated board and a client in this program, in real time.

use std::io;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError, TrySendError};
use std::sync::mpsc::{Sender, channel, sync_channel};
use std::time::{Duration, Instant};

use super::serve::HostSide;

/// Rate of the line, bit/s: that of the NUCLEO's serial port.
const BAUD: u32 = 1_000_000;
/// Maximum number of chunks that wait for the host. Further output waits in the board, as at a port.
const CHUNKS: usize = 256;

/// The host's end of a pipe.
#[derive(Debug)]
pub struct HostEnd {
    to_board: Sender<Vec<u8>>,
    from_board: Receiver<Vec<u8>>,
    rest: Vec<u8>,
    start: Instant,
}

/// The board's end of a pipe.
#[derive(Debug)]
pub struct BoardEnd {
    to_host: SyncSender<Vec<u8>>,
    from_host: Receiver<Vec<u8>>,
    rest: Vec<u8>,
}

/// Creates a line of 1 Mbit/s between a client and a board that is served in another thread.
pub fn pipe() -> (HostEnd, BoardEnd) {
    let (to_board, from_host) = channel();
    let (to_host, from_board) = sync_channel(CHUNKS);
    let host = HostEnd { to_board, from_board, rest: Vec::new(), start: Instant::now() };
    (host, BoardEnd { to_host, from_host, rest: Vec::new() })
}

/// Moves as many bytes as fit.
fn take(rest: &mut Vec<u8>, into: &mut [u8]) -> usize {
    let count = into.len().min(rest.len());
    into.iter_mut().zip(rest.drain(..count)).for_each(|(to, byte)| *to = byte);
    count
}

fn closed() -> io::Error {
    io::ErrorKind::BrokenPipe.into()
}

impl sinew_board_client::Line for HostEnd {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.to_board.send(bytes.to_vec()).map_err(|_| closed())
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        if self.rest.is_empty() {
            match self.from_board.recv_timeout(wait) {
                Ok(bytes) => self.rest = bytes,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Err(closed()),
            }
        }
        Ok(take(&mut self.rest, into))
    }

    fn now(&self) -> Duration {
        self.start.elapsed()
    }
}

impl HostSide for BoardEnd {
    fn baud(&self) -> io::Result<u32> {
        Ok(BAUD)
    }

    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        loop {
            match self.from_host.try_recv() {
                Ok(bytes) => self.rest.extend(bytes),
                Err(TryRecvError::Empty) => return Ok(take(&mut self.rest, into)),
                Err(TryRecvError::Disconnected) => return Err(closed()),
            }
        }
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if bytes.is_empty() {
            return Ok(0);
        }
        match self.to_host.try_send(bytes.to_vec()) {
            Ok(()) => Ok(bytes.len()),
            Err(TrySendError::Full(_)) => Ok(0),
            Err(TrySendError::Disconnected(_)) => Err(closed()),
        }
    }
}
