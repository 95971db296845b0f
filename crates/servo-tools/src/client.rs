//! Who talks to servos on a line: packets, replies, and asking again.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use sinew_servo_bus::dynamixel::{self, ErrorCode, StatusError};
use sinew_servo_bus::feetech::{self, Family};

use crate::ping_reply::{Miss, Pong};
use crate::reply::{ReceivedReply, Reply, replies};
use crate::{Exchange, Protocol, ServiceError};

/// How patient one is with servos.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// How long to wait for a reply, beyond the bytes' time on the wire.
    pub patience: Duration,
    /// How often a servo is asked before it counts as silent.
    pub tries: u32,
}

impl Default for Settings {
    /// 34 ms: a USB adapter keeps bytes for up to 16 ms, and `dynamixel-sdk` waits twice that and 2 ms. Three times.
    fn default() -> Self {
        Self { patience: Duration::from_millis(34), tries: 3 }
    }
}

/// Talks to servos on a line, in one protocol at one rate.
#[derive(Debug)]
pub struct Client<E> {
    line: E,
    protocol: Protocol,
    baud: u32,
    settings: Settings,
    /// Set when a person, or the system, wants the program to end.
    stop: Option<Arc<AtomicBool>>,
    /// Whether something is under way that is finished first.
    is_whole: bool,
}

/// Bits of a byte on the wire, with start and stop.
const BITS: u64 = 10;
/// A servo waits so long at most before it answers, Return Delay Time 254.
const RETURN_DELAY: Duration = Duration::from_micros(508);

impl<E: Exchange> Client<E> {
    /// Talks this protocol at this rate, bits per second.
    ///
    /// # Errors
    /// [`ServiceError::Baud`] if the line does not do the rate.
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

    /// Ends what is under way with [`ServiceError::Stopped`] once the flag is set. What a tool has changed of servos is
    /// put back meanwhile, whatever the flag says.
    pub fn stop_at(&mut self, flag: Arc<AtomicBool>) {
        self.stop = Some(flag);
    }

    /// Refuses to go on once the flag of [`Self::stop_at`] is set.
    ///
    /// # Errors
    /// [`ServiceError::Stopped`].
    pub fn ensure_going(&self) -> Result<(), ServiceError> {
        let is_set = |flag: &Arc<AtomicBool>| flag.load(Ordering::Relaxed);
        if !self.is_whole && self.stop.as_ref().is_some_and(is_set) {
            return Err(ServiceError::Stopped);
        }
        Ok(())
    }

    /// Does something with no more patience than this.
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

    /// Does what must not end half-way.
    pub(crate) fn whole<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        let before = std::mem::replace(&mut self.is_whole, true);
        let done = work(self);
        self.is_whole = before;
        done
    }

    /// The protocol.
    pub fn protocol(&self) -> Protocol {
        self.protocol
    }

    /// The rate, bits per second.
    pub fn baud(&self) -> u32 {
        self.baud
    }

    /// The line.
    pub fn line_mut(&mut self) -> &mut E {
        &mut self.line
    }

    /// Gives the line back.
    pub fn into_line(self) -> E {
        self.line
    }

    /// Talks at another rate.
    ///
    /// # Errors
    /// [`ServiceError::Baud`] if the line does not do it.
    pub fn set_baud(&mut self, baud: u32) -> Result<(), ServiceError> {
        self.line.set_baud(baud).map_err(|why| match why.kind() {
            // The rate is not what is wrong.
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

    /// Asks once, until `enough` has come or the time is over: that of the bytes, the servo's delay, and `patience`.
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

    /// How long so many bytes take, there and back, and the patience beyond that.
    fn wait(&self, bytes: usize, patience: Duration) -> Duration {
        let bits = u64::try_from(bytes).unwrap_or(u64::MAX).saturating_mul(BITS * 1_000_000);
        Duration::from_micros(bits / u64::from(self.baud.max(1))) + RETURN_DELAY + patience
    }

    /// Waits for what is still to come of questions that were asked again: it would be taken for an answer to the next
    /// one.
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

    /// The packet that asks a servo for bytes.
    fn read_request(&self, id: u8, address: u16, length: u16) -> Result<Vec<u8>, ServiceError> {
        packet(|out| match self.protocol {
            Protocol::Dynamixel => dynamixel::Instruction::Read { address, length }.encode(id, out),
            // The order of bytes does not matter here.
            Protocol::Feetech => {
                feetech::Instruction::Read { address: low(address), length: low(length) }.encode(
                    Family::Sts,
                    id,
                    out,
                )
            }
        })
    }

    /// Bytes from an address of a servo, and its error byte, asking again where nothing or damage comes.
    ///
    /// # Errors
    /// [`ServiceError::Silent`], [`ServiceError::Mute`], [`ServiceError::Noise`] or [`ServiceError::Refused`].
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

    /// Reads without asking why there is no answer.
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
                // The question was damaged on its way.
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

    /// Who has this id: model number and firmware, as bytes.
    ///
    /// A Feetech is asked for its first bytes in place of a ping: an adapter that gives back what is sent would answer
    /// a ping by itself.
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

    /// Writes a packet and waits for its answer. Silence is no error: whether a servo answers to writes is one of its
    /// settings, so what it has is read back.
    pub(crate) fn send(&mut self, id: u8, request: &[u8]) -> Result<(), ServiceError> {
        self.until_answered(id, request, 0, 1, |reply| reply.data.is_empty()).map(|_| ())
    }
}

/// Header, id, length, instruction, error, check, and some for stuffing.
const OVERHEAD: usize = 16;

/// A packet of a codec.
pub(crate) fn packet(
    encode: impl FnOnce(&mut [u8]) -> Result<usize, sinew_servo_bus::EncodeError>,
) -> Result<Vec<u8>, ServiceError> {
    let mut out = vec![0; 64];
    let len = encode(&mut out)?;
    out.truncate(len);
    Ok(out)
}

/// Why a Dynamixel refuses. A Feetech does not say.
fn error_code(protocol: Protocol, error: u8) -> Option<ErrorCode> {
    match protocol {
        Protocol::Dynamixel => StatusError::from_byte(error).code(),
        Protocol::Feetech => None,
    }
}

/// Addresses and lengths of Feetech have one byte; all of its tables fit.
pub(crate) fn low(number: u16) -> u8 {
    u8::try_from(number).unwrap_or(u8::MAX)
}
