//! Exchanges packets with the servos on a line, and repeats questions that are not answered.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use sinew_servo_bus::dynamixel::{self, ErrorCode, StatusError};
use sinew_servo_bus::feetech::{self, Family};

use crate::ping_reply::{Miss, Pong};
use crate::reply::{ReceivedReply, Reply, replies};
use crate::{Exchange, Protocol, ServiceError};

/// Waiting times and repetitions for a client.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Maximum wait for a reply, in addition to the time of the bytes on the wire.
    pub patience: Duration,
    /// Number of attempts before a servo counts as silent.
    pub tries: u32,
}

impl Default for Settings {
    /// Returns three tries of 34 ms: a USB adapter holds bytes for up to 16 ms, and `dynamixel-sdk` waits twice that
    /// plus 2 ms.
    fn default() -> Self {
        Self { patience: Duration::from_millis(34), tries: 3 }
    }
}

/// A client for the servos on a line, with one protocol and one baud rate.
#[derive(Debug)]
pub struct Client<E> {
    line: E,
    protocol: Protocol,
    baud: u32,
    settings: Settings,
    /// Flag that a person or the system sets to end the program.
    stop: Option<Arc<AtomicBool>>,
    /// Whether the present work must be finished before a stop.
    is_whole: bool,
}

/// Bits of a byte on the wire, with start and stop bit.
const BITS: u64 = 10;
/// Maximum delay of a servo before it answers: Return Delay Time 254.
const RETURN_DELAY: Duration = Duration::from_micros(508);

impl<E: Exchange> Client<E> {
    /// Creates a client for this protocol and this baud rate, bits per second.
    ///
    /// # Errors
    /// [`ServiceError::Baud`] if the line does not support the rate.
    pub fn new(
        line: E,
        protocol: Protocol,
        baud: u32,
        settings: Settings,
    ) -> Result<Self, ServiceError> {
        let mut client = Self { line, protocol, baud, settings, stop: None, is_whole: false };
        client.set_baud(baud)?;
        Ok(client)
    }

    /// Makes the client end with [`ServiceError::Stopped`] after the flag is set. Even then, changes that a tool has
    /// made to servos are undone.
    pub fn stop_at(&mut self, flag: Arc<AtomicBool>) {
        self.stop = Some(flag);
    }

    /// Checks that the flag of [`Self::stop_at`] is not set.
    ///
    /// # Errors
    /// [`ServiceError::Stopped`] if it is set.
    pub fn ensure_going(&self) -> Result<(), ServiceError> {
        let is_set = |flag: &Arc<AtomicBool>| flag.load(Ordering::Relaxed);
        if !self.is_whole && self.stop.as_ref().is_some_and(is_set) {
            return Err(ServiceError::Stopped);
        }
        Ok(())
    }

    /// Runs `work` with the patience limited to `most`.
    pub(crate) fn with_patience<T>(
        &mut self,
        most: Duration,
        work: impl FnOnce(&mut Self) -> T,
    ) -> T {
        let before = self.settings.patience;
        self.settings.patience = before.min(most);
        let done = work(self);
        self.settings.patience = before;
        done
    }

    /// Runs `work` to its end, even if the stop flag is set.
    pub(crate) fn whole<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        let before = std::mem::replace(&mut self.is_whole, true);
        let done = work(self);
        self.is_whole = before;
        done
    }

    /// Returns the protocol.
    pub fn protocol(&self) -> Protocol {
        self.protocol
    }

    /// Returns the baud rate, bits per second.
    pub fn baud(&self) -> u32 {
        self.baud
    }

    /// Returns the line.
    pub fn line_mut(&mut self) -> &mut E {
        &mut self.line
    }

    /// Returns the line and ends the client.
    pub fn into_line(self) -> E {
        self.line
    }

    /// Changes the baud rate, bits per second.
    ///
    /// # Errors
    /// [`ServiceError::Baud`] if the line does not support the rate.
    pub fn set_baud(&mut self, baud: u32) -> Result<(), ServiceError> {
        self.line.set_baud(baud).map_err(|why| match why.kind() {
            // The cause of this error is not the rate.
            io::ErrorKind::ResourceBusy => why.into(),
            _ => ServiceError::Baud { baud, why },
        })?;
        self.baud = baud;
        Ok(())
    }

    pub(crate) fn set_protocol(&mut self, protocol: Protocol) {
        self.protocol = protocol;
    }

    pub(crate) fn pause(&mut self, time: Duration) {
        self.line.pause(time);
    }

    pub(crate) fn now(&mut self) -> Duration {
        self.line.now()
    }

    /// Asks once and waits until `enough` accepts the replies or the time is over. The time is the sum of the time of
    /// the bytes, the servo's delay, and `patience`.
    pub(crate) fn ask(
        &mut self,
        request: &[u8],
        reply_len: usize,
        patience: Duration,
        mut enough: impl FnMut(&[Reply]) -> bool,
    ) -> Result<ReceivedReply, ServiceError> {
        self.ensure_going()?;
        let wait = self.wait(request.len() + reply_len, patience);
        let (protocol, mut heard) = (self.protocol, Vec::new());
        self.line.exchange(request, wait, &mut |bytes| {
            heard.extend_from_slice(bytes);
            enough(&replies(protocol, request, &heard, false).replies)
        })?;
        Ok(replies(protocol, request, &heard, true))
    }

    /// Returns the time of `bytes` bytes in both directions, plus the servo's delay and `patience`.
    fn wait(&self, bytes: usize, patience: Duration) -> Duration {
        let bits = u64::try_from(bytes).unwrap_or(u64::MAX).saturating_mul(BITS * 1_000_000);
        Duration::from_micros(bits / u64::from(self.baud.max(1))) + RETURN_DELAY + patience
    }

    /// Waits for late answers to repeated questions: they would be taken for answers to the next question.
    fn forget(&mut self, questions: u32, bytes: usize) {
        if questions > 0 {
            let patience = self.settings.patience;
            self.line.pause(self.wait(bytes, patience) * questions + patience / 4);
        }
    }

    pub(crate) fn tries(&self) -> u32 {
        self.settings.tries
    }

    pub(crate) fn patience(&self) -> Duration {
        self.settings.patience
    }

    /// Returns the packet that reads bytes of a servo.
    fn read_request(&self, id: u8, address: u16, length: u16) -> Result<Vec<u8>, ServiceError> {
        packet(|out| match self.protocol {
            Protocol::Dynamixel => dynamixel::Instruction::Read { address, length }.encode(id, out),
            // This instruction has the same bytes for all families.
            Protocol::Feetech => {
                feetech::Instruction::Read { address: low(address), length: low(length) }.encode(
                    Family::Sts,
                    id,
                    out,
                )
            }
        })
    }

    /// Reads bytes and the error byte of a servo. Repeats the question after silence or damage.
    ///
    /// # Errors
    /// [`ServiceError::Silent`], [`ServiceError::Mute`], [`ServiceError::Noise`] or [`ServiceError::Refused`], by the
    /// answer of the servo; [`ServiceError::Line`] or [`ServiceError::Passing`] if the line failed;
    /// [`ServiceError::Stopped`] after a signal.
    pub fn read_bytes(
        &mut self,
        id: u8,
        address: u16,
        length: u16,
    ) -> Result<(Vec<u8>, u8), ServiceError> {
        let read = self.try_read(id, address, length, self.settings.tries)?;
        if read.is_err() {
            self.forget(self.settings.tries, usize::from(length) + 2 * OVERHEAD);
        }
        match read {
            Ok(reply) => Ok((reply.data, reply.error)),
            Err(Miss::Noise) => Err(ServiceError::Noise { id }),
            Err(Miss::Silence) if self.answers_ping(id)? => Err(ServiceError::Mute { id }),
            Err(Miss::Silence) => Err(ServiceError::Silent { id, baud: self.baud }),
        }
    }

    /// Reads bytes, but does not examine why an answer is missing.
    pub(crate) fn try_read(
        &mut self,
        id: u8,
        address: u16,
        length: u16,
        tries: u32,
    ) -> Result<Result<Reply, Miss>, ServiceError> {
        let request = self.read_request(id, address, length)?;
        let length = usize::from(length);
        self.until_answered(id, &request, length, tries, |reply| reply.data.len() == length)
    }

    fn until_answered(
        &mut self,
        id: u8,
        request: &[u8],
        reply_len: usize,
        tries: u32,
        fits: impl Fn(&Reply) -> bool,
    ) -> Result<Result<Reply, Miss>, ServiceError> {
        let protocol = self.protocol;
        let answers = |reply: &Reply| {
            reply.id == id && (fits(reply) || error_code(protocol, reply.error).is_some())
        };
        let mut miss = Miss::Silence;
        let patience = self.settings.patience;
        for before in 0..tries.max(1) {
            let heard = self.ask(request, reply_len + OVERHEAD, patience, |replies| {
                replies.iter().any(&answers)
            })?;
            let Some(reply) = heard.replies.into_iter().find(&answers) else {
                if heard.is_noisy {
                    miss = Miss::Noise;
                }
                continue;
            };
            self.forget(before, request.len() + reply_len + OVERHEAD);
            match error_code(protocol, reply.error) {
                // The question was damaged on the way to the servo.
                Some(ErrorCode::Crc) => miss = Miss::Noise,
                Some(code) => return Err(ServiceError::Refused { id, code }),
                None => return Ok(Ok(reply)),
            }
        }
        Ok(Err(miss))
    }

    fn answers_ping(&mut self, id: u8) -> Result<bool, ServiceError> {
        if self.protocol == Protocol::Feetech {
            // A Feetech is pinged by a read: see `ping`.
            return Ok(false);
        }
        Ok(self.ping(id, self.settings.tries)?.is_ok())
    }

    /// Returns model number and firmware of the servo with this id.
    ///
    /// A Feetech is asked for its first bytes instead of a ping: with an adapter that echoes, a ping would be its own
    /// answer.
    pub(crate) fn ping(&mut self, id: u8, tries: u32) -> Result<Result<Pong, Miss>, ServiceError> {
        match self.protocol {
            Protocol::Dynamixel => {
                let request = packet(|out| dynamixel::Instruction::Ping.encode(id, out))?;
                let reply =
                    self.until_answered(id, &request, 3, tries, |reply| reply.data.len() == 3)?;
                Ok(reply.and_then(|reply| Pong::of_dynamixel(&reply).ok_or(Miss::Noise)))
            }
            Protocol::Feetech => {
                let reply = self.try_read(id, 0, 5, tries)?;
                Ok(reply.and_then(|reply| Pong::of_feetech(&reply).ok_or(Miss::Noise)))
            }
        }
    }

    /// Sends a write packet and waits for its answer. Silence is not an error, because a setting of the servo decides
    /// whether it answers writes. The caller therefore reads the value back.
    pub(crate) fn send(&mut self, id: u8, request: &[u8]) -> Result<(), ServiceError> {
        self.until_answered(id, request, 0, 1, |reply| reply.data.is_empty()).map(|_| ())
    }
}

/// Bytes of a packet without its data: header, id, length, instruction, error, check, and a reserve for stuffing.
const OVERHEAD: usize = 16;

/// Encodes a packet.
pub(crate) fn packet(
    encode: impl FnOnce(&mut [u8]) -> Result<usize, sinew_servo_bus::EncodeError>,
) -> Result<Vec<u8>, ServiceError> {
    let mut out = vec![0; 64];
    let len = encode(&mut out)?;
    out.truncate(len);
    Ok(out)
}

/// Returns the error number of a Dynamixel's reply, or `None` if it has none. A Feetech never reports a reason.
fn error_code(protocol: Protocol, error: u8) -> Option<ErrorCode> {
    match protocol {
        Protocol::Dynamixel => StatusError::from_byte(error).code(),
        Protocol::Feetech => None,
    }
}

/// Converts an address or length to the one byte of a Feetech. All of its tables fit.
pub(crate) fn low(number: u16) -> u8 {
    u8::try_from(number).unwrap_or(u8::MAX)
}
